#include "doubling_steps.h"

namespace stratus::STRATUS_ISA {

void phase_kernels(const PhaseSeries& phase, SimdLayer& layer);
void thin_layer(SimdLayer& layer);
void use_gap(SimdLayer& layer);
void double_depth(SimdLayer& layer);
void extract(SimdLayer& layer);
bool decouple(const SimdLayer& whole, SimdGroups& groups);
void couple(const SimdGroups& groups, SimdLayer& whole);
void add_product(const SimdLayer& layer, double factor, const ProductFactors& of, Pack* out);

extern const DoublingSteps steps;
const DoublingSteps steps{phase_kernels, thin_layer, use_gap, double_depth,
                          extract,       decouple,   couple,  add_product};

}  // namespace stratus::STRATUS_ISA
