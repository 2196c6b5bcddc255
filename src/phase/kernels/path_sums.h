// Sums over orders of the path law (path_law.h), of many layers at once: compiled once for each
// instruction set.
#pragma once

#include <cstddef>

namespace stratus {

/// Rows of numbers over orders, each number twice: `columns` of them, 64 or more.
struct OrderRows {
    const float* value;
    std::size_t columns, orders;
};

struct PathSums {
    /// Weighted sums over the orders, of `rows` pairs of weights for each order: of the numbers in
    /// even columns with the first of each pair, in odd ones with the second; used[row] orders.
    void (*sums)(const OrderRows&, const float* weight, const int* used, std::size_t rows,
                 float* to);
};

/// For chosen_instruction_set().
const PathSums& path_sums() noexcept;

}  // namespace stratus
