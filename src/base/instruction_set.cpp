#include <stratus/base/instruction_set.h>

#include <atomic>
#include <initializer_list>

#ifdef STRATUS_WIDE
#include <cpuid.h>
#endif

namespace stratus {

namespace {

std::atomic<InstructionSet> limit{InstructionSet::avx512};

#ifdef STRATUS_WIDE
/// Conversions of halves; not every compiler's __builtin_cpu_supports knows them by name. Asked once,
/// for under a hypervisor the processor takes microseconds to answer.
bool has_f16c() noexcept {
    static const bool has = [] {
        unsigned a, b, c, d;
        return __get_cpuid(1, &a, &b, &c, &d) != 0 && (c & bit_F16C) != 0;
    }();
    return has;
}
#endif

}  // namespace

const char* instruction_set_name(InstructionSet instruction_set) noexcept {
    constexpr const char* names[] = {"generic", "avx2", "avx512"};
    return names[static_cast<int>(instruction_set)];
}

bool is_available(InstructionSet instruction_set) noexcept {
#ifdef STRATUS_WIDE
    switch (instruction_set) {
        case InstructionSet::generic: return true;
        case InstructionSet::avx2:
            return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && has_f16c();
        case InstructionSet::avx512:
            return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                   has_f16c();
    }
#endif
    return instruction_set == InstructionSet::generic;
}

InstructionSet chosen_instruction_set() noexcept {
    for (const auto wide : {InstructionSet::avx512, InstructionSet::avx2})
        if (wide <= limit && is_available(wide)) return wide;
    return InstructionSet::generic;
}

InstructionSetLimit::InstructionSetLimit(InstructionSet widest) noexcept { limit = widest; }

InstructionSetLimit::~InstructionSetLimit() { limit = InstructionSet::avx512; }

}  // namespace stratus
