#include <stratus/base/instruction_set.h>

#include "doubling_steps.h"

namespace stratus {

namespace avx512 {
extern const DoublingSteps<Pack> steps_of_packs;
extern const DoublingSteps<double> steps_of_one;
}  // namespace avx512
namespace avx2 {
extern const DoublingSteps<Pack> steps_of_packs;
extern const DoublingSteps<double> steps_of_one;
}  // namespace avx2
namespace generic {
extern const DoublingSteps<Pack> steps_of_packs;
extern const DoublingSteps<double> steps_of_one;
}  // namespace generic

namespace {

#ifdef STRATUS_WIDE
constexpr PerInstructionSet<DoublingSteps<Pack>> of_packs{
    &generic::steps_of_packs, &avx2::steps_of_packs, &avx512::steps_of_packs};
constexpr PerInstructionSet<DoublingSteps<double>> of_one{
    &generic::steps_of_one, &avx2::steps_of_one, &avx512::steps_of_one};
#else
constexpr PerInstructionSet<DoublingSteps<Pack>> of_packs{&generic::steps_of_packs, nullptr,
                                                          nullptr};
constexpr PerInstructionSet<DoublingSteps<double>> of_one{&generic::steps_of_one, nullptr, nullptr};
#endif

}  // namespace

template <>
const DoublingSteps<Pack>& doubling_steps() {
    return of_packs.chosen();
}

template <>
const DoublingSteps<double>& doubling_steps() {
    return of_one.chosen();
}

}  // namespace stratus
