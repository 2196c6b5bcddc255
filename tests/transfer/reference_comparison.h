// Solver against discrete ordinates, shared by the fast and the slow comparison.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>

#include "../reference/discrete_ordinates.h"
#include "usual_layers.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace stratus::test {

/// A phase function of the files and the largest relative error allowed.
struct Accuracy {
    const char* phase;
    int nodes;
    double allowed, allowed_of_fluxes;
};

/// One number compared; the row's own uncertainty is not counted as an error.
struct Compared {
    double error;  // relative
    std::string row;
};

inline double error_beyond(double stated, double found, double expected) {
    const double error = std::abs(found - expected) - 3 * stated;
    return std::isnan(error) ? infinity : std::max(0.0, error);
}

inline std::string name_row(const ReferenceLayer& layer, const std::vector<double>& row) {
    std::ostringstream text;
    text << "w " << layer.albedo << " tau " << layer.optical_depth << " row";
    for (const double number : row) text << ' ' << number;
    return text.str();
}

/// R and T of every geometry of discrete_ordinates.csv, T above 1e-10 only.
inline std::vector<Compared> compare_geometries(const std::string& phase, int nodes) {
    const PhaseFunction phase_function = reference_phase_function(phase);
    const std::vector<double> cosines{0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0};
    const auto index = [&](double mu) {
        return static_cast<int>(std::ranges::find(cosines, mu) - cosines.begin());
    };
    std::vector<Compared> all;
    for (const ReferenceLayer& of : read_reference("discrete_ordinates.csv", phase)) {
        const LayerSolution layer =
            solve_layer(phase_function, of.albedo, of.optical_depth, cosines, with_nodes(nodes));
        for (const std::vector<double>& row : of.rows) {  // mu0 mu dphi_deg R T R_ss T_ss err err
            const int in = index(row.at(0)), out = index(row.at(1));
            const double azimuth = radians(row.at(2)), R = row.at(3), T = row.at(4);
            all.push_back({error_beyond(row.at(7), layer.reflection(in, out, azimuth).total, R) / R,
                           "R " + name_row(of, row)});
            if (T > 1e-10)
                all.push_back(
                    {error_beyond(row.at(8), layer.transmission(in, out, azimuth).total, T) / T,
                     "T " + name_row(of, row)});
        }
    }
    std::ranges::sort(all, {}, &Compared::error);
    return all;
}

/// Fluxes of both files: errors relative to the incident light, which is 1.
inline std::vector<Compared> compare_fluxes(const std::string& phase, int nodes) {
    const PhaseFunction phase_function = reference_phase_function(phase);
    std::vector<Compared> all;
    const auto compare = [&](double found, double expected, double stated, std::string row) {
        all.push_back({error_beyond(stated, found, expected), std::move(row)});
    };
    SolverOptions options = with_nodes(nodes);
    options.modes = 1;
    for (const ReferenceLayer& of : read_reference("discrete_ordinates_flux.csv", phase)) {
        std::vector<double> cosines;
        for (const std::vector<double>& row : of.rows) cosines.push_back(row.at(0));
        const LayerSolution layer =
            solve_layer(phase_function, of.albedo, of.optical_depth, cosines, options);
        Eigen::Index at = 0;
        for (const std::vector<double>& row : of.rows) {  // mu0 albedo diffuse direct total err err
            compare(layer.plane_albedo(at), row.at(1), row.at(5), "albedo " + name_row(of, row));
            compare(layer.diffuse_transmittance(at++), row.at(2), row.at(6),
                    "transmittance " + name_row(of, row));
        }
    }
    for (const ReferenceLayer& of : read_reference("discrete_ordinates_spherical.csv", phase)) {
        const LayerSolution layer =
            solve_layer(phase_function, of.albedo, of.optical_depth, {}, options);
        const std::vector<double>& row = of.rows.at(0);  // spherical albedo, transmittance, err err
        compare(layer.spherical_albedo, row.at(0), row.at(2), "URU " + name_row(of, row));
        compare(layer.total_transmittance, row.at(1), row.at(3), "UTU " + name_row(of, row));
    }
    std::ranges::sort(all, {}, &Compared::error);
    return all;
}

class DiscreteOrdinates : public testing::TestWithParam<Accuracy> {};

TEST_P(DiscreteOrdinates, AreMatchedAtEveryGeometry) {
    const Compared worst = compare_geometries(GetParam().phase, GetParam().nodes).back();
    EXPECT_LE(worst.error, GetParam().allowed) << worst.row;
}

TEST_P(DiscreteOrdinates, AreMatchedInFluxes) {
    const Compared worst = compare_fluxes(GetParam().phase, GetParam().nodes).back();
    EXPECT_LE(worst.error, GetParam().allowed_of_fluxes) << worst.row;
}

inline const auto phase_name = [](const auto& row) { return row.param.phase; };

}  // namespace stratus::test
