#include <stratus/runtime/instruction_set.h>

#include "doubling_steps.h"

namespace stratus {

namespace avx512 {
extern const DoublingSteps steps;
}
namespace avx2 {
extern const DoublingSteps steps;
}
namespace generic {
extern const DoublingSteps steps;
}

namespace {

#ifdef STRATUS_WIDE
constexpr PerInstructionSet<DoublingSteps> all{&generic::steps, &avx2::steps, &avx512::steps};
#else
constexpr PerInstructionSet<DoublingSteps> all{&generic::steps, nullptr, nullptr};
#endif

}  // namespace

const DoublingSteps& doubling_steps() { return all.chosen(); }

}  // namespace stratus
