// Azimuthal modes of the phase function between all directions, from its Legendre moments.
//
// Addition theorem: with Y_l^m = sqrt((l-m)!/(l+m)!) P_l^m, the mode-m kernel into the same
// hemisphere is P+ = sum_l (2l+1) chi_l Y_l^m(mu) Y_l^m(mu'), and P- into the other one has the
// sign (-1)^(l-m). Two matrix products give both: the sums over even and over odd l - m.
#pragma once

#include "blocks.h"

namespace stratus::STRATUS_ISA {

namespace {

/// Rows k = 0 .. count-1 of Y_{m+k}^m at all directions; each lane has its own m. No
/// Condon-Shortley sign.
template <class Number>
void legendre_rows(const PhaseSeries<Number>& phase, const SimdLayer<Number>& layer, int count) {
    const int n = layer.directions;
    Number* sine = layer.vector[0];
    int highest = 0;
    for (int mode : phase.mode) highest = mode > highest ? mode : highest;
    for (int i = 0; i < n; ++i) {
        sine[i] = Number{} + __builtin_sqrt(1 - layer.mu[i] * layer.mu[i]);
        phase.legendre[i] = Number{} + 1.0;
    }
    for (int k = 1; k <= highest; ++k) {
        Number factor{}, unchanged{};  // in lanes of a lower mode
        for (int lane = 0; lane < lanes_per<Number>; ++lane) {
            const bool counts = k <= phase.mode[lane];
            set_lane(factor, lane, counts ? __builtin_sqrt((2.0 * k - 1) / (2.0 * k)) : 0);
            set_lane(unchanged, lane, counts ? 0 : 1);
        }
        for (int i = 0; i < n; ++i) phase.legendre[i] *= factor * sine[i] + unchanged;
    }
    for (int k = 1; k < count; ++k) {
        Number up{}, back{};  // Y_l = up mu Y_{l-1} - back Y_{l-2}
        for (int lane = 0; lane < lanes_per<Number>; ++lane) {
            const double m = phase.mode[lane], l = m + k;
            const double norm = 1 / __builtin_sqrt(l * l - m * m);
            set_lane(up, lane, (2 * l - 1) * norm);
            set_lane(back, lane, __builtin_sqrt((l - 1) * (l - 1) - m * m) * norm);
        }
        Number* row = phase.legendre + static_cast<long>(k) * layer.stride;
        const Number* last = row - layer.stride;
        if (k == 1)
            for (int i = 0; i < n; ++i) row[i] = up * layer.mu[i] * last[i];
        else
            for (int i = 0; i < n; ++i)
                row[i] = up * layer.mu[i] * last[i] - back * (last - layer.stride)[i];
    }
}

/// Sinkhorn scaling, K <- d K d, until sum_j weight_j K_ij = 1 on every row in the lanes of mode 0,
/// so that scattering conserves energy. The extra rows are scaled after the Gauss nodes.
template <class Number>
void conserve_energy(SimdLayer<Number>& layer) {
    const int N = layer.gauss, n = layer.directions;
    const long stride = layer.stride;
    Number* d = layer.vector[0];
    Number* sum = layer.vector[1];
    Number* weighted = layer.vector[2];
    for (int i = 0; i < n; ++i) d[i] = Number{} + 1.0;
    constexpr int max_rounds = 2000;
    for (int round = 0; round < max_rounds; ++round) {
        double worst = 0;
        for (int j = 0; j < N; ++j) weighted[j] = d[j] * layer.weight[j];
        multiply(N, weighted, layer.scatter_even.K, stride, n, sum);
        for (int i = 0; i < n; ++i) {
            sum[i] = 1.0 + layer.conserving * (sum[i] * d[i] - 1.0);
            for (int lane = 0; lane < lanes_per<Number>; ++lane) {
                const double miss = __builtin_fabs(extract_lane(sum[i], lane) - 1);
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

/// Directions so steep that a mode has no light there, sin^m below this, do not scatter it.
constexpr double least_light = 1e-4;

/// Light of a mode stays out of directions where sin^m is too small: they do not scatter it.
template <class Number>
void leave_out_steep(const PhaseSeries<Number>& phase, const SimdLayer<Number>& layer, Number* K) {
    const long stride = layer.stride;
    for (int i = 0; i < layer.gauss; ++i) {
        Number scatters{};
        for (int lane = 0; lane < lanes_per<Number>; ++lane)
            set_lane(scatters, lane,
                     extract_lane(phase.legendre[i], lane) >
                         least_light * extract_lane(phase.legendre[0], lane));
        for (int j = 0; j < layer.directions; ++j) {
            K[i * stride + j] *= scatters;
            K[j * stride + i] *= scatters;
        }
    }
}

/// The share of light in Y_l^m, scattered by one parity of l - m, that the nodes miss along each
/// Gauss node: Y_l^m of its lowest l is an eigenfunction with the eigenvalue chi_l.
template <class Number>
void add_missed(const PhaseSeries<Number>& phase, const SimdLayer<Number>& layer, int parity,
                const Number* K, Number* missed) {
    const int N = layer.gauss;
    const Number* Y = phase.legendre + parity * static_cast<long>(layer.stride);
    Number* weighted = layer.vector[1];
    Number* sum = layer.vector[2];
    for (int j = 0; j < N; ++j) weighted[j] = layer.weight[j] * Y[j];
    multiply(N, weighted, K, layer.stride, N, sum);
    for (int i = 0; i < N; ++i)
        for (int lane = 0; lane < lanes_per<Number>; ++lane) {
            if (extract_lane(K[i * static_cast<long>(layer.stride) + i], lane) == 0) continue;
            const int l = phase.mode[lane] + parity;
            const double chi = l < phase.moment_count ? phase.moments[l] : 0;
            set_lane(missed[i], lane,
                     extract_lane(missed[i], lane) + chi -
                         extract_lane(sum[i], lane) / extract_lane(Y[i], lane));
        }
}

/// Light scattered by a peak between nodes stays in its direction.
template <class Number>
void complete_peaks(const PhaseSeries<Number>& phase, SimdLayer<Number>& layer) {
    Number* missed = layer.vector[0];
    for (int i = 0; i < layer.gauss; ++i) missed[i] = Number{};
    Number *even = layer.scatter_even.K, *odd = layer.scatter_odd.K;
    leave_out_steep(phase, layer, even);
    leave_out_steep(phase, layer, odd);
    add_missed(phase, layer, 0, even, missed);
    add_missed(phase, layer, 1, odd, missed);
    for (int i = 0; i < layer.gauss; ++i) {
        const long at = i * static_cast<long>(layer.stride) + i;
        even[at] += missed[i] * (0.5 / layer.weight[i]);
        odd[at] += missed[i] * (0.5 / layer.weight[i]);
    }
}

}  // namespace

template <class Number>
void phase_kernels(const PhaseSeries<Number>& phase, SimdLayer<Number>& layer) {
    const int n = layer.directions;
    const long stride = layer.stride;
    int lowest = phase.mode[0];
    for (int mode : phase.mode) lowest = mode < lowest ? mode : lowest;
    const int count = phase.moment_count - lowest > 1 ? phase.moment_count - lowest : 1;
    legendre_rows(phase, layer, count);
    Number* weighted = phase.legendre + phase.moment_count * stride;
    for (int k = 0; k < count; ++k) {
        Number c{};
        for (int lane = 0; lane < lanes_per<Number>; ++lane) {
            const int l = phase.mode[lane] + k;
            if (l < phase.moment_count) set_lane(c, lane, (2 * l + 1) * phase.moments[l]);
        }
        for (long i = k * stride; i < k * stride + n; ++i) weighted[i] = c * phase.legendre[i];
    }
    auto product = [&](int parity, Number* out) {
        const Number* a = weighted + parity * stride;
        const Number* b = phase.legendre + parity * stride;
        for_each_product(n, n, from_diagonal, (count + 1 - parity) / 2, a, 2 * stride, b,
                         2 * stride, [=](Register<Number> in, int i, int j, Word sum) {
                             store_upper(in, out, stride, i, j, sum);
                         });
        mirror(0, n, out, stride);
    };
    product(0, layer.scatter_even.K);
    product(1, layer.scatter_odd.K);
    if (phase.completed) complete_peaks(phase, layer);
    if (layer.any_conserving) conserve_energy(layer);
    // The scaling of doubling_steps.h, and the factor 1 / (2 mu_i mu_j) per unit of depth.
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double scale = layer.s[i] * layer.s[j] / (2 * layer.mu[i] * layer.mu[j]);
            layer.scatter_odd.K[i * stride + j] *= scale;
            layer.scatter_even.K[i * stride + j] *= scale;
        }
}

}  // namespace stratus::STRATUS_ISA
