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

void apply(const SimdLayer& layer, SimdMatrix F, const Pack* x, Pack* out) {
    for (int i = 0; i < layer.directions; ++i) {
        Pack sum = F.d[i] * x[i];
        for (int j = 0; j < layer.gauss; ++j) sum += F.K[i * layer.stride + j] * x[j];
        out[i] = sum;
    }
}

void absorb_uniform(const SimdLayer& layer, Pack* out) {
    apply(layer, layer.has_gap ? layer.Z : layer.Y, layer.uniform, out);
    if (!layer.has_gap) return;
    Pack* gap = layer.vector[2];
    apply(layer, layer.Y, layer.uniform, gap);
    for (int i = 0; i < layer.directions; ++i) out[i] -= gap[i];
}

void restore_absorption(SimdLayer& layer) {
    const int N = layer.gauss, n = layer.directions;
    const Pack* s = layer.uniform;
    Pack* e = layer.vector[1];
    absorb_uniform(layer, e);
    Pack ss{}, es{};
    for (int i = 0; i < N; ++i) ss += s[i] * s[i];
    for (int i = 0; i < n; ++i) e[i] = layer.conserving * (layer.absorbed[i] - e[i]) / ss;
    for (int i = 0; i < N; ++i) es += e[i] * s[i];
    es /= ss;
    Pack* K = (layer.has_gap ? layer.Z : layer.Y).K;
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j)
            K[i * layer.stride + j] += e[i] * s[j] + s[i] * e[j] - es * s[i] * s[j];
    for (int i = N; i < n; ++i)
        for (int j = 0; j < N; ++j) {
            const Pack change = e[i] * s[j];
            K[i * layer.stride + j] += change;
            K[j * layer.stride + i] += change;
        }
}

namespace {

/// Z <- own Z + x Y, diagonal and kernel.
void add_to_Z(SimdLayer& layer, double own, double x) {
    const int n = layer.directions;
    for (int i = 0; i < n; ++i) {
        layer.Z.d[i] = own * layer.Z.d[i] + x * layer.Y.d[i];
        for (long at = i * layer.stride; at < i * layer.stride + n; ++at)
            layer.Z.K[at] = own * layer.Z.K[at] + x * layer.Y.K[at];
    }
}

}  // namespace

void use_gap(SimdLayer& layer) {
    const int n = layer.directions;
    for (int i = 0; i < n; ++i) {
        layer.Y.d[i] = layer.gap_diagonal[i];
        for (long at = i * layer.stride; at < i * layer.stride + n; ++at)
            layer.Y.K[at] = layer.Z.K[at] - layer.Y.K[at];
    }
    layer.has_gap = true;
}

void double_depth(SimdLayer& layer) {
    const int n = layer.directions;
    SimdMatrix &Y = layer.Y, &Z = layer.Z;
    if (layer.has_gap)
        add_to_Z(layer, 1.0, -0.5);
    else
        add_to_Z(layer, 0.5, 0.5);

    Pack *u = layer.vector[1], *Yu = layer.vector[2];
    for (int i = 0; i < n; ++i) u[i] = layer.absorbed[i];
    eliminate_for(layer, {1.0, Y}, Z, layer.any_conserving ? u : nullptr);
    if (layer.any_conserving) {  // a' = Z Z'^-1 a with the old Z = 2 Z' - Y, or Z' + G/2
        apply(layer, Y, u, Yu);
        for (int i = 0; i < n; ++i)
            layer.absorbed[i] =
                layer.has_gap ? layer.absorbed[i] + 0.5 * Yu[i] : 2.0 * layer.absorbed[i] - Yu[i];
    }
    if (layer.has_gap)
        congruence_kernel(layer, {1.0, Y}, Z, Y.K,
                          [](int, int, Pack value) { return 0.25 * value; });
    else
        congruence_kernel(layer, {1.0, Y}, Z, Y.K, [&](int i, int j, Pack value) {
            return 2.0 * Y.K[i * layer.stride + j] - value;
        });
    for (int i = 0; i < n; ++i) {
        // Squaring doubles the relative error of the gap: carry it once the difference would lose
        // more.
        Pack& gap = layer.gap_diagonal[i];
        const Pack squared = 0.25 * gap * gap / Z.d[i];
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

void extract(SimdLayer& layer) {
    const int N = layer.gauss, n = layer.directions;
    const long stride = layer.stride;
    const SimdMatrix &Y = layer.Y, &Z = layer.Z;
    const SimdMatrix E = layer.reflection, O = layer.transmission;  // (I + Y)^-1 and (I + Z)^-1
    const SimdMatrix C = layer.spare[0];

    for (int i = 0; i < n; ++i) C.d[i] = 1.0 + Z.d[i];
    invert(layer, {C.d, Z.K}, O);
    if (!layer.has_gap) {
        for (int i = 0; i < n; ++i) C.d[i] = 1.0 + Y.d[i];
        invert(layer, {C.d, Y.K}, E);
        for (int i = 0; i < n; ++i)
            for (long at = i * stride; at < i * stride + n; ++at) {
                const Pack even = E.K[at], odd = O.K[at];
                E.K[at] = even + odd;
                O.K[at] = even - odd;
            }
        return;
    }

    const SimdMatrix& G = Y;
    for (int i = 0; i < n; ++i) {
        C.d[i] = 1.0 + Z.d[i] - G.d[i];
        for (long at = i * stride; at < i * stride + n; ++at) C.K[at] = Z.K[at] - G.K[at];
    }
    invert(layer, C, E);
    // T = (E G) O; F = G E = (E G)^T comes first, so that both products run over rows.
    const SimdMatrix F = layer.spare[0], T = layer.spare[1];
    auto first = [&]<int I, int J>(int i0, int j0, Tile<I, J>) {
        Pack sum[I][J] = {};
        accumulate(N, G.K + i0, stride, E.K + j0, stride, 1.0, sum);
        for (int i = i0; i < i0 + I; ++i)
            for (int j = j0; j < j0 + J; ++j) {
                const long at = i * stride + j;
                F.K[at] = sum[i - i0][j - j0] + G.d[i] * E.K[at] + G.K[at] * E.d[j];
            }
    };
    for_each_block(
        n, n, [](int) { return 0; }, first);
    auto second = [&]<int I, int J>(int i0, int j0, Tile<I, J>) {
        Pack sum[I][J] = {};
        accumulate(N, F.K + i0, stride, O.K + j0, stride, 1.0, sum);
        for (int i = i0; i < i0 + I; ++i)
            for (int j = (j0 > i ? j0 : i); j < j0 + J; ++j)
                T.K[i * stride + j] = T.K[j * stride + i] = sum[i - i0][j - j0] +
                                                            E.d[i] * G.d[i] * O.K[i * stride + j] +
                                                            F.K[j * stride + i] * O.d[j];
    };
    for_each_block(
        n, n, [](int i) { return i; }, second);
    for (int i = 0; i < n; ++i)
        for (long at = i * stride; at < i * stride + n; ++at) E.K[at] += O.K[at];
    layer.spare[1] = layer.transmission;
    layer.transmission = T;
}

}  // namespace stratus::STRATUS_ISA
