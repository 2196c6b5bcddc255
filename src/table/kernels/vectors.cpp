#include "vectors.h"

#include "base/lanes.h"

namespace stratus::STRATUS_ISA {
namespace {

constexpr std::size_t registers = 4;  // so that an addition need not wait for the one before

/// Starts several results at 0, adds the elements to them by add(result, n), and joins them to one.
template <class Add, class Join>
float reduced(std::size_t count, const Add& add, const Join& join) {
    constexpr std::size_t width = lane_width;
    LookupLanes lanes[registers];
    for (LookupLanes& each : lanes) each = LookupLanes(0.0f);
    std::size_t n = 0;
    for (; n + registers * width <= count; n += registers * width)
        for (std::size_t r = 0; r < registers; ++r) lanes[r] = add(lanes[r], n + r * width);
    for (; n + width <= count; n += width) lanes[0] = add(lanes[0], n);
    float result = 0;
    for (; n < count; ++n) result = add(result, n);
    for (const LookupLanes& each : lanes)
        for (std::size_t k = 0; k < width; ++k) result = join(result, each.v[k]);
    return result;
}

float dot(const float* a, const float* b, std::size_t count) {
    return reduced(
        count,
        [=](auto sum, std::size_t n) {
            using F = decltype(sum);
            return sum + load<F>(a + n) * load<F>(b + n);
        },
        [](float x, float y) { return x + y; });
}

void subtract(float share, const float* from, float* to, std::size_t count) {
    std::size_t n = 0;
    for (; n + lane_width <= count; n += lane_width)
        store(load<LookupLanes>(to + n) - load<LookupLanes>(from + n) * share, to + n);
    for (; n < count; ++n) to[n] -= share * from[n];
}

float largest_product(const float* a, const float* b, std::size_t count) {
    return reduced(
        count,
        [=](auto largest, std::size_t n) {
            using F = decltype(largest);
            return maximum(largest, magnitude(load<F>(a + n) * load<F>(b + n)));
        },
        [](float x, float y) { return maximum(x, y); });
}

}  // namespace
}  // namespace stratus::STRATUS_ISA

namespace stratus {

template <>
const VectorKernels& functions_for<VectorKernels, InstructionSet::STRATUS_ISA>() noexcept {
    using namespace STRATUS_ISA;
    static constexpr VectorKernels vector_kernels{dot, subtract, largest_product};
    return vector_kernels;
}

}  // namespace stratus
