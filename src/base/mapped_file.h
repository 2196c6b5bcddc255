// The bytes of a file, without copying them where the system can map files into memory.
#pragma once

#include <cstddef>
#include <string>

namespace stratus {

/// A regular file, open for reading until the end of its scope. It may be replaced or removed
/// meanwhile (stratus/io/file_bytes.h does no more), but not shortened: what is gone cannot be
/// read, and systems that map files end a program that tries.
class MappedFile {
  public:
    /// Errors   std::runtime_error "PATH: reason".
    explicit MappedFile(const std::string& path);
    MappedFile(MappedFile&& other) noexcept;
    MappedFile& operator=(MappedFile&& other) noexcept;
    ~MappedFile();

    /// Aligned to at least 64 bytes.
    const void* data() const noexcept { return data_; }
    std::size_t bytes() const noexcept { return bytes_; }

  private:
    void* data_ = nullptr;
    std::size_t bytes_ = 0;
};

}  // namespace stratus
