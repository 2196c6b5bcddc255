// Parts of `stratus bake`: finished work in a checkpoint, the ranks that mpirun or srun started, and sweeps.
#pragma once

#include <stratus/bake/bake.h>
#include <stratus/bake/ranks.h>
#include <stratus/io/checkpoint.h>

#include <CLI/CLI.hpp>

#include <functional>

namespace stratus {

/// Finds finished pieces in the checkpoint, which must outlive the log, and adds to it.
inline void keep_in(Checkpoint& checkpoint, WorkLog& log) {
    log.find = std::bind_front(&Checkpoint::find, &checkpoint);
    log.keep = std::bind_front(&Checkpoint::keep, &checkpoint);
}

inline std::string sentence_of_kept(const std::string& path) {
    return "finished work is kept in " + path + ": repeat the command with --resume";
}

/// Null where the program was started by itself.
///
/// Errors   std::runtime_error where it is one of several ranks and cannot reach the others.
std::unique_ptr<RankTransport> started_ranks();

/// One thread for each processor, which the ranks of a machine share.
int threads_of_rank(const RankTransport& ranks);

struct BakeCommand {
    std::string recipe;
    std::string output;  // of a sweep: the folder
    const CLI::Option* output_option = nullptr;
    std::string exr, h5;
    std::string sweep;  // CSV; empty: the rows of the recipe, if any
    int threads = 0;
    bool quiet = false;
    bool resume = false;  // of a sweep: bakes only what the folder lacks
    bool accept = false;  // exit code 0 even where tables miss their tolerances
    bool dry_run = false;
    double rank_timeout = 120;

    /// Files of all samples are written beside the output.
    bool keeps_samples() const { return !exr.empty() || !h5.empty(); }
};

/// Bakes all rows, several at once, and tells how each came out. On ranks each row is baked by one of them,
/// which rank 0 gives it to, and rank 0 writes its table.
///
/// Errors   std::invalid_argument for the rows, before anything is baked; std::runtime_error where a
///          table failed or missed its tolerance, once all are done; EndedBySignal where one came.
void run_sweep(const BakeCommand& command, Ranks* ranks = nullptr);

}  // namespace stratus
