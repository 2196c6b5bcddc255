// Functions that are compiled once for each instruction set, and chosen when the program runs.
#pragma once

namespace stratus {

/// Each contains the ones before it.
enum class InstructionSet { generic, avx2, avx512 };

/// "generic", "avx2" or "avx512".
const char* instruction_set_name(InstructionSet instruction_set) noexcept;

/// True of generic; of avx2 with fma and f16c, and of avx512 with its forms for short vectors, where
/// this build and the processor have them.
bool is_available(InstructionSet instruction_set) noexcept;

/// The widest that is available and that no InstructionSetLimit excludes: what solvers and bound
/// tables use.
InstructionSet chosen_instruction_set() noexcept;

/// While it lives, nothing wider is chosen: for tests and benchmarks, one at a time. What was bound
/// before keeps its own.
class InstructionSetLimit {
  public:
    explicit InstructionSetLimit(InstructionSet widest) noexcept;
    ~InstructionSetLimit();
    InstructionSetLimit(const InstructionSetLimit&) = delete;
    InstructionSetLimit& operator=(const InstructionSetLimit&) = delete;
};

/// Returns the functions, a struct of pointers to them, of one instruction set, which a source that is
/// compiled for it defines.
template <class Functions, InstructionSet instruction_set>
const Functions& functions_for() noexcept;

/// Returns the functions of chosen_instruction_set().
template <class Functions>
const Functions& chosen_functions() noexcept {
#ifdef STRATUS_WIDE
    switch (chosen_instruction_set()) {
        case InstructionSet::avx512: return functions_for<Functions, InstructionSet::avx512>();
        case InstructionSet::avx2: return functions_for<Functions, InstructionSet::avx2>();
        case InstructionSet::generic: break;
    }
#endif
    return functions_for<Functions, InstructionSet::generic>();
}

}  // namespace stratus
