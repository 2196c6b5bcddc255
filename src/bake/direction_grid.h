// Light scattered more than once at all pairs of some directions and at some azimuths.
#pragma once

#include <stratus/transfer/solve.h>

#include <functional>
#include <span>
#include <vector>

namespace stratus {

/// All pairs of `mu` with all azimuths, and what depends on nothing else.
struct DirectionGrid {
    DirectionGrid(const PhaseFunction& phase_function, const LowerBoundary& boundary,
                  std::vector<double> cosines, std::vector<double> azimuths);

    std::size_t at(std::size_t i, std::size_t j, std::size_t k) const {
        return (i * mu.size() + j) * azimuth.size() + k;
    }

    std::vector<double> mu, azimuth;

    // phase functions over (mu, mu, azimuth)
    std::vector<double> reflected_phase, transmitted_phase, boundary_phase;
};

/// cos(m azimuth), twice that where m > 0, over (azimuth, mode).
Eigen::MatrixXd fourier_cosines(const std::vector<double>& azimuths, Eigen::Index modes);

/// Calls use(i, j, values) for all i <= j: orders n >= 2 of one side over the azimuths, with what
/// truncation took out of the layer and of its lower boundary.
///
/// Shapes   the layer solved at the cosines of the grid; cosines of the grid's azimuths, of at
///          least as many modes as the layer has.
void visit_multiple_scattering(
    const LayerSolution& layer, Side side, const DirectionGrid& grid,
    const Eigen::MatrixXd& cosines,
    const std::function<void(std::size_t i, std::size_t j, std::span<const double> values)>& use);

}  // namespace stratus
