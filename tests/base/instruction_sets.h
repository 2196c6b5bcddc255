// All instruction sets, for tests of code that is compiled for each.
#pragma once

#include <stratus/base/instruction_set.h>

namespace stratus {

inline constexpr InstructionSet instruction_sets[] = {InstructionSet::generic, InstructionSet::avx2,
                                                      InstructionSet::avx512};

/// The name of a parameterised test's row.
inline constexpr auto instruction_set_row = [](const auto& row) {
    return instruction_set_name(row.param);
};

}  // namespace stratus
