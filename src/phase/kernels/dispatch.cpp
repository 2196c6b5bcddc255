#include <stratus/base/instruction_set.h>

#include "sums.h"

namespace stratus {

namespace avx512 {
extern const PathSums path_sums;
extern const SphereSums sphere_sums;
}  // namespace avx512
namespace avx2 {
extern const PathSums path_sums;
extern const SphereSums sphere_sums;
}  // namespace avx2
namespace generic {
extern const PathSums path_sums;
extern const SphereSums sphere_sums;
}  // namespace generic

namespace {

#ifdef STRATUS_WIDE
constexpr PerInstructionSet<PathSums> all_path_sums{&generic::path_sums, &avx2::path_sums,
                                                    &avx512::path_sums};
constexpr PerInstructionSet<SphereSums> all_sphere_sums{&generic::sphere_sums, &avx2::sphere_sums,
                                                        &avx512::sphere_sums};
#else
constexpr PerInstructionSet<PathSums> all_path_sums{&generic::path_sums, nullptr, nullptr};
constexpr PerInstructionSet<SphereSums> all_sphere_sums{&generic::sphere_sums, nullptr, nullptr};
#endif

}  // namespace

const PathSums& path_sums() noexcept { return all_path_sums.chosen(); }

const SphereSums& sphere_sums() noexcept { return all_sphere_sums.chosen(); }

}  // namespace stratus
