// The one product that doubling, the thin start and the way back to R and T are made of: P C^-1 P.
//
// C = diag(c) + K_C positive definite, P = p (diag(d) + K_P) symmetric. With rho = p d / c on the
// extra directions and 0 on the Gauss nodes, U = (P - rho C)[:, :N], C_NN = L L^T and X = L^-1 U^T,
// the product has the diagonal (p d)^2 / c and the kernel X^T X + rho K_P + K_P rho - rho K_C rho,
// less that diagonal on the Gauss nodes, where X^T X holds it too.
#pragma once

#include "kernels.h"

namespace stratus::STRATUS_ISA {

/// The factor p of P, and P itself; K null stands for the identity matrix.
struct Scaled {
    double p;
    LaneMatrix matrix;
};

/// Eliminates for P C^-1 P. A vector `along`, if not null, is replaced by C^-1 along.
void eliminate_for(const LaneLayer& layer, Scaled P, LaneMatrix C, Pack* along);

/// Stores combine(index, kernel of P C^-1 P at index) in both triangles of `out`, which may be P's
/// own kernel.
template <class Combine>
[[gnu::always_inline]] inline void congruence_kernel(const LaneLayer& layer, Scaled P, LaneMatrix C,
                                                     Pack* out, Combine combine) {
    const int N = layer.gauss, n = layer.directions;
    const long stride = layer.stride, x_stride = layer.elimination_stride;
    const Pack* X = layer.elimination + N;
    auto ratio = [&](int i) {
        return i < N ? Pack{} : P.p * (P.matrix.K ? P.matrix.d[i] : broadcast(1)) / C.d[i];
    };
    auto blocks = [&]<int I, int J>(int i0, int j0, Tile<I, J>) {
        Pack product[I][J] = {};
        accumulate(N, X + i0, x_stride, X + j0, x_stride, 1.0, product);
        for (int i = i0; i < i0 + I; ++i)
            for (int j = (j0 > i ? j0 : i); j < j0 + J; ++j) {
                const long at = i * stride + j;
                const Pack rho_i = ratio(i), rho_j = ratio(j);
                Pack value = product[i - i0][j - j0] - rho_i * C.K[at] * rho_j;
                if (P.matrix.K) value += P.p * (rho_i + rho_j) * P.matrix.K[at];
                if (i == j && i < N) {
                    const Pack d = P.p * (P.matrix.K ? P.matrix.d[i] : broadcast(1));
                    value -= d * d / C.d[i];
                }
                out[at] = out[j * stride + i] = combine(at, value);
            }
    };
    for_each_block(
        n, n, [](int i) { return i; }, blocks);
}

/// Kernel and diagonal of P C^-1 P into `out`.
void congruence(const LaneLayer& layer, Scaled P, LaneMatrix C, LaneMatrix out,
                Pack* along = nullptr);

}  // namespace stratus::STRATUS_ISA
