// P C^-1 P, the product behind doubling, the thin start and the extraction of R and T.
//
// C = diag(c) + K_C positive definite, P = p (diag(d) + K_P) symmetric. With rho = p d / c on the
// extra directions and 0 on the Gauss nodes, U = (P - rho C)[:, :N], C_NN = L L^T and X = L^-1 U^T,
// the product has the diagonal (p d)^2 / c and the kernel X^T X + rho K_P + K_P rho - rho K_C rho,
// less that diagonal on the Gauss nodes, where X^T X holds it too.
#pragma once

#include "blocks.h"

namespace stratus::STRATUS_ISA {

/// The factor p of P, and P itself.
struct Scaled {
    double p;
    SimdMatrix matrix;
};

/// Eliminates for P C^-1 P. A vector `along`, if not null, is replaced by C^-1 along.
void eliminate_for(const SimdLayer& layer, Scaled P, SimdMatrix C, Pack* along);

/// Stores combine(i, j, kernel of P C^-1 P) in both triangles of `out`; `out` may be P's kernel.
template <class Combine>
[[gnu::always_inline]] inline void congruence_kernel(const SimdLayer& layer, Scaled P, SimdMatrix C,
                                                     Pack* out, Combine combine) {
    const int N = layer.gauss, n = layer.directions;
    const long stride = layer.stride, x_stride = layer.elimination_stride;
    const Pack* X = layer.elimination + N;
    auto ratio = [&](int i) { return i < N ? Pack{} : P.p * P.matrix.d[i] / C.d[i]; };
    auto blocks = [&]<int I, int J>(int i0, int j0, Tile<I, J>) {
        Pack product[I][J] = {};
        accumulate(N, X + i0, x_stride, X + j0, x_stride, 1.0, product);
        for (int i = i0; i < i0 + I; ++i)
            for (int j = (j0 > i ? j0 : i); j < j0 + J; ++j) {
                const long at = i * stride + j;
                const Pack rho_i = ratio(i), rho_j = ratio(j);
                Pack value = product[i - i0][j - j0] - rho_i * C.K[at] * rho_j;
                value += P.p * (rho_i + rho_j) * P.matrix.K[at];
                if (i == j && i < N) {
                    const Pack d = P.p * P.matrix.d[i];
                    value -= d * d / C.d[i];
                }
                out[at] = out[j * stride + i] = combine(i, j, value);
            }
    };
    for_each_block(
        n, n, [](int i) { return i; }, blocks);
}

/// out = F x, the product summing over the Gauss nodes.
void apply(const SimdLayer& layer, SimdMatrix F, const Pack* x, Pack* out);

/// out = Y s, the light absorbed under uniform illumination, from Y or from Z and the gap.
void absorb_uniform(const SimdLayer& layer, Pack* out);

/// The smallest symmetric change of Y (or of Z where the gap is carried) after which Y s = a in
/// conserving lanes.
void restore_absorption(SimdLayer& layer);

/// C^-1 into `out`. Its kernel is (K_C C^-1 K_C - K_C) / (c c): no identity is subtracted, so that
/// thin layers keep their relative accuracy.
void invert(const SimdLayer& layer, SimdMatrix C, SimdMatrix out);

}  // namespace stratus::STRATUS_ISA
