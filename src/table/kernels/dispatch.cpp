#include <stratus/base/instruction_set.h>
#include <stratus/table/kernels/packed.h>

#include "vectors.h"

namespace stratus {

namespace avx512 {
extern const PackedKernels packed_kernels;
extern const VectorKernels vector_kernels;
}  // namespace avx512
namespace avx2 {
extern const PackedKernels packed_kernels;
extern const VectorKernels vector_kernels;
}  // namespace avx2
namespace generic {
extern const PackedKernels packed_kernels;
extern const VectorKernels vector_kernels;
}  // namespace generic

namespace {

#ifdef STRATUS_WIDE
constexpr PerInstructionSet<PackedKernels> all_packed{
    &generic::packed_kernels, &avx2::packed_kernels, &avx512::packed_kernels};
constexpr PerInstructionSet<VectorKernels> all_vectors{
    &generic::vector_kernels, &avx2::vector_kernels, &avx512::vector_kernels};
#else
constexpr PerInstructionSet<PackedKernels> all_packed{&generic::packed_kernels, nullptr, nullptr};
constexpr PerInstructionSet<VectorKernels> all_vectors{&generic::vector_kernels, nullptr, nullptr};
#endif

}  // namespace

const PackedKernels& packed_kernels() noexcept { return all_packed.chosen(); }

const VectorKernels& vector_kernels() noexcept { return all_vectors.chosen(); }

}  // namespace stratus
