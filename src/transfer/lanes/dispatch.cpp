#include <cstring>

#include "lanes.h"

namespace stratus {

namespace avx512 {
extern const LaneMethods methods;
}
namespace avx2 {
extern const LaneMethods methods;
}
namespace generic {
extern const LaneMethods methods;
}

const LaneMethods* lane_methods(const char* instruction_set) {
#ifdef __x86_64__
    if (!std::strcmp(instruction_set, "avx512"))
        return __builtin_cpu_supports("avx512f") ? &avx512::methods : nullptr;
    if (!std::strcmp(instruction_set, "avx2"))
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? &avx2::methods
                                                                               : nullptr;
#endif
    return std::strcmp(instruction_set, "generic") ? nullptr : &generic::methods;
}

const LaneMethods& lane_methods() {
    if (const LaneMethods* widest = lane_methods("avx512")) return *widest;
    if (const LaneMethods* wide = lane_methods("avx2")) return *wide;
    return generic::methods;
}

}  // namespace stratus
