// Inner loops of the SIMD files: small blocks held in registers.
#pragma once

#include "doubling_steps.h"

namespace stratus::STRATUS_ISA {

// A register of lanes, and the rows and columns of the largest block of accumulators that fits:
// 4 x 4 of 32 registers, or 3 x 3 of 16.
#if defined(__AVX512F__)
constexpr int word_bytes = 64, block = 4;
#elif defined(__AVX__)
constexpr int word_bytes = 32, block = 3;
#else
constexpr int word_bytes = 16, block = 3;
#endif
using Word = double __attribute__((vector_size(word_bytes), aligned(word_bytes), may_alias));
constexpr int words = static_cast<int>(sizeof(Pack)) / word_bytes;

/// acc[i][j] += sign * sum over k < depth of a[k, i] b[k, j]: rows of a and b are contiguous in i
/// and j.
template <int I, int J>
[[gnu::always_inline]] inline void accumulate(int depth, const Pack* a, long a_stride,
                                              const Pack* b, long b_stride, double sign,
                                              Pack (&acc)[I][J]) {
    for (int word = 0; word < words; ++word) {
        const Word* a_row = reinterpret_cast<const Word*>(a) + word;
        const Word* b_row = reinterpret_cast<const Word*>(b) + word;
        Word sum[I][J] = {};
        for (int k = 0; k < depth; ++k, a_row += a_stride * words, b_row += b_stride * words)
            for (int i = 0; i < I; ++i)
                for (int j = 0; j < J; ++j) sum[i][j] += a_row[i * words] * b_row[j * words];
        for (int i = 0; i < I; ++i)
            for (int j = 0; j < J; ++j)
                reinterpret_cast<Word*>(&acc[i][j])[word] += sign * sum[i][j];
    }
}

template <int I, int J>
struct Tile {};

/// Calls body(i0, j0, tile<I, J>) over all blocks of a rows x columns matrix, j0 from
/// first_column(i0); edges one by one.
template <class FirstColumn, class Body>
[[gnu::always_inline]] inline void for_each_block(int rows, int columns, FirstColumn first_column,
                                                  Body body) {
    int i = 0;
    for (; i + block <= rows; i += block) {
        int j = first_column(i);
        for (; j + block <= columns; j += block) body(i, j, Tile<block, block>{});
        for (; j < columns; ++j) body(i, j, Tile<block, 1>{});
    }
    for (; i < rows; ++i) {
        int j = first_column(i);
        for (; j + block <= columns; j += block) body(i, j, Tile<1, block>{});
        for (; j < columns; ++j) body(i, j, Tile<1, 1>{});
    }
}

[[gnu::always_inline]] inline Pack broadcast(double value) { return Pack{} + value; }

[[gnu::always_inline]] inline Pack square_root(Pack x) {
    for (int lane = 0; lane < lane_count; ++lane) x[lane] = __builtin_sqrt(x[lane]);
    return x;
}

/// Factors the symmetric positive leading block of m = [C | U^T] (gauss rows) as L L^T and leaves
/// L^-1 [C | U^T]; the diagonal holds 1 / L_ii.
void eliminate(int gauss, int columns, Pack* m, long stride);

/// Solves L^T u = x in place, L^T as `eliminate` left it.
void back_substitute(int gauss, const Pack* m, long stride, Pack* x);

}  // namespace stratus::STRATUS_ISA
