// All instruction sets, for tests of code that is compiled for each, and the processor's mode for subnormals.
#pragma once

#include <stratus/base/instruction_set.h>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace stratus {

inline constexpr InstructionSet instruction_sets[] = {InstructionSet::generic, InstructionSet::avx2,
                                                      InstructionSet::avx512};

/// The name of a parameterised test's row.
inline constexpr auto instruction_set_row = [](const auto& row) {
    return instruction_set_name(row.param);
};

/// Takes subnormal floats for 0 while it lives, as some renderers have processors do; elsewhere than on x86
/// it does nothing.
class [[maybe_unused]] SubnormalsAsZero {
#if defined(__SSE2__)
  public:
    SubnormalsAsZero() { _mm_setcsr(before_ | 0x8040); }  // operands and results
    ~SubnormalsAsZero() { _mm_setcsr(before_); }
    SubnormalsAsZero(const SubnormalsAsZero&) = delete;
    SubnormalsAsZero& operator=(const SubnormalsAsZero&) = delete;

  private:
    unsigned before_ = _mm_getcsr();
#endif
};

}  // namespace stratus
