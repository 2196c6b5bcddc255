// A file in memory with a path, for readers that take a path.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <sys/mman.h>
#include <unistd.h>

namespace stratus::test {

class MemoryFile {
  public:
    MemoryFile(const std::uint8_t* data, std::size_t size) : number_(::memfd_create("input", 0)) {
        if (number_ < 0 || ::write(number_, data, size) != static_cast<ssize_t>(size)) std::abort();
    }
    ~MemoryFile() { ::close(number_); }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;

    std::string name() const { return "/proc/self/fd/" + std::to_string(number_); }

  private:
    int number_;
};

}  // namespace stratus::test
