// What reading one file may take: counted before it is taken, so that a small file which claims to
// be a large one costs nothing but its refusal.
#pragma once

#include <cstdint>
#include <string>

namespace stratus::io {

/// Half of the machine's memory.
std::uintmax_t default_max_memory();

class MemoryLimit {
  public:
    /// `most` bytes; 0: the default.
    explicit MemoryLimit(std::uintmax_t most = 0) : most_(most ? most : default_max_memory()) {}

    /// Counts `bytes` more for `what`.
    ///
    /// Errors   std::runtime_error, naming what, the sum so far and the limit, once it is exceeded.
    void take(const std::string& what, std::uintmax_t bytes);

  private:
    std::uintmax_t most_;
    std::uintmax_t taken_ = 0;
};

}  // namespace stratus::io
