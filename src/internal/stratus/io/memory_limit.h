// The memory that reading one file may use, counted before it is allocated: a small file that
// claims to be a large one is refused at no cost.
#pragma once

#include <cstdint>
#include <string>

namespace stratus::io {

/// Half of the machine's memory.
std::uintmax_t default_max_memory();

class MemoryLimit {
  public:
    /// 0: the default.
    explicit MemoryLimit(std::uintmax_t max_bytes = 0)
        : max_bytes_(max_bytes ? max_bytes : default_max_memory()) {}

    /// Counts `bytes` more, which reading `what` needs.
    ///
    /// Errors   std::runtime_error with the total and the limit if it is exceeded.
    void take(const std::string& what, std::uintmax_t bytes);

  private:
    std::uintmax_t max_bytes_;
    std::uintmax_t taken_ = 0;
};

}  // namespace stratus::io
