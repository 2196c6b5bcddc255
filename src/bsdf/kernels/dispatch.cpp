#include <stratus/base/instruction_set.h>

#include "kernels.h"

namespace stratus {

namespace avx512 {
extern const Kernels kernels;
}  // namespace avx512
namespace avx2 {
extern const Kernels kernels;
}  // namespace avx2
namespace generic {
extern const Kernels kernels;
}  // namespace generic

namespace {

#ifdef STRATUS_WIDE
constexpr PerInstructionSet<Kernels> all_kernels{&generic::kernels, &avx2::kernels,
                                                 &avx512::kernels};
#else
constexpr PerInstructionSet<Kernels> all_kernels{&generic::kernels, nullptr, nullptr};
#endif

}  // namespace

const Kernels& kernels() noexcept { return all_kernels.chosen(); }

}  // namespace stratus
