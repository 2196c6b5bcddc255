#include <stratus/runtime/instruction_set.h>

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

namespace {

#ifdef STRATUS_WIDE
constexpr PerInstructionSet<Kernels> all{&generic::kernels, &avx2::kernels, &avx512::kernels};
#else
constexpr PerInstructionSet<Kernels> all{&generic::kernels, nullptr, nullptr};
#endif

}  // namespace

const Kernels& kernels() noexcept { return all.chosen(); }

}  // namespace stratus
