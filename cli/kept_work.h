// Finished work: pieces of a bake, kept in its checkpoint.
#pragma once

#include <stratus/bake/work_log.h>
#include <stratus/io/checkpoint.h>

#include <span>
#include <string>

namespace stratus {

/// Finds finished pieces in the checkpoint, which must outlive the log, and adds to it.
inline void keep_in(Checkpoint& checkpoint, WorkLog& log) {
    log.find = [&](const std::string& piece) { return checkpoint.find(piece); };
    log.keep = [&](const std::string& piece, std::span<const char> result) {
        checkpoint.keep(piece, result);
    };
}

inline std::string sentence_of_kept(const std::string& path) {
    return "finished work is kept in " + path + ": repeat the command with --resume";
}

}  // namespace stratus
