// Whole files, as bytes and as text. Tables are encoded in memory, so that only the system can fail on the disk,
// and it says why.
#pragma once

#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <istream>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace stratus {

namespace fs = std::filesystem;

namespace io {

using Bytes = std::vector<char>;

/// Half of the machine's memory.
std::uintmax_t default_max_memory();

/// The memory that reading one file may use, counted before it is allocated: a small file that claims
/// to be a large one is refused at no cost.
class MemoryLimit {
  public:
    /// 0: the default.
    explicit MemoryLimit(std::uintmax_t max_bytes)
        : max_bytes_(max_bytes ? max_bytes : default_max_memory()) {}

    /// Counts `bytes` more, which reading `what` needs.
    ///
    /// Errors   std::runtime_error with the total and the limit if it is exceeded.
    void take(const std::string& what, std::uintmax_t bytes);

  private:
    std::uintmax_t max_bytes_;
    std::uintmax_t taken_ = 0;
};

/// The bytes of the regular file `path`, which must begin with `magic`; messages call such a file
/// `kind` ("an HDF5"). Its size counts towards the limit.
///
/// Errors   std::system_error from the system; std::runtime_error for another kind of file or one
///          beyond the limit.
Bytes read_bytes(const fs::path& path, std::string_view magic, const std::string& kind,
                 MemoryLimit& limit);

/// An open file or folder, closed at the end of its scope.
class Descriptor {
  public:
    /// Errors   std::system_error.
    Descriptor(const fs::path& path, int flags);

    /// A new file without a name in a folder, which goes when it is closed. Errors as above.
    static Descriptor unnamed_in(const fs::path& folder);

    Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    ~Descriptor();
    Descriptor& operator=(Descriptor&&) = delete;

    int number() const noexcept { return number_; }

    /// Reads all of `bytes` at an offset; reaching the end of the file is an error.
    void read_at(std::uint64_t offset, std::span<char> bytes) const;
    void write_at(std::uint64_t offset, std::span<const char> bytes) const;

    /// Cuts the file off after `size` bytes, or fills it up with zeros.
    void resize(std::uint64_t size) const;

    /// Locks the file until it is closed; false if it is locked already. Always succeeds on file
    /// systems without locks.
    bool lock() const;

    /// Whether `path` still names this file.
    bool is_still_at(const fs::path& path) const;

    /// Waits until everything written is on the disk.
    void flush() const;

    /// Closes it now and reports failure: some file systems report a full disk only then.
    void close();

  private:
    explicit Descriptor(int number) noexcept : number_(number) {}

    int number_;
};

/// Calls `work` and rethrows what it throws as std::runtime_error "PATH: reason".
template <class Work>
auto naming(const fs::path& path, const Work& work) {
    try {
        return work();
    } catch (const std::system_error& error) {
        throw std::runtime_error(path.string() + ": " + error.code().message());
    } catch (const std::bad_alloc&) {
        throw std::runtime_error(path.string() + ": not enough memory");
    } catch (const std::exception& error) {
        throw std::runtime_error(path.string() + ": " + error.what());
    }
}

}  // namespace io

// Text that people write, read whole: recipes, scenes, rows.

/// Most bytes of a recipe or a scene, of a line of rows, and of anything that comes through a pipe
/// or from a device, which need not end.
constexpr std::uint64_t max_text = std::uint64_t{64} << 20;

/// A whole file, or what comes through a pipe or from a device; waits for somebody to write into a pipe
/// of that name.
///
/// Errors   std::runtime_error "PATH: cannot be read"; "PATH: must have at most 67108864 bytes, got
///          more".
std::string read_text(const fs::path& path);

/// The next line, of at most `max_text` bytes: false at the end, and bad() where the stream
/// cannot be read. A longer one is cut after one byte more, to be refused.
bool read_line(std::istream& stream, std::string& line);

// Files that appear complete or not at all: written under another name, flushed to disk, then
// renamed.

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
void write_atomically(const fs::path& path,
                      const std::function<void(const fs::path& temporary)>& write,
                      Flush flush = Flush::at_once);

/// Writes content from memory, all of it or nothing.
void write_content_atomically(const fs::path& path, std::span<const char> content,
                              Flush flush = Flush::at_once);

/// True of a device, a pipe or an open file (/dev/stdout), which take what comes and stay.
bool takes_what_comes(const fs::path& path);

/// Writes `content` to the file at `path`, for `write` above to call.
///
/// Errors   std::system_error with the system's reason, such as a full disk.
void write_content(const fs::path& path, std::span<const char> content);

/// Flushes files of one folder to disk, and their names.
///
/// Errors   std::runtime_error "PATH: reason".
void flush_files(const std::vector<fs::path>& paths);

}  // namespace stratus
