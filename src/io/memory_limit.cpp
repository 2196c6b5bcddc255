#include <stratus/io/memory_limit.h>

#include <stratus/base/number_text.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <unistd.h>

namespace stratus::io {
namespace {

std::string mebibytes(std::uintmax_t bytes) {
    return short_number(static_cast<double>(bytes) / (1 << 20), 4) + " MiB";
}

}  // namespace

std::uintmax_t default_max_memory() {
    const long pages = ::sysconf(_SC_PHYS_PAGES);
    const long page = ::sysconf(_SC_PAGESIZE);
    if (pages <= 0 || page <= 0) return std::numeric_limits<std::uintmax_t>::max();
    return static_cast<std::uintmax_t>(pages) * static_cast<std::uintmax_t>(page) / 2;
}

void MemoryLimit::take(const std::string& what, std::uintmax_t bytes) {
    if (bytes > max_bytes_ - taken_)
        throw std::runtime_error("reading " + what + " needs " +
                                 mebibytes(taken_ + std::min(bytes, UINTMAX_MAX - taken_)) +
                                 " of memory in total, more than the limit of " +
                                 mebibytes(max_bytes_));
    taken_ += bytes;
}

}  // namespace stratus::io
