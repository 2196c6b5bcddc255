// Arithmetic of long vectors, where the time of packing goes: compiled once for each instruction set.
#pragma once

#include <stratus/base/instruction_set.h>

#include <cstddef>
#include <vector>

namespace stratus {

struct VectorKernels {
    /// Sum of a[n] b[n].
    float (*dot)(const float* a, const float* b, std::size_t count);
    /// to[n] -= share from[n].
    void (*subtract)(float share, const float* from, float* to, std::size_t count);
    /// The largest |a[n] b[n]|.
    float (*largest_product)(const float* a, const float* b, std::size_t count);
};

/// For chosen_instruction_set().
const VectorKernels& vector_kernels() noexcept;

// Counterparts for vectors of one size.

inline float dot(const std::vector<float>& a, const std::vector<float>& b) {
    return vector_kernels().dot(a.data(), b.data(), a.size());
}
inline void subtract(float share, const std::vector<float>& from, std::vector<float>& to) {
    vector_kernels().subtract(share, from.data(), to.data(), to.size());
}
inline float largest_product(const std::vector<float>& a, const std::vector<float>& b) {
    return vector_kernels().largest_product(a.data(), b.data(), a.size());
}

}  // namespace stratus
