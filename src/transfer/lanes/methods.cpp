#include "lanes.h"

namespace stratus::STRATUS_ISA {

void phase_kernels(const LanePhase& phase, LaneLayer& layer);
void thin_layer(LaneLayer& layer);
void use_gap(LaneLayer& layer);
void double_depth(LaneLayer& layer);
void extract(LaneLayer& layer);
void add_product(const LaneLayer& layer, double factor, const LaneFactors& of, Pack* out);

extern const LaneMethods methods;
const LaneMethods methods{phase_kernels, thin_layer, use_gap, double_depth, extract, add_product};

}  // namespace stratus::STRATUS_ISA
