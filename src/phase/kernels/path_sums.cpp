#include "base/lanes.h"
#include "sums.h"

#include <algorithm>
#include <cstdint>

namespace stratus {
namespace {

/// Two numbers again and again.
STRATUS_INLINE LookupLanes::Floats repeated_pair(const float* pair) {
    using Pairs = std::int64_t __attribute__((vector_size(4 * lane_width)));
    std::int64_t both;
    __builtin_memcpy(&both, pair, sizeof both);
    return reinterpret_cast<LookupLanes::Floats>(Pairs{} + both);
}

void sums(const OrderRows& of, const float* weight, const int* used, std::size_t rows, float* to) {
    constexpr std::size_t width = lane_width, registers = 4, block = registers * width;
    for (std::size_t done = 0; done < of.columns; done += block) {
        const std::size_t first = std::min(done, of.columns - block);  // the last two overlap
        for (std::size_t row = 0; row < rows; ++row) {
            LookupLanes::Floats sum[registers] = {};
            const float* pair = weight + 2 * row * of.orders;
            const float* order = of.value + first;
            for (int n = 0; n < used[row]; ++n, pair += 2, order += of.columns) {
                const LookupLanes::Floats both = repeated_pair(pair);
                for (std::size_t r = 0; r < registers; ++r) {
                    LookupLanes::Floats values;
                    __builtin_memcpy(&values, order + r * width, sizeof values);
                    sum[r] += both * values;
                }
            }
            __builtin_memcpy(to + row * of.columns + first, sum, sizeof sum);
        }
    }
}

}  // namespace

template <>
const PathSums& functions_for<PathSums, InstructionSet::STRATUS_ISA>() noexcept {
    static constexpr PathSums path_sums{sums};
    return path_sums;
}

}  // namespace stratus
