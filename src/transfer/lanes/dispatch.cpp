#include <stratus/runtime/instruction_set.h>

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

namespace {

#ifdef STRATUS_WIDE
constexpr PerInstructionSet<LaneMethods> all{&generic::methods, &avx2::methods, &avx512::methods};
#else
constexpr PerInstructionSet<LaneMethods> all{&generic::methods, nullptr, nullptr};
#endif

}  // namespace

const LaneMethods& lane_methods() { return all.chosen(); }

}  // namespace stratus
