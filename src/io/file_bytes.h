// Whole files as bytes: tables are coded in memory, so on the disk only the system can fail, and it
// says why.
#pragma once

#include "memory_limit.h"

#include <cstdint>
#include <exception>
#include <filesystem>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace stratus::io {

using Bytes = std::vector<char>;

/// The bytes of the regular file `path`, which begins with `magic`; `kind` names what such a file
/// is called. Its size counts towards the limit.
///
/// Errors   std::system_error for what the system refuses, std::runtime_error for a file that is no
/// `kind` or too large.
Bytes read_bytes(const std::filesystem::path& path, std::string_view magic, const std::string& kind,
                 MemoryLimit& limit);

/// Makes `bytes` the content of `path`.
///
/// Errors   std::system_error.
void write_bytes(const std::filesystem::path& path, std::span<const char> bytes);

/// An open file or folder, closed at the end of its scope.
class Descriptor {
  public:
    /// Errors   std::system_error.
    Descriptor(const std::filesystem::path& path, int flags);
    Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    ~Descriptor();
    Descriptor& operator=(Descriptor&&) = delete;

    int number() const noexcept { return number_; }

    /// Fills `bytes` from a place in the file; what it lacks at the end of the file is an error.
    void read_at(std::uint64_t offset, std::span<char> bytes) const;
    void write_at(std::uint64_t offset, std::span<const char> bytes) const;

    /// Holds the file for as long as it is open here; false where another has it. File systems that
    /// know no locks let everyone pass.
    bool lock() const;

    /// Whether `path` still is this file.
    bool is_still_at(const std::filesystem::path& path) const;

    /// Waits until the disk holds what was written.
    void flush() const;

    /// Closes now, because some file systems report a full disk only then.
    void close();

  private:
    int number_;
};

/// Calls `work`; whatever it throws goes on as std::runtime_error "PATH: reason".
template <class Work>
auto naming(const std::filesystem::path& path, const Work& work) {
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

}  // namespace stratus::io
