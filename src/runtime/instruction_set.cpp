#include <stratus/runtime/instruction_set.h>

namespace stratus {

bool processor_has(InstructionSet instruction_set) noexcept {
#if defined(__x86_64__) && defined(__GNUC__)
    switch (instruction_set) {
        case InstructionSet::generic: return true;
        case InstructionSet::avx2:
            return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
        case InstructionSet::avx512:
            return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl");
    }
#endif
    return instruction_set == InstructionSet::generic;
}

}  // namespace stratus
