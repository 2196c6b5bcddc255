// Directions, phase functions, options and comparisons of the tests of layers.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/transfer/solve.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <ostream>
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

/// A way of light: a side, two cosines of a solution and an azimuth.
struct Way {
    Side side;
    int in, out;
    double azimuth;

    Way back() const { return {side, out, in, azimuth}; }
    template <class Solution>
    auto of(const Solution& solution) const {
        return value_at(solution, side, in, out, azimuth);
    }
    template <class Solution>
    Geometry geometry(const Solution& solution) const {
        return {solution.mu(in), solution.mu(out), azimuth};
    }
    friend std::ostream& operator<<(std::ostream& text, const Way& way) {
        return text << (way.side == Side::reflection ? "R " : "T ") << way.in << ' ' << way.out
                    << ' ' << way.azimuth;
    }
};

/// All ways between that many cosines, azimuths fastest.
inline std::vector<Way> ways(int count, const std::vector<double>& at = azimuths) {
    std::vector<Way> all;
    for (const Side side : both_sides)
        for (int in = 0; in < count; ++in)
            for (int out = 0; out < count; ++out)
                for (const double azimuth : at) all.push_back({side, in, out, azimuth});
    return all;
}

/// A series of 38 moments, cut off so early that it is negative in places.
inline std::vector<double> moments_cut_off() {
    std::vector<double> chi{1};
    for (int l = 1; l < 38; ++l) chi.push_back(0.85 * chi.back());
    return chi;
}

/// R, then T, between all cosines.
template <class Solution>
Eigen::ArrayXd all_radiances(const Solution& of, const std::vector<double>& at = azimuths) {
    std::vector<double> all;
    for (const Way& way : ways(static_cast<int>(of.mu.size()), {0}))
        for (const SolvedValue& value : of.values(way.side, way.in, way.out, at))
            all.push_back(value.total);
    return Eigen::Map<Eigen::ArrayXd>(all.data(), std::ssize(all));
}

/// Largest relative difference of R and T over all geometries; NaN if any is.
template <class A, class B>
double difference(const A& a, const B& b, const std::vector<double>& at = azimuths) {
    const Eigen::ArrayXd of_a = all_radiances(a, at), of_b = all_radiances(b, at);
    double worst = 0;
    for (int i = 0; i < of_a.size(); ++i) {
        if (of_a(i) == of_b(i)) continue;
        const double one = std::abs(of_a(i) / of_b(i) - 1);
        if (std::isnan(one)) return one;
        worst = std::max(worst, one);
    }
    return worst;
}

/// Those, then plane albedos and diffuse transmittances.
template <class Solution>
Eigen::ArrayXd all_values(const Solution& of, const std::vector<double>& at = azimuths) {
    Eigen::ArrayXd all(all_radiances(of, at).size() + 2 * of.mu.size());
    all << all_radiances(of, at), of.plane_albedo.array(), of.diffuse_transmittance.array();
    return all;
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
