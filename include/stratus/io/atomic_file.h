// Output that appears whole or not at all: written beside its final name, flushed to the disk, then
// renamed.
#pragma once

#include <filesystem>
#include <functional>

namespace stratus {

/// Calls `write(temporary)` with a path in the same folder, makes what it wrote durable (fsync) and
/// renames it to `path`.
///
/// If `write` throws, or anything fails, the temporary file is removed, an older file at `path` is
/// left as it was, and the error goes on to the caller. A writer that was killed leaves its hidden
/// file; the next one at the same path removes it. A symbolic link at `path` stays; the file
/// that it leads to is replaced.
///
/// Errors   std::runtime_error "PATH: reason": missing or unwritable folder, full disk, a directory
///          or device in place of a file; also for a std::system_error that `write` throws.
void write_atomically(const std::filesystem::path& path,
                      const std::function<void(const std::filesystem::path& temporary)>& write);

}  // namespace stratus
