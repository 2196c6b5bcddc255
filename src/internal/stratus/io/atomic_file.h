// Files that appear complete or not at all: written under another name, flushed to disk, then
// renamed.
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>
#include <vector>

namespace stratus {

/// When a file is flushed to disk: before it takes its place, or with others, by flush_files. Until
/// then a power cut may leave it empty or incomplete, even where it replaced an older one.
enum class Flush { at_once, later };

/// Calls `write(temporary)` with a path in the same folder, flushes the file to disk (fsync) unless
/// that is left for later, and renames it to `path`.
///
/// If `write` throws or anything fails, the temporary file is removed, an existing file at `path`
/// is unchanged, and the caller gets the error. A killed writer leaves a hidden file, which the
/// next writer of the same path removes. If `path` is a symbolic link, its target is replaced, or
/// created if it does not exist.
///
/// Errors   std::runtime_error "PATH: reason": missing or unwritable folder, full disk, `path` is a
///          directory or device, or names an open file (/dev/stdout); also for a std::system_error
///          that `write` throws.
void write_atomically(const std::filesystem::path& path,
                      const std::function<void(const std::filesystem::path& temporary)>& write,
                      Flush flush = Flush::at_once);

/// Writes content from memory, all of it or nothing.
void write_content_atomically(const std::filesystem::path& path, std::string_view content,
                              Flush flush = Flush::at_once);
inline void write_content_atomically(const std::filesystem::path& path,
                                     const std::vector<char>& content,
                                     Flush flush = Flush::at_once) {
    write_content_atomically(path, std::string_view(content.data(), content.size()), flush);
}

/// True of a device, a pipe or an open file (/dev/stdout), which take what comes and stay.
bool takes_what_comes(const std::filesystem::path& path);

/// Writes `content` to the file at `path`, for `write` above to call.
///
/// Errors   std::system_error with the system's reason, such as a full disk.
void write_content(const std::filesystem::path& path, std::string_view content);

/// Flushes files of one folder to disk, and their names.
///
/// Errors   std::runtime_error "PATH: reason".
void flush_files(const std::vector<std::filesystem::path>& paths);

}  // namespace stratus
