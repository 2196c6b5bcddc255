#include "direction_grid.h"

#include <cmath>
#include <utility>

namespace stratus {

DirectionGrid::DirectionGrid(const PhaseFunction& phase_function, const LowerBoundary& boundary,
                             std::vector<double> cosines, std::vector<double> azimuths)
    : mu(std::move(cosines)), azimuth(std::move(azimuths)) {
    for (const double in : mu)
        for (const double out : mu)
            for (const double phi : azimuth) {
                const Geometry geometry{in, out, phi};
                reflected_phase.push_back(phase_function(cos_scattering_angle_reflected(geometry)));
                transmitted_phase.push_back(
                    phase_function(cos_scattering_angle_transmitted(geometry)));
                boundary_phase.push_back(boundary_phase_value(boundary, geometry));
            }
}

Eigen::MatrixXd fourier_cosines(const std::vector<double>& azimuths, Eigen::Index modes) {
    Eigen::MatrixXd cosines(static_cast<Eigen::Index>(azimuths.size()), modes);
    for (Eigen::Index k = 0; k < cosines.rows(); ++k)
        for (Eigen::Index m = 0; m < modes; ++m)
            cosines(k, m) = (m ? 2 : 1) * std::cos(static_cast<double>(m) *
                                                   azimuths[static_cast<std::size_t>(k)]);
    return cosines;
}

void visit_multiple_scattering(
    const LayerSolution& layer, Side side, const DirectionGrid& grid,
    const Eigen::MatrixXd& cosines,
    const std::function<void(std::size_t i, std::size_t j, std::span<const double> values)>& use) {
    const bool reflects = side == Side::reflection;
    const auto& modes = reflects ? layer.reflection_modes : layer.transmission_modes;
    const auto& phase = reflects ? grid.reflected_phase : grid.transmitted_phase;
    const auto cos_scattering_angle =
        reflects ? cos_scattering_angle_reflected : cos_scattering_angle_transmitted;
    const bool over_boundary = reflects && layer.lower_boundary.is_present();
    const Eigen::MatrixXd boundary =
        over_boundary ? layer.boundary_correction() : Eigen::MatrixXd();
    const auto count = static_cast<Eigen::Index>(modes.size());
    Eigen::VectorXd series(count), sum(cosines.rows());
    std::vector<double> scattering_cosines(grid.azimuth.size());
    for (std::size_t i = 0; i < grid.mu.size(); ++i)
        for (std::size_t j = i; j < grid.mu.size(); ++j) {
            const auto in = static_cast<int>(i), out = static_cast<int>(j);
            for (Eigen::Index m = 0; m < count; ++m)
                series(m) = modes[static_cast<std::size_t>(m)](in, out);
            sum.noalias() = cosines.leftCols(count) * series;
            const PeakCorrection correction = reflects ? layer.reflection_correction(in, out)
                                                       : layer.transmission_correction(in, out);
            for (std::size_t k = 0; k < scattering_cosines.size(); ++k)
                scattering_cosines[k] =
                    cos_scattering_angle({grid.mu[i], grid.mu[j], grid.azimuth[k]});
            const std::vector<double> scattered_again =
                sum_legendre(correction.legendre, scattering_cosines);
            for (std::size_t k = 0; k < scattering_cosines.size(); ++k) {
                const std::size_t at = grid.at(i, j, k);
                double& value = sum(static_cast<Eigen::Index>(k));
                value += correction.single * phase[at] + scattered_again[k];
                if (over_boundary) value += boundary(in, out) * grid.boundary_phase[at];
            }
            use(i, j, {sum.data(), scattering_cosines.size()});
        }
}

}  // namespace stratus
