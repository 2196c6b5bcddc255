// Eliminations for the product P C^-1 P (blocks.h), inverses by it, and the conservation of energy.
#pragma once

#include "blocks.h"

namespace stratus::STRATUS_ISA {

namespace {

/// `I` rows of an elimination, from row i0 on. With columns in registers i0 is a multiple of I, and
/// the diagonal of these rows lies in one register.
template <class Number, int I>
[[gnu::always_inline]] inline void eliminate_rows(Register<Number> in, int i0, int columns,
                                                  Number* m, long stride, Tile<I, I>) {
    constexpr int step = Register<Number>::columns, J = is_pack<Number> ? I : 1;
    const int first = i0 / step * step;
    const auto at = [&](int i, int j) -> Word& { return in(m, (i0 + i) * stride + j); };
    // The diagonal block: subtract the rows above, then factor it.
    Word corner[I][J];
    for (int i = 0; i < I; ++i)
        for (int j = 0; j < J; ++j)
            corner[i][j] = is_pack<Number> && j < i ? Word{} : at(i, first + j);
    accumulate(in, i0, m + i0, stride, m + first, stride, -1.0, corner);
    for (int i = 0; i < I; ++i)
        for (int j = 0; j < J; ++j) at(i, first + j) = corner[i][j];
    decltype(in.same(m, 0)) factor[I][I];
    for (int i = 0; i < I; ++i)
        for (int j = i; j < I; ++j) factor[i][j] = in.same(m, (i0 + i) * stride + i0 + j);
    // L D L^T first: square roots, which nothing waits for, come last.
    for (int i = 0; i < I; ++i) {
        factor[i][i] = 1.0 / factor[i][i];
        for (int r = i + 1; r < I; ++r) {
            const auto share = factor[i][r] * factor[i][i];
            for (int j = r; j < I; ++j) factor[r][j] -= share * factor[i][j];
        }
    }
    for (int i = 0; i < I; ++i) {
        factor[i][i] = square_root(factor[i][i]);
        for (int j = i + 1; j < I; ++j) factor[i][j] *= factor[i][i];
    }
    // All columns of these rows.
    auto solve = [&]<int W>(int rows_above, int j0, Tile<1, W>) {
        Word x[I][W];
        for (int i = 0; i < I; ++i)
            for (int j = 0; j < W; ++j) x[i][j] = at(i, j0 + j * step);
        accumulate(in, rows_above, m + i0, stride, m + j0, stride, -1.0, x);
        for (int i = 0; i < I; ++i)
            for (int j = 0; j < W; ++j) {
                for (int r = 0; r < i; ++r) x[i][j] -= factor[r][i] * x[r][j];
                x[i][j] *= factor[i][i];
                at(i, j0 + j * step) = x[i][j];
            }
    };
    solve(0, first, Tile<1, J>{});
    for (int i = 0; i < I; ++i) in.set_same(m, (i0 + i) * stride + i0 + i, factor[i][i]);
    for_each_strip(first + J * step, columns, step,
                   [&]<int W>(int j0, Tile<1, W> tile) { solve(i0, j0, tile); });
}

}  // namespace

/// Factors the symmetric positive leading block of m = [C | U^T] (gauss rows) as L L^T and leaves
/// L^-1 [C | U^T]; the diagonal holds 1 / L_ii.
template <class Number>
void eliminate(int gauss, int columns, Number* m, long stride) {
    using In = Register<Number>;
    constexpr int rows = is_pack<Number> ? block : In::columns < 4 ? In::columns : 4;
    for (int word = 0; word < In::words; ++word) {
        int i0 = 0;
        for (; i0 + rows <= gauss; i0 += rows)
            eliminate_rows(In{word}, i0, columns, m, stride, Tile<rows, rows>{});
        for (; i0 < gauss; ++i0) eliminate_rows(In{word}, i0, columns, m, stride, Tile<1, 1>{});
    }
}

/// Solves L^T u = x in place, L^T as `eliminate` left it.
template <class Number>
void back_substitute(int gauss, const Number* m, long stride, Number* x) {
    for (int i = gauss - 1; i >= 0; --i) {
        Number sum = x[i];
        for (int j = i + 1; j < gauss; ++j) sum -= m[i * stride + j] * x[j];
        x[i] = sum * m[i * stride + i];
    }
}

/// Eliminates for P C^-1 P from the direction `first` on, and leaves rho in vector[0]. A vector
/// `along`, if not null, is replaced by P C^-1 along = X^T (L^-1 along) + rho along, for all
/// directions.
template <class Number>
void eliminate_for(const SimdLayer<Number>& layer, Scaled<Number> P, SimdMatrix<Number> C,
                   Number* along, int first = 0) {
    const int N = layer.gauss, n = layer.directions, right = layer.right_side;
    const long stride = layer.stride, x_stride = layer.elimination_stride;
    Number* m = layer.elimination;
    const SimdMatrix<Number>& F = P.matrix;
    Number* rho = layer.vector[0];
    for (int j = 0; j < n; ++j) rho[j] = j < N ? Number{} : P.p * F.d[j] / C.d[j];
    for (int i = 0; i < N; ++i) {
        Number* row = m + i * x_stride;
        for (int j = is_pack<Number> ? i : 0; j < N; ++j) row[j] = C.K[i * stride + j];
        for (int j = N; j < right; ++j) row[j] = Number{};
        row[i] += C.d[i];
        Number* u = row + right - first;
        for (int j = first; j < N; ++j) u[j] = P.p * F.K[i * stride + j];
        for (int j = N; j < n; ++j) u[j] = P.p * F.K[i * stride + j] - rho[j] * C.K[i * stride + j];
        if (i >= first) u[i] += P.p * F.d[i];
        if (along) u[n] = along[i];
    }
    eliminate(N, right + n - first + (along ? 1 : 0), m, x_stride);
    if (!along) return;
    Number* factored = layer.vector[2];  // L^-1 along
    for (int i = 0; i < N; ++i) factored[i] = m[i * x_stride + right + n];
    for (int e = N; e < n; ++e) factored[e] = along[e];
    multiply(N, factored, m + right, x_stride, n, along);
    for (int e = N; e < n; ++e) along[e] += rho[e] * factored[e];
}

/// C^-1 into `out`, from the direction `first` on. Its kernel is (K_C C^-1 K_C - K_C) / (c c): no
/// identity is subtracted, so that thin layers keep their relative accuracy.
template <class Number>
void invert(const SimdLayer<Number>& layer, SimdMatrix<Number> C, SimdMatrix<Number> out,
            int first = 0) {
    Number* none = layer.vector[2];
    for (int i = 0; i < layer.directions; ++i) {
        none[i] = Number{};
        out.d[i] = 1.0 / C.d[i];
    }
    const Scaled<Number> kernel{1.0, {none, C.K}};
    eliminate_for<Number>(layer, kernel, C, nullptr, first);
    const auto combine = [&](Register<Number> in, int i, int j, Word value) {
        return (value - in(C.K, i * layer.stride + j)) * in.same(out.d, i) * in(out.d, j);
    };
    congruence_kernel(layer, kernel, C, out.K, combine, first);
}

/// After `invert` from a direction `first` other than 0: the columns of C^-1 from there on, in the
/// rows of the Gauss nodes before it, too: -C_NN^-1 K_C / c.
template <class Number>
void invert_gauss_rows(const SimdLayer<Number>& layer, SimdMatrix<Number> out, int first) {
    const int N = layer.gauss;
    const long stride = layer.elimination_stride;
    Number* const X = layer.elimination + layer.right_side;
    for (int i = N - 1; i >= 0; --i) {
        const Number* const factor = layer.elimination + i * stride;
        const auto solve = [&](Register<Number> in, int, int column, Word sum) {
            Word& x = in(X, i * stride + column);
            x = (x - sum) * in.same(factor, i);
            if (i < first)
                in(out.K, i * static_cast<long>(layer.stride) + first + column) =
                    -x * in(out.d, first + column);
        };
        for_each_product<Number>(1, layer.directions - first, whole_rows, N - 1 - i, factor + i + 1,
                                 1, X + (i + 1) * stride, stride, solve);
    }
}

// ---- conservation of energy (doubling.cpp)

/// out = Y s, the light absorbed under uniform illumination, from Y or from Z and the gap.
template <class Number>
void absorb_uniform(const SimdLayer<Number>& layer, Number* out) {
    apply(layer, layer.has_gap ? layer.Z : layer.Y, layer.uniform, out);
    if (!layer.has_gap) return;
    Number* gap = layer.vector[2];
    apply(layer, layer.Y, layer.uniform, gap);
    for (int i = 0; i < layer.directions; ++i) out[i] -= gap[i];
}

/// The smallest symmetric change of Y (or of Z where the gap is carried) after which Y s = a in
/// conserving lanes.
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

}  // namespace stratus::STRATUS_ISA
