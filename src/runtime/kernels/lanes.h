// Floats side by side in one wide register: what light.h asks of its type F.
#pragma once

#include <cstdint>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include <stratus/runtime/light.h>

namespace stratus {
namespace {

#if defined(__AVX512F__)
constexpr int lane_width = 16;
#elif defined(__AVX2__)
constexpr int lane_width = 8;
#else
constexpr int lane_width = 4;
#endif

#define STRATUS_INLINE [[gnu::always_inline]] inline

using FloatLanes = float __attribute__((vector_size(4 * lane_width)));
using IntLanes = std::int32_t __attribute__((vector_size(4 * lane_width)));

struct Ints {
    IntLanes v;
};

struct Floats {
    FloatLanes v;
    Floats() = default;
    STRATUS_INLINE explicit Floats(float x) : v(x - FloatLanes{}) {}
    STRATUS_INLINE explicit Floats(FloatLanes x) : v(x) {}
};

STRATUS_INLINE Floats operator+(Floats a, Floats b) { return Floats(a.v + b.v); }
STRATUS_INLINE Floats operator-(Floats a, Floats b) { return Floats(a.v - b.v); }
STRATUS_INLINE Floats operator*(Floats a, Floats b) { return Floats(a.v * b.v); }
STRATUS_INLINE Floats operator/(Floats a, Floats b) { return Floats(a.v / b.v); }
STRATUS_INLINE Floats operator+(Floats a, float b) { return Floats(a.v + b); }
STRATUS_INLINE Floats operator-(Floats a, float b) { return Floats(a.v - b); }
STRATUS_INLINE Floats operator*(Floats a, float b) { return Floats(a.v * b); }
STRATUS_INLINE Floats operator-(float a, Floats b) { return Floats(a - b.v); }
STRATUS_INLINE Floats operator/(float a, Floats b) { return Floats(a / b.v); }

STRATUS_INLINE Ints operator+(Ints a, Ints b) { return {a.v + b.v}; }
STRATUS_INLINE Ints operator*(Ints a, Ints b) { return {a.v * b.v}; }
STRATUS_INLINE Ints operator+(Ints a, int b) { return {a.v + b}; }
STRATUS_INLINE Ints operator*(Ints a, int b) { return {a.v * b}; }
STRATUS_INLINE Ints operator/(Ints a, int b) { return {a.v / b}; }

STRATUS_INLINE Floats larger(Floats a, Floats b) { return Floats(a.v > b.v ? a.v : b.v); }
STRATUS_INLINE Floats smaller(Floats a, Floats b) { return Floats(a.v < b.v ? a.v : b.v); }
STRATUS_INLINE Floats where_less(Floats a, Floats b, Floats yes, Floats no) {
    return Floats(a.v < b.v ? yes.v : no.v);
}
STRATUS_INLINE Ints truncated(Floats x) { return {__builtin_convertvector(x.v, IntLanes)}; }
STRATUS_INLINE Floats as_float(Ints n) { return Floats(__builtin_convertvector(n.v, FloatLanes)); }
STRATUS_INLINE Floats power_of_half(Ints n) {
    return Floats(reinterpret_cast<FloatLanes>((127 - n.v) << 23));
}

STRATUS_INLINE Floats root(Floats x) {
#if defined(__AVX512F__)
    return Floats(FloatLanes(_mm512_maskz_sqrt_ps(0xffff, x.v)));
#elif defined(__AVX2__)
    return Floats(FloatLanes(_mm256_sqrt_ps(x.v)));
#elif defined(__x86_64__)
    return Floats(FloatLanes(_mm_sqrt_ps(x.v)));
#else
    FloatLanes y;
    for (int k = 0; k < lane_width; ++k) y[k] = __builtin_sqrtf(x.v[k]);
    return Floats(y);
#endif
}

STRATUS_INLINE Floats gathered(const float* samples, Ints index) {
#if defined(__AVX512F__)
    return Floats(FloatLanes(_mm512_i32gather_ps(__m512i(index.v), samples, 4)));
#elif defined(__AVX2__)
    return Floats(FloatLanes(_mm256_i32gather_ps(samples, __m256i(index.v), 4)));
#else
    FloatLanes y;
    for (int k = 0; k < lane_width; ++k) y[k] = samples[index.v[k]];
    return Floats(y);
#endif
}

STRATUS_INLINE Neighbours<Floats> neighbours(const float* samples, Ints index, int stride) {
    return {gathered(samples, index), gathered(samples + stride, index)};
}

}  // namespace
}  // namespace stratus
