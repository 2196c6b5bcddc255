#include "congruence.h"

namespace stratus::STRATUS_ISA {

void eliminate(int gauss, int columns, Pack* m, long stride) {
    int i0 = 0;
    auto block_row = [&]<int I>(Tile<I, I>) {
        // The diagonal block: subtract the rows above, then factor it.
        Pack factor[I][I];
        for (int i = 0; i < I; ++i)
            for (int j = 0; j < I; ++j)
                factor[i][j] = j < i ? Pack{} : m[(i0 + i) * stride + i0 + j];
        accumulate(i0, m + i0, stride, m + i0, stride, -1.0, factor);
        for (int i = 0; i < I; ++i) {
            factor[i][i] = 1.0 / square_root(factor[i][i]);
            for (int j = i + 1; j < I; ++j) factor[i][j] *= factor[i][i];
            for (int r = i + 1; r < I; ++r)
                for (int j = r; j < I; ++j) factor[r][j] -= factor[i][r] * factor[i][j];
        }
        for (int i = 0; i < I; ++i)
            for (int j = i; j < I; ++j) m[(i0 + i) * stride + i0 + j] = factor[i][j];
        // The remaining columns of these rows.
        auto columns_at = [&]<int J>(int j0, Tile<1, J>) {
            Pack x[I][J];
            for (int i = 0; i < I; ++i)
                for (int j = 0; j < J; ++j) x[i][j] = m[(i0 + i) * stride + j0 + j];
            accumulate(i0, m + i0, stride, m + j0, stride, -1.0, x);
            for (int i = 0; i < I; ++i)
                for (int j = 0; j < J; ++j) {
                    for (int r = 0; r < i; ++r) x[i][j] -= factor[r][i] * x[r][j];
                    x[i][j] *= factor[i][i];
                    m[(i0 + i) * stride + j0 + j] = x[i][j];
                }
        };
        int j0 = i0 + I;
        for (; j0 + block <= columns; j0 += block) columns_at(j0, Tile<1, block>{});
        for (; j0 < columns; ++j0) columns_at(j0, Tile<1, 1>{});
        i0 += I;
    };
    while (i0 + block <= gauss) block_row(Tile<block, block>{});
    while (i0 < gauss) block_row(Tile<1, 1>{});
}

void back_substitute(int gauss, const Pack* m, long stride, Pack* x) {
    for (int i = gauss - 1; i >= 0; --i) {
        Pack sum = x[i];
        for (int j = i + 1; j < gauss; ++j) sum -= m[i * stride + j] * x[j];
        x[i] = sum * m[i * stride + i];
    }
}

void eliminate_for(const SimdLayer& layer, Scaled P, SimdMatrix C, Pack* along) {
    const int N = layer.gauss, n = layer.directions;
    const long stride = layer.stride, x_stride = layer.elimination_stride;
    Pack* m = layer.elimination;
    const SimdMatrix& F = P.matrix;
    Pack* rho = layer.vector[0];
    for (int j = 0; j < n; ++j) rho[j] = j < N ? Pack{} : P.p * F.d[j] / C.d[j];
    for (int i = 0; i < N; ++i) {
        Pack* row = m + i * x_stride;
        for (int j = i; j < N; ++j) row[j] = C.K[i * stride + j];
        row[i] += C.d[i];
        Pack* u = row + N;
        for (int j = 0; j < n; ++j) u[j] = P.p * F.K[i * stride + j] - rho[j] * C.K[i * stride + j];
        u[i] += P.p * F.d[i];
        if (along) u[n] = along[i];
    }
    eliminate(N, N + n + (along ? 1 : 0), m, x_stride);
    if (!along) return;
    for (int i = 0; i < N; ++i) along[i] = m[i * x_stride + N + n];
    back_substitute(N, m, x_stride, along);
    for (int e = N; e < n; ++e) {
        Pack sum = along[e];
        for (int j = 0; j < N; ++j) sum -= C.K[e * stride + j] * along[j];
        along[e] = sum / C.d[e];
    }
}

void invert(const SimdLayer& layer, SimdMatrix C, SimdMatrix out) {
    Pack* none = layer.vector[2];
    for (int i = 0; i < layer.directions; ++i) {
        none[i] = Pack{};
        out.d[i] = 1.0 / C.d[i];
    }
    const Scaled kernel{1.0, {none, C.K}};
    eliminate_for(layer, kernel, C, nullptr);
    congruence_kernel(layer, kernel, C, out.K, [&](int i, int j, Pack value) {
        return (value - C.K[i * layer.stride + j]) * out.d[i] * out.d[j];
    });
}

}  // namespace stratus::STRATUS_ISA
