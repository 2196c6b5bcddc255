// TABLE.checkpoint: what a long bake has finished, kept beside the table until that is whole.
//
// Pieces of work are appended as they are finished, each with its checksum. However the program
// ends, a piece is there or it is not: one that was cut off, and whatever comes behind damage, is
// dropped when the checkpoint is opened next. What the system had not written to the disk when the
// power went is lost, and done again.
//
// The file is "stratus-checkpoint 1\n", then records: crc32 of all that follows in the record,
// length of the name (32 bits), length of the bytes (64 bits), name, bytes; little-endian. The
// first two, `program` and `recipe`, say what it is a checkpoint of.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace stratus {

/// What finished work belongs to: other work has no use for it.
struct CheckpointOwner {
    std::string program;
    std::string recipe;  // all choices that results depend on, line by line
};

class Checkpoint {
  public:
    /// Opens the checkpoint at `path`, or begins one, and holds it for as long as this lives.
    ///
    /// Errors   std::runtime_error "PATH: reason": another process holds it, still after a second;
    ///          of another recipe or program, or no checkpoint at all, which are left as they are;
    ///          what the system refuses.
    Checkpoint(const std::filesystem::path& path, const CheckpointOwner& owner);

    /// Closes it. One that holds no finished piece is removed.
    ~Checkpoint();
    Checkpoint(const Checkpoint&) = delete;
    Checkpoint& operator=(const Checkpoint&) = delete;

    /// Finished pieces, those that were found on opening and those kept since.
    std::size_t pieces() const;

    /// What came of a piece that was found on opening.
    ///
    /// Errors   std::runtime_error "PATH: reason".
    /// Threads  any number, as for `keep`.
    std::optional<std::vector<char>> find(const std::string& piece) const;

    /// Adds a finished piece. Where the disk is full all is given up, so that there is room for the
    /// table: work goes on, and `trouble` tells.
    void keep(const std::string& piece, std::span<const char> result);

    /// Why nothing is kept any more, "PATH: reason"; empty while all is.
    std::string trouble() const;

    /// Removes it, for the work is done.
    void remove();

  private:
    struct File;
    std::unique_ptr<File> file_;
};

}  // namespace stratus
