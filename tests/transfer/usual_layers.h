// Directions, phase functions, options and comparisons of the tests of layers.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/transfer/solve.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

namespace stratus {

inline const std::vector<double> cosines{0.02, 0.1, 0.5, 0.9, 1.0};
inline const std::vector<double> azimuths{0, 1, 2, pi};

inline const PhaseFunction isotropic = PhaseFunction::isotropic();
inline const PhaseFunction rayleigh = PhaseFunction::rayleigh();
inline const PhaseFunction saturn =
    parse_phase_function("0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5");
inline const PhaseFunction forward = PhaseFunction::henyey_greenstein(0.75);
inline const PhaseFunction peaked = PhaseFunction::henyey_greenstein(0.95);

inline const LowerBoundary nothing;

inline SolverOptions with_nodes(int nodes, Truncate truncate = Truncate::smooth) {
    SolverOptions options;
    options.nodes = nodes;
    options.truncate = truncate;
    return options;
}

/// R or T between two cosines.
template <class Solution>
auto value_at(const Solution& of, Side side, int in, int out, double azimuth) {
    return side == Side::reflection ? of.reflection(in, out, azimuth)
                                    : of.transmission(in, out, azimuth);
}

/// A series of 38 moments, cut off so early that it is negative in places.
inline std::vector<double> moments_cut_off() {
    std::vector<double> chi{1};
    for (int l = 1; l < 38; ++l) chi.push_back(0.85 * chi.back());
    return chi;
}

/// Largest relative difference of R and T over all geometries; NaN if any is.
template <class A, class B>
double difference(const A& a, const B& b, const std::vector<double>& at = azimuths) {
    double worst = 0;
    for (const Side side : both_sides)
        for (int in = 0; in < a.mu.size(); ++in)
            for (int out = 0; out < a.mu.size(); ++out) {
                const auto from_a = a.values(side, in, out, at);
                const auto from_b = b.values(side, in, out, at);
                for (std::size_t k = 0; k < at.size(); ++k) {
                    if (from_a[k].total == from_b[k].total) continue;
                    const double one = std::abs(from_a[k].total / from_b[k].total - 1);
                    if (std::isnan(one)) return one;
                    worst = std::max(worst, one);
                }
            }
    return worst;
}

/// R, then T, between all cosines; then plane albedos and diffuse transmittances.
template <class Solution>
Eigen::ArrayXd all_values(const Solution& of, const std::vector<double>& at = azimuths) {
    std::vector<double> all;
    for (const Side side : both_sides)
        for (int in = 0; in < of.mu.size(); ++in)
            for (int out = 0; out < of.mu.size(); ++out)
                for (const SolvedValue& value : of.values(side, in, out, at))
                    all.push_back(value.total);
    for (const Eigen::VectorXd& fluxes : {of.plane_albedo, of.diffuse_transmittance})
        all.insert(all.end(), fluxes.begin(), fluxes.end());
    return Eigen::Map<Eigen::ArrayXd>(all.data(), std::ssize(all));
}

/// Fails unless every number is within its tolerance.
inline void expect_near(const Eigen::ArrayXd& found, const Eigen::ArrayXd& expected,
                        const Eigen::ArrayXd& tolerance) {
    for (int i = 0; i < expected.size(); ++i)
        EXPECT_NEAR(found(i), expected(i), tolerance(i)) << "value " << i;
}

/// All light that falls on a layer without absorption leaves it.
template <class Solution>
void expect_conserved(const Solution& of, double depth, double tolerance) {
    EXPECT_NEAR(of.spherical_albedo + of.total_transmittance, 1, tolerance) << depth;
    for (int i = 0; i < of.mu.size(); ++i)
        EXPECT_NEAR(of.plane_albedo(i) + of.diffuse_transmittance(i) +
                        direct_transmittance(depth, of.mu(i)),
                    1, tolerance)
            << "depth " << depth << " mu " << of.mu(i);
}

}  // namespace stratus
