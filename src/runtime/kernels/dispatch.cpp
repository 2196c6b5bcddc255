#include <cstring>

#include "kernels.h"

namespace stratus {

namespace avx512 {
extern const Kernels kernels;
}
namespace avx2 {
extern const Kernels kernels;
}
namespace generic {
extern const Kernels kernels;
}

const Kernels* kernels(const char* instruction_set) noexcept {
#ifdef STRATUS_WIDE_KERNELS
    if (!std::strcmp(instruction_set, "avx512"))
        return __builtin_cpu_supports("avx512f") ? &avx512::kernels : nullptr;
    if (!std::strcmp(instruction_set, "avx2"))
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? &avx2::kernels
                                                                               : nullptr;
#endif
    return std::strcmp(instruction_set, "generic") ? nullptr : &generic::kernels;
}

const Kernels& kernels() noexcept {
    if (const Kernels* widest = kernels("avx512")) return *widest;
    if (const Kernels* wide = kernels("avx2")) return *wide;
    return generic::kernels;
}

}  // namespace stratus
