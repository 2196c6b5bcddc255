// Doubling as an arithmetic-harmonic mean, and the extraction of R and T.
//
// Light in a layer is the sum of a part symmetric and a part antisymmetric about the mid-plane. Two
// symmetric positive matrices, Y and Z, describe the two parts (T with the beam on its diagonal):
//
//     R + T = (I + Y)^-1 (I - Y)        R - T = (I + Z)^-1 (I - Z)
//
// Adding two equal layers, tanh 2x and coth 2x, is one step of the arithmetic-harmonic mean:
//
//     Z' = (Z + Y)/2        Y' = 2 (Z^-1 + Y^-1)^-1 = 2 Y - Y Z'^-1 Y
//
// In thick layers Y and Z converge; there the gap G = Z - Y is carried in place of Y, and T keeps
// its relative accuracy at any depth:
//
//     Z' = Z - G/2          G' = (1/4) G Z'^-1 G          T = (I + Y)^-1 G (I + Z)^-1
//
// Mode 0 conserves energy: the light absorbed under uniform illumination, a = Y s, is known exactly
// at the start and doubles as a' = Z Z'^-1 a; the matrices are corrected to it after every step.
#include "congruence.h"

namespace stratus::STRATUS_ISA {

template <class Number>
void absorb_uniform(const SimdLayer<Number>& layer, Number* out) {
    apply(layer, layer.has_gap ? layer.Z : layer.Y, layer.uniform, out);
    if (!layer.has_gap) return;
    Number* gap = layer.vector[2];
    apply(layer, layer.Y, layer.uniform, gap);
    for (int i = 0; i < layer.directions; ++i) out[i] -= gap[i];
}

template <class Number>
void restore_absorption(SimdLayer<Number>& layer) {
    const int N = layer.gauss, n = layer.directions;
    const Number* s = layer.uniform;
    Number* e = layer.vector[1];
    absorb_uniform(layer, e);
    Number ss{}, es{};
    for (int i = 0; i < N; ++i) ss += s[i] * s[i];
    for (int i = 0; i < n; ++i) e[i] = layer.conserving * (layer.absorbed[i] - e[i]) / ss;
    for (int i = 0; i < N; ++i) es += e[i] * s[i];
    es /= ss;
    Number* K = (layer.has_gap ? layer.Z : layer.Y).K;
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j)
            K[i * layer.stride + j] += e[i] * s[j] + s[i] * e[j] - es * s[i] * s[j];
    for (int i = N; i < n; ++i)
        for (int j = 0; j < N; ++j) {
            const Number change = e[i] * s[j];
            K[i * layer.stride + j] += change;
            K[j * layer.stride + i] += change;
        }
}

namespace {

/// Z <- own Z + x Y, diagonal and kernel.
template <class Number>
void add_to_Z(SimdLayer<Number>& layer, double own, double x) {
    const int n = layer.directions;
    for (int i = 0; i < n; ++i) {
        layer.Z.d[i] = own * layer.Z.d[i] + x * layer.Y.d[i];
        for (long at = i * layer.stride; at < i * layer.stride + n; ++at)
            layer.Z.K[at] = own * layer.Z.K[at] + x * layer.Y.K[at];
    }
}

}  // namespace

template <class Number>
void use_gap(SimdLayer<Number>& layer) {
    const int n = layer.directions;
    for (int i = 0; i < n; ++i) {
        layer.Y.d[i] = layer.gap_diagonal[i];
        for (long at = i * layer.stride; at < i * layer.stride + n; ++at)
            layer.Y.K[at] = layer.Z.K[at] - layer.Y.K[at];
    }
    layer.has_gap = true;
}

template <class Number>
void double_depth(SimdLayer<Number>& layer) {
    const int n = layer.directions;
    SimdMatrix<Number>&Y = layer.Y, &Z = layer.Z;
    if (layer.has_gap)
        add_to_Z(layer, 1.0, -0.5);
    else
        add_to_Z(layer, 0.5, 0.5);

    Number* Yu = layer.vector[1];  // Y Z'^-1 a
    for (int i = 0; i < n; ++i) Yu[i] = layer.absorbed[i];
    const Scaled<Number> of{1.0, Y};
    eliminate_for(layer, of, Z, layer.any_conserving ? Yu : nullptr);
    if (layer.any_conserving)  // a' = Z Z'^-1 a with the old Z = 2 Z' - Y, or Z' + G/2
        for (int i = 0; i < n; ++i)
            layer.absorbed[i] =
                layer.has_gap ? layer.absorbed[i] + 0.5 * Yu[i] : 2.0 * layer.absorbed[i] - Yu[i];
    if (layer.has_gap)
        congruence_kernel(layer, of, Z, Y.K,
                          [](Register<Number>, int, int, Word value) { return 0.25 * value; });
    else
        congruence_kernel(layer, of, Z, Y.K, [&](Register<Number> in, int i, int j, Word value) {
            return 2.0 * in(Y.K, i * layer.stride + j) - value;
        });
    for (int i = 0; i < n; ++i) {
        // Squaring doubles the relative error of the gap: carry it once the difference would lose
        // more.
        Number& gap = layer.gap_diagonal[i];
        const Number squared = 0.25 * gap * gap / Z.d[i];
        if (layer.has_gap) {
            Y.d[i] = gap = squared;
        } else {
            Y.d[i] *= 2.0 - Y.d[i] / Z.d[i];
            gap = Y.d[i] < 0.25 * Z.d[i] ? Z.d[i] - Y.d[i] : squared;
        }
    }
    layer.half_depth *= 2.0;
    if (layer.any_conserving) restore_absorption(layer);
}

template <class Number>
void extract(SimdLayer<Number>& layer) {
    const int N = layer.gauss, n = layer.directions, from = layer.first_extracted;
    const long stride = layer.stride;
    const SimdMatrix<Number>&Y = layer.Y, &Z = layer.Z;
    const SimdMatrix<Number> E = layer.reflection,
                             O = layer.transmission;  // (I + Y)^-1 and (I + Z)^-1
    const SimdMatrix<Number> C = layer.spare[0];

    for (int i = 0; i < n; ++i) C.d[i] = 1.0 + Z.d[i];
    invert(layer, {C.d, Z.K}, O, from);
    if (!layer.has_gap) {
        for (int i = 0; i < n; ++i) C.d[i] = 1.0 + Y.d[i];
        invert(layer, {C.d, Y.K}, E, from);
        for (int i = from; i < n; ++i)
            for (long at = i * stride + from; at < i * stride + n; ++at) {
                const Number even = E.K[at], odd = O.K[at];
                E.K[at] = even + odd;
                O.K[at] = even - odd;
            }
        return;
    }

    if (from > 0) invert_gauss_rows(layer, O, from);
    const SimdMatrix<Number>& G = Y;
    for (int i = 0; i < n; ++i) {
        C.d[i] = 1.0 + Z.d[i] - G.d[i];
        for (long at = i * stride; at < i * stride + n; ++at) C.K[at] = Z.K[at] - G.K[at];
    }
    invert(layer, C, E, from);
    if (from > 0) invert_gauss_rows(layer, E, from);
    // T = O F with F = G E, so that both products run over rows.
    const SimdMatrix<Number> F = layer.spare[0], T = layer.spare[1];
    auto first = [&]<int I, int J>(Register<Number> in, int i0, int column, Tile<I, J>) {
        const int j0 = from + column;
        Word sum[I][J] = {};
        accumulate(in, N, G.K + i0, stride, E.K + j0, stride, 1.0, sum);
        for (int i = i0; i < i0 + I; ++i)
            for (int j = 0; j < J; ++j) {
                const int column = j0 + j * in.columns;
                const long at = i * stride + column;
                in(F.K, at) =
                    sum[i - i0][j] + in.same(G.d, i) * in(E.K, at) + in(G.K, at) * in(E.d, column);
            }
    };
    for_each_block<Number>(
        n, n - from, [](int) { return 0; }, first);
    auto second = [&]<int I, int J>(Register<Number> in, int row, int column, Tile<I, J>) {
        const int i0 = from + row, j0 = from + column;
        Word sum[I][J] = {};
        accumulate(in, N, O.K + i0, stride, F.K + j0, stride, 1.0, sum);
        for_upper(in, i0, j0, sum, [&](Register<Number>, int i, int j, Word value) {
            const long at = i * stride + j;
            value += in(E.d, j) * in(G.d, j) * in(O.K, at) + in.same(O.d, i) * in(F.K, at);
            store_upper(in, T.K, stride, i, j, value);
        });
    };
    for_each_block<Number>(
        n - from, n - from, [](int i) { return i; }, second);
    mirror(from, n, T.K, stride);
    for (int i = from; i < n; ++i)
        for (long at = i * stride + from; at < i * stride + n; ++at) E.K[at] += O.K[at];
    layer.spare[1] = layer.transmission;
    layer.transmission = T;
}

template void absorb_uniform(const SimdLayer<Pack>&, Pack*);
template void absorb_uniform(const SimdLayer<double>&, double*);
template void restore_absorption(SimdLayer<Pack>&);
template void restore_absorption(SimdLayer<double>&);
template void use_gap(SimdLayer<Pack>&);
template void use_gap(SimdLayer<double>&);
template void double_depth(SimdLayer<Pack>&);
template void double_depth(SimdLayer<double>&);
template void extract(SimdLayer<Pack>&);
template void extract(SimdLayer<double>&);

}  // namespace stratus::STRATUS_ISA
