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
template <class Number>
struct Scaled {
    double p;
    SimdMatrix<Number> matrix;
};

/// Eliminates for P C^-1 P from the direction `first` on, and leaves rho in vector[0]. A vector
/// `along`, if not null, is replaced by P C^-1 along = X^T (L^-1 along) + rho along, for all
/// directions.
template <class Number>
void eliminate_for(const SimdLayer<Number>& layer, Scaled<Number> P, SimdMatrix<Number> C,
                   Number* along, int first = 0);

/// After eliminate_for: stores combine(register, place, i, j, kernel of P C^-1 P) in both triangles
/// of `out`, from the direction `first` on; `out` may be P's kernel.
template <class Number, class Combine>
[[gnu::always_inline]] inline void congruence_kernel(const SimdLayer<Number>& layer,
                                                     Scaled<Number> P, SimdMatrix<Number> C,
                                                     Number* out, Combine combine, int first = 0) {
    const int N = layer.gauss, n = layer.directions;
    const long stride = layer.stride, x_stride = layer.elimination_stride;
    const Number* X = layer.elimination + layer.right_side;
    const Number* rho = layer.vector[0];
    auto blocks = [&]<int I, int J>(Register<Number> in, int row, int column, Tile<I, J>) {
        const int i0 = first + row, j0 = first + column;
        Word product[I][J] = {};
        accumulate(in, N, X + row, x_stride, X + column, x_stride, 1.0, product);
        for_upper(in, i0, j0, product, [&](Register<Number>, int i, int j, Word value) {
            const long at = i * stride + j;
            if (j + in.columns > N) {
                value -= in.same(rho, i) * in(C.K, at) * in(rho, j);
                value += P.p * (in.same(rho, i) + in(rho, j)) * in(P.matrix.K, at);
            }
            if (j <= i && i < N) {
                Word d{};
                const auto extinction = P.p * in.same(P.matrix.d, i);
                in.set_column(d, i - j, extinction * extinction / in.same(C.d, i));
                value -= d;
            }
            store_upper(in, out, stride, i, j, combine(in, i, j, value));
        });
    };
    for_each_block<Number>(
        n - first, n - first, [](int i) { return i; }, blocks);
    mirror(first, n, out, stride);
}

/// out = F x, the product summing over the Gauss nodes; F is symmetric.
template <class Number>
[[gnu::always_inline]] inline void apply(const SimdLayer<Number>& layer, SimdMatrix<Number> F,
                                         const Number* x, Number* out) {
    const int n = layer.directions;
    multiply(layer.gauss, x, F.K, layer.stride, n, out);
    for (int i = 0; i < n; ++i) out[i] += F.d[i] * x[i];
}

/// out = Y s, the light absorbed under uniform illumination, from Y or from Z and the gap.
template <class Number>
void absorb_uniform(const SimdLayer<Number>& layer, Number* out);

/// The smallest symmetric change of Y (or of Z where the gap is carried) after which Y s = a in
/// conserving lanes.
template <class Number>
void restore_absorption(SimdLayer<Number>& layer);

/// C^-1 into `out`, from the direction `first` on. Its kernel is (K_C C^-1 K_C - K_C) / (c c): no
/// identity is subtracted, so that thin layers keep their relative accuracy.
template <class Number>
void invert(const SimdLayer<Number>& layer, SimdMatrix<Number> C, SimdMatrix<Number> out,
            int first = 0);

/// After `invert` from a direction `first` other than 0: the columns of C^-1 from there on, in the
/// rows of the Gauss nodes before it, too: -C_NN^-1 K_C / c.
template <class Number>
void invert_gauss_rows(const SimdLayer<Number>& layer, SimdMatrix<Number> out, int first);

}  // namespace stratus::STRATUS_ISA
