#include "doubling_steps.h"

namespace stratus::STRATUS_ISA {

template <class Number>
void phase_kernels(const PhaseSeries<Number>& phase, SimdLayer<Number>& layer);
template <class Number>
void thin_layer(SimdLayer<Number>& layer);
template <class Number>
void use_gap(SimdLayer<Number>& layer);
template <class Number>
void double_depth(SimdLayer<Number>& layer);
template <class Number>
void extract(SimdLayer<Number>& layer);
template <class Number>
bool decouple(const SimdLayer<Number>& whole, SimdGroups<Number>& groups);
template <class Number>
void couple(const SimdGroups<Number>& groups, SimdLayer<Number>& whole);
template <class Number>
void add_product(const SimdLayer<Number>& layer, double factor, const ProductFactors<Number>& of,
                 Number* out);

template <class Number>
constexpr DoublingSteps<Number> all_steps{
    phase_kernels<Number>, thin_layer<Number>, use_gap<Number>, double_depth<Number>,
    extract<Number>,       decouple<Number>,   couple<Number>,  add_product<Number>};

extern const DoublingSteps<Pack> steps_of_packs;
extern const DoublingSteps<double> steps_of_one;
const DoublingSteps<Pack> steps_of_packs = all_steps<Pack>;
const DoublingSteps<double> steps_of_one = all_steps<double>;

}  // namespace stratus::STRATUS_ISA
