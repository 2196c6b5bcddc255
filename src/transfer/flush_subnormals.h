// Numbers below 2.2e-308 taken as 0 while a solution is made.
//
// Modes of high order fall off as sin^m towards the normal. Their matrices are full of subnormal
// numbers there, which processors handle a hundred times more slowly and no result contains.
#pragma once

#ifdef __SSE2__
#include <immintrin.h>
#endif

namespace stratus {

/// In this thread, until the end of its life; not for depths so small or large that R or T is subnormal.
class FlushSubnormals {
  public:
#ifdef __SSE2__
    explicit FlushSubnormals(double depth) : before_(_mm_getcsr()) {
        constexpr unsigned flush_to_zero = 1u << 15, denormals_are_zero = 1u << 6;
        if (depth > 1e-150 && depth < 1e150)
            _mm_setcsr(before_ | flush_to_zero | denormals_are_zero);
    }
    ~FlushSubnormals() { _mm_setcsr(before_); }
    FlushSubnormals(const FlushSubnormals&) = delete;
    FlushSubnormals& operator=(const FlushSubnormals&) = delete;

  private:
    const unsigned before_;
#else
    explicit FlushSubnormals(double) {}  // not trivial: no compiler calls it unused
#endif
};

}  // namespace stratus
