// Functions that are compiled once for each instruction set, and chosen when the program runs.
#pragma once

#include <cstring>

namespace stratus {

enum class InstructionSet { generic, avx2, avx512 };

/// True for generic, for avx2 with fma, and for avx512 with its forms for short vectors where the
/// processor has them.
bool processor_has(InstructionSet instruction_set) noexcept;

/// The same functions for each instruction set; null for one that this build lacks.
template <class Functions>
struct PerInstructionSet {
    const Functions* generic;
    const Functions* avx2;
    const Functions* avx512;

    /// For the widest instruction set that the processor has.
    const Functions& widest() const noexcept {
        if (has_avx512()) return *avx512;
        return has_avx2() ? *avx2 : *generic;
    }

    /// For "generic", "avx2" or "avx512"; null when the processor or this build lacks it, and for
    /// any other name.
    const Functions* named(const char* name) const noexcept {
        if (!std::strcmp(name, "avx512")) return has_avx512() ? avx512 : nullptr;
        if (!std::strcmp(name, "avx2")) return has_avx2() ? avx2 : nullptr;
        return std::strcmp(name, "generic") ? nullptr : generic;
    }

  private:
    bool has_avx512() const noexcept {
        return avx512 != nullptr && processor_has(InstructionSet::avx512);
    }
    bool has_avx2() const noexcept {
        return avx2 != nullptr && processor_has(InstructionSet::avx2);
    }
};

}  // namespace stratus
