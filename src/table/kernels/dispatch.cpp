#include <stratus/base/instruction_set.h>

#include "packed.h"

namespace stratus {

namespace avx512 {
extern const PackedKernels packed_kernels;
}  // namespace avx512
namespace avx2 {
extern const PackedKernels packed_kernels;
}  // namespace avx2
namespace generic {
extern const PackedKernels packed_kernels;
}  // namespace generic

namespace {

#ifdef STRATUS_WIDE
constexpr PerInstructionSet<PackedKernels> all_packed{
    &generic::packed_kernels, &avx2::packed_kernels, &avx512::packed_kernels};
#else
constexpr PerInstructionSet<PackedKernels> all_packed{&generic::packed_kernels, nullptr, nullptr};
#endif

}  // namespace

const PackedKernels& packed_kernels() noexcept { return all_packed.chosen(); }

}  // namespace stratus
