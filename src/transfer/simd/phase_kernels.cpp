// Azimuthal modes of the phase function between all directions, from its Legendre moments.
//
// Addition theorem: with Y_l^m = sqrt((l-m)!/(l+m)!) P_l^m, the mode-m kernel into the same
// hemisphere is P+ = sum_l (2l+1) chi_l Y_l^m(mu) Y_l^m(mu'), and P- into the other one has the
// sign (-1)^(l-m). Two matrix products give both: the sums over even and over odd l - m.
#include "blocks.h"

namespace stratus::STRATUS_ISA {

namespace {

/// Rows k = 0 .. count-1 of Y_{m+k}^m at all directions; each lane has its own m. No
/// Condon-Shortley sign.
void legendre_rows(const PhaseSeries& phase, const SimdLayer& layer, int count) {
    const int n = layer.directions;
    for (int i = 0; i < n; ++i) {
        const double mu = layer.mu[i];
        for (int lane = 0; lane < lane_count; ++lane) {
            double p = 1;
            for (int k = 1; k <= phase.mode[lane]; ++k)
                p *= __builtin_sqrt((2.0 * k - 1) / (2.0 * k) * (1 - mu * mu));
            phase.legendre[i][lane] = p;
        }
    }
    for (int k = 1; k < count; ++k) {
        Pack up, back;  // Y_l = up mu Y_{l-1} - back Y_{l-2}
        for (int lane = 0; lane < lane_count; ++lane) {
            const double m = phase.mode[lane], l = m + k;
            const double norm = 1 / __builtin_sqrt(l * l - m * m);
            up[lane] = (2 * l - 1) * norm;
            back[lane] = __builtin_sqrt((l - 1) * (l - 1) - m * m) * norm;
        }
        Pack* row = phase.legendre + static_cast<long>(k) * n;
        for (int i = 0; i < n; ++i) {
            row[i] = up * layer.mu[i] * row[i - n];
            if (k > 1) row[i] -= back * row[i - 2 * n];
        }
    }
}

/// Sinkhorn scaling, K <- d K d, until sum_j weight_j K_ij = 1 on every row in the lanes of mode 0,
/// so that scattering conserves energy. The extra rows are scaled after the Gauss nodes.
void conserve_energy(SimdLayer& layer) {
    const int N = layer.gauss, n = layer.directions;
    const long stride = layer.stride;
    Pack* d = layer.vector[0];
    Pack* sum = layer.vector[1];
    for (int i = 0; i < n; ++i) d[i] = broadcast(1);
    constexpr int max_rounds = 2000;
    for (int round = 0; round < max_rounds; ++round) {
        double worst = 0;
        for (int i = 0; i < n; ++i) {
            Pack row{};
            for (int j = 0; j < N; ++j)
                row += layer.scatter_even.K[i * stride + j] * d[j] * layer.weight[j];
            sum[i] = 1.0 + layer.conserving * (row * d[i] - 1.0);
            for (int lane = 0; lane < lane_count; ++lane) {
                const double miss = __builtin_fabs(sum[i][lane] - 1);
                if (miss > worst) worst = miss;
            }
        }
        if (worst < 5e-16) break;
        for (int i = 0; i < N; ++i) d[i] /= square_root(sum[i]);
        for (int i = N; i < n; ++i) d[i] /= sum[i];
    }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            layer.scatter_odd.K[i * stride + j] *= d[i] * d[j];
            layer.scatter_even.K[i * stride + j] *= d[i] * d[j];
        }
}

}  // namespace

void phase_kernels(const PhaseSeries& phase, SimdLayer& layer) {
    const int n = layer.directions;
    int lowest = phase.mode[0];
    for (int mode : phase.mode) lowest = mode < lowest ? mode : lowest;
    const int count = phase.moment_count - lowest > 1 ? phase.moment_count - lowest : 1;
    legendre_rows(phase, layer, count);
    Pack* weighted = phase.legendre + static_cast<long>(phase.moment_count) * n;
    for (int k = 0; k < count; ++k) {
        Pack c{};
        for (int lane = 0; lane < lane_count; ++lane) {
            const int l = phase.mode[lane] + k;
            if (l < phase.moment_count) c[lane] = (2 * l + 1) * phase.moments[l];
        }
        for (long i = k * static_cast<long>(n); i < (k + 1) * static_cast<long>(n); ++i)
            weighted[i] = c * phase.legendre[i];
    }
    auto product = [&](int parity, Pack* out) {
        const Pack* a = weighted + static_cast<long>(parity) * n;
        const Pack* b = phase.legendre + static_cast<long>(parity) * n;
        auto blocks = [&]<int I, int J>(int i0, int j0, Tile<I, J>) {
            Pack sum[I][J] = {};
            accumulate((count + 1 - parity) / 2, a + i0, 2L * n, b + j0, 2L * n, 1.0, sum);
            for (int i = i0; i < i0 + I; ++i)
                for (int j = (j0 > i ? j0 : i); j < j0 + J; ++j)
                    out[i * layer.stride + j] = out[j * layer.stride + i] = sum[i - i0][j - j0];
        };
        for_each_block(
            n, n, [](int i) { return i; }, blocks);
    };
    product(0, layer.scatter_even.K);
    product(1, layer.scatter_odd.K);
    if (layer.any_conserving) conserve_energy(layer);
    // The scaling of doubling_steps.h, and the factor 1 / (2 mu_i mu_j) per unit of depth.
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double scale = layer.s[i] * layer.s[j] / (2 * layer.mu[i] * layer.mu[j]);
            layer.scatter_odd.K[i * layer.stride + j] *= scale;
            layer.scatter_even.K[i * layer.stride + j] *= scale;
        }
}

}  // namespace stratus::STRATUS_ISA
