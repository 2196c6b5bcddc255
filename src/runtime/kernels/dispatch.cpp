#include <stratus/runtime/instruction_set.h>

#include "kernels.h"
#include "sphere_sums.h"

namespace stratus {

namespace avx512 {
extern const Kernels kernels;
extern const SphereSums sphere_sums;
}  // namespace avx512
namespace avx2 {
extern const Kernels kernels;
extern const SphereSums sphere_sums;
}  // namespace avx2
namespace generic {
extern const Kernels kernels;
extern const SphereSums sphere_sums;
}  // namespace generic

namespace {

#ifdef STRATUS_WIDE
constexpr PerInstructionSet<Kernels> all{&generic::kernels, &avx2::kernels, &avx512::kernels};
constexpr PerInstructionSet<SphereSums> all_sums{&generic::sphere_sums, &avx2::sphere_sums,
                                                 &avx512::sphere_sums};
#else
constexpr PerInstructionSet<Kernels> all{&generic::kernels, nullptr, nullptr};
constexpr PerInstructionSet<SphereSums> all_sums{&generic::sphere_sums, nullptr, nullptr};
#endif

}  // namespace

const Kernels& kernels() noexcept { return all.chosen(); }

const SphereSums& sphere_sums() noexcept { return all_sums.chosen(); }

}  // namespace stratus
