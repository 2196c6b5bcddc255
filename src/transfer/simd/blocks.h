// Blocks of matrices in registers, then the product that is made of them.
//
// Inner loops of the SIMD files: small blocks held in registers.
//
// The files are written once for both kinds of Number (doubling_steps.h). A register holds lanes of
// a Pack, or consecutive columns of a row of doubles.
#pragma once

#include "doubling_steps.h"

namespace stratus::STRATUS_ISA {

// A register, and the rows and columns of the largest block of accumulators that fits: 4 x 4 of 32
// registers, or 3 x 3 of 16.
#if defined(__AVX512F__)
constexpr int word_bytes = 64, block = 4;
#elif defined(__AVX__)
constexpr int word_bytes = 32, block = 3;
#else
constexpr int word_bytes = 16, block = 3;
#endif
using Word = double __attribute__((vector_size(word_bytes), aligned(word_bytes), may_alias));

/// One register of each Number, or of as many columns as it holds.
template <class Number>
struct Register {
    static constexpr int words = is_pack<Number> ? static_cast<int>(sizeof(Pack)) / word_bytes : 1;
    static constexpr int columns =
        is_pack<Number> ? 1 : word_bytes / static_cast<int>(sizeof(double));
    int word;

    /// x[at], or x[at] and the columns after it.
    [[gnu::always_inline]] Word& operator()(Number* x, long at) const {
        return reinterpret_cast<Word*>(x + at)[word];
    }
    [[gnu::always_inline]] const Word& operator()(const Number* x, long at) const {
        return reinterpret_cast<const Word*>(x + at)[word];
    }
    /// x[at], the same in all columns.
    [[gnu::always_inline]] auto same(const Number* x, long at) const {
        if constexpr (is_pack<Number>)
            return (*this)(x, at);
        else
            return x[at];
    }
    template <class Value>
    [[gnu::always_inline]] void set_same(Number* x, long at, Value value) const {
        if constexpr (is_pack<Number>)
            (*this)(x, at) = value;
        else
            x[at] = value;
    }
    /// Sets one of the columns of a register.
    template <class Value>
    [[gnu::always_inline]] void set_column(Word& w, int column, Value value) const {
        if constexpr (is_pack<Number>)
            w = value;
        else
            w[column] = value;
    }
};

/// acc[i][j] += sign * sum over k < depth of a[k, i] b[k, j]: rows of a and b are contiguous in i
/// and j; j counts registers.
template <class Number, int I, int J>
[[gnu::always_inline]] inline void accumulate(Register<Number> in, int depth, const Number* a,
                                              long a_stride, const Number* b, long b_stride,
                                              double sign, Word (&acc)[I][J]) {
    Word sum[I][J] = {};
    for (long k = 0; k < depth; ++k, a += a_stride, b += b_stride)
        for (int i = 0; i < I; ++i)
            for (int j = 0; j < J; ++j) sum[i][j] += in.same(a, i) * in(b, j * in.columns);
    for (int i = 0; i < I; ++i)
        for (int j = 0; j < J; ++j) acc[i][j] += sign * sum[i][j];
}

template <int I, int J>
struct Tile {};

// The columns where for_each_block begins in row i.
constexpr auto whole_rows = [](int) { return 0; };
constexpr auto from_diagonal = [](int i) { return i; };

/// Calls body(j0, tile<1, J>) for strips of J registers, `step` columns each, from column j on: as wide ones
/// as fit.
template <class Body>
[[gnu::always_inline]] inline void for_each_strip(int j, int columns, int step, Body body) {
    const auto strips = [&]<int J>(Tile<1, J> tile) {
        for (; j + (J - 1) * step < columns; j += J * step) body(j, tile);
    };
    strips(Tile<1, block>{});
    strips(Tile<1, 2>{});
    strips(Tile<1, 1>{});
}

/// Calls body(register, i0, j0, tile<I, J>) over all blocks of a rows x columns matrix, j0 from
/// first_column(i0) or, with columns in registers, the first of its register; smaller blocks at the
/// edges.
template <class Number, class FirstColumn, class Body>
[[gnu::always_inline]] inline void for_each_block(int rows, int columns, FirstColumn first_column,
                                                  Body body) {
    using In = Register<Number>;
    auto row = [&]<int I>(int i, Tile<I, 1>) {
        for_each_strip(first_column(i) / In::columns * In::columns, columns, In::columns,
                       [&]<int J>(int j, Tile<1, J>) {
                           for (int word = 0; word < In::words; ++word)
                               body(In{word}, i, j, Tile<I, J>{});
                       });
    };
    int i = 0;
    for (; i + block <= rows; i += block) row(i, Tile<block, 1>{});
    for (; i < rows; ++i) row(i, Tile<1, 1>{});
}

/// Calls body(register, i, j, sum over k < depth of a[k, i] b[k, j]) over a rows x columns matrix, in
/// each row from the register that holds first_column(i) on.
template <class Number, class FirstColumn, class Body>
[[gnu::always_inline]] inline void for_each_product(int rows, int columns, FirstColumn first_column,
                                                    int depth, const Number* a, long a_stride,
                                                    const Number* b, long b_stride, Body body) {
    auto blocks = [&]<int I, int J>(Register<Number> in, int i0, int j0, Tile<I, J>) {
        Word sum[I][J] = {};
        accumulate(in, depth, a + i0, a_stride, b + j0, b_stride, 1.0, sum);
        for (int i = 0; i < I; ++i)
            for (int j = 0; j < J; ++j) {
                const int column = j0 + j * in.columns;
                if (column + in.columns > first_column(i0 + i)) body(in, i0 + i, column, sum[i][j]);
            }
    };
    for_each_block<Number>(rows, columns, first_column, blocks);
}

/// Stores an element above the diagonal, for both triangles once `mirror` follows.
template <class Number>
[[gnu::always_inline]] inline void store_upper(Register<Number> in, Number* out, long stride, int i,
                                               int j, Word value) {
    in(out, i * stride + j) = value;
    if constexpr (is_pack<Number>) in(out, j * stride + i) = value;
}

template <class Number>
[[gnu::always_inline]] inline void mirror(int first, int n, Number* out, long stride) {
    if constexpr (!is_pack<Number>)
        for (int i = first + 1; i < n; ++i)
            for (int j = first; j < i; ++j) out[i * stride + j] = out[j * stride + i];
}

/// out_i = sum over k < depth of x_k K_ki.
template <class Number>
[[gnu::always_inline]] inline void multiply(int depth, const Number* x, const Number* K,
                                            long stride, int columns, Number* out) {
    for_each_product(1, columns, whole_rows, depth, x, 1, K, stride,
                     [=](Register<Number> in, int, int j, Word sum) { in(out, j) = sum; });
}

[[gnu::always_inline]] inline double square_root(double x) { return __builtin_sqrt(x); }

template <class Vector>
[[gnu::always_inline]] inline Vector square_root(Vector x) {
    for (int lane = 0; lane < lanes_per<Vector>; ++lane) x[lane] = __builtin_sqrt(x[lane]);
    return x;
}

// P C^-1 P, the product behind doubling, the thin start and the extraction of R and T.
//
// C = diag(c) + K_C positive definite, P = p (diag(d) + K_P) symmetric. With rho = p d / c on the
// extra directions and 0 on the Gauss nodes, U = (P - rho C)[:, :N], C_NN = L L^T and X = L^-1 U^T,
// the product has the diagonal (p d)^2 / c and the kernel X^T X + rho K_P + K_P rho - rho K_C rho,
// less that diagonal on the Gauss nodes, where X^T X holds it too.

/// The factor p of P, and P itself.
template <class Number>
struct Scaled {
    double p;
    SimdMatrix<Number> matrix;
};

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
    const auto store = [&](Register<Number> in, int row, int column, Word value) {
        const int i = first + row, j = first + column;
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
    };
    for_each_product(n - first, n - first, from_diagonal, N, X, x_stride, X, x_stride, store);
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

}  // namespace stratus::STRATUS_ISA
