#include "blocks.h"

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
/// One term of a product of series (ordered_ladder.h).
template <class Number>
void add_product(const SimdLayer<Number>& layer, double factor, const ProductFactors<Number>& of,
                 Number* out) {
    const int n = layer.directions;
    const long stride = layer.stride;
    if (of.F && of.G) {
        auto blocks = [&]<int I, int J>(Register<Number> in, int i0, int j0, Tile<I, J>) {
            Word sum[I][J] = {};
            accumulate(in, layer.gauss, of.F + i0, stride, of.G + j0, stride, 1.0, sum);
            for (int i = 0; i < I; ++i)
                for (int j = 0; j < J; ++j)
                    in(out, (i0 + i) * stride + j0 + j * in.columns) += factor * sum[i][j];
        };
        for_each_block<Number>(
            n, n, [](int) { return 0; }, blocks);
    }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const long at = i * stride + j;
            if (of.F_diagonal && of.G) out[at] += factor * (of.F_diagonal[i] * of.G[at]);
            if (of.F && of.G_diagonal) out[at] += factor * (of.F[at] * of.G_diagonal[j]);
        }
}

}  // namespace stratus::STRATUS_ISA

namespace stratus {
namespace {

template <class Number>
constexpr DoublingSteps<Number> all_steps{
    STRATUS_ISA::phase_kernels<Number>, STRATUS_ISA::thin_layer<Number>,
    STRATUS_ISA::use_gap<Number>,       STRATUS_ISA::double_depth<Number>,
    STRATUS_ISA::extract<Number>,       STRATUS_ISA::decouple<Number>,
    STRATUS_ISA::couple<Number>,        STRATUS_ISA::add_product<Number>};

}  // namespace

template <>
const DoublingSteps<Pack>&
functions_for<DoublingSteps<Pack>, InstructionSet::STRATUS_ISA>() noexcept {
    return all_steps<Pack>;
}

template <>
const DoublingSteps<double>&
functions_for<DoublingSteps<double>, InstructionSet::STRATUS_ISA>() noexcept {
    return all_steps<double>;
}

}  // namespace stratus
