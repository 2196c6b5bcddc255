// One term of a product of series (ordered_ladder.h).
#include "blocks.h"

namespace stratus::STRATUS_ISA {

void add_product(const SimdLayer& layer, double factor, const ProductFactors& of, Pack* out) {
    const int n = layer.directions;
    const long stride = layer.stride;
    auto blocks = [&]<int I, int J>(int i0, int j0, Tile<I, J>) {
        Pack sum[I][J] = {};
        if (of.F && of.G) accumulate(layer.gauss, of.F + i0, stride, of.G + j0, stride, 1.0, sum);
        for (int i = i0; i < i0 + I; ++i)
            for (int j = j0; j < j0 + J; ++j) {
                const long at = i * stride + j;
                Pack value = sum[i - i0][j - j0];
                if (of.F_diagonal && of.G) value += of.F_diagonal[i] * of.G[at];
                if (of.F && of.G_diagonal) value += of.F[at] * of.G_diagonal[j];
                out[at] += factor * value;
            }
    };
    for_each_block(
        n, n, [](int) { return 0; }, blocks);
}

}  // namespace stratus::STRATUS_ISA
