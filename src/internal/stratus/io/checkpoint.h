// TABLE.checkpoint: the finished pieces of a long bake, kept beside the table until it is complete.
//
// Each piece is appended when it is finished, with its checksum. If the program ends halfway, the
// truncated piece, and everything after a damaged one, is dropped when the checkpoint is next
// opened. Pieces that the system had not yet written to disk at a power failure are lost and done
// again.
//
// The file is "stratus-checkpoint 1\n", then records, little-endian: crc32 of the rest of the
// record, length of the name (32 bits), length of the content (64 bits), name, content. The first
// two records, `program` and `recipe`, identify the owner.
#pragma once

#include <stratus/io/file_bytes.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace stratus {

/// The program and recipe that pieces were computed with; they are valid for no other.
struct CheckpointOwner {
    std::string program;
    std::string recipe;  // all settings that results depend on, one a line
};

class Checkpoint {
  public:
    /// Opens the checkpoint at `path`, or creates it, and keeps it locked until destroyed.
    ///
    /// Errors   std::runtime_error "PATH: reason": still locked by another process after a second;
    ///          of another recipe or program, or not a checkpoint (the file is left unchanged);
    ///          errors of the system.
    Checkpoint(const fs::path& path, const CheckpointOwner& owner);

    /// Closes it, and removes the file if it has no finished pieces.
    ~Checkpoint();
    Checkpoint(const Checkpoint&) = delete;
    Checkpoint& operator=(const Checkpoint&) = delete;

    /// Number of finished pieces, found on opening or kept since.
    std::size_t pieces() const;

    /// The result of a piece that was found on opening.
    ///
    /// Errors   std::runtime_error "PATH: reason".
    /// Threads  any number, as for `keep`.
    std::optional<std::vector<char>> find(const std::string& piece) const;

    /// Adds a finished piece. If the disk is full, the file is emptied to leave room for the table,
    /// nothing is kept from then on, and `trouble` says so.
    void keep(const std::string& piece, std::span<const char> result);

    /// Why pieces are no longer kept, "PATH: reason"; empty while they are.
    std::string trouble() const;

    /// Removes the file, once the work is done.
    void remove();

  private:
    bool find_records();
    bool find_record(std::uint64_t size);
    void begin(const CheckpointOwner& owner);
    void put(std::initializer_list<std::span<const char>> parts);
    void truncate(std::uint64_t at);

    struct Content {
        std::uint64_t offset, size;
    };

    const fs::path path_;
    const io::Descriptor file_;
    std::unordered_map<std::string, Content> contents_;  // of the records found on opening
    std::uint64_t end_ = 0;                              // of the last complete record
    std::size_t finished_ = 0;
    std::string trouble_;
    mutable std::mutex mutex_;
};

}  // namespace stratus
