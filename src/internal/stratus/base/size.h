// A number of elements, or the place of one, as the standard library counts them.
#pragma once

#include <cstddef>

namespace stratus {

constexpr std::size_t size(std::ptrdiff_t n) { return static_cast<std::size_t>(n); }

/// How many elements there are, as an int.
template <class All>
constexpr int int_size(const All& all) {
    return static_cast<int>(all.size());
}

}  // namespace stratus
