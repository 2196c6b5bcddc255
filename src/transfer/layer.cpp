#include "layer.h"

#include <stratus/layer/single_scattering.h>

#include <cmath>

namespace stratus {

Eigen::VectorXd beam_along(const Directions& directions, double optical_depth) {
    return directions.mu.unaryExpr(  // Eigen's exp underflows at 2e-308
        [optical_depth](double mu) { return direct_transmittance(optical_depth, mu); });
}

double sum_modes(const std::vector<double>& modes, double azimuth) {
    const double c = std::cos(azimuth);
    double previous = c, now = 1, sum = 0;  // cos((m - 1) phi), cos(m phi)
    for (std::size_t m = 0; m < modes.size(); ++m) {
        sum += (m ? 2 : 1) * now * modes[m];
        const double next = 2 * c * now - previous;
        previous = now;
        now = next;
    }
    return sum;
}

double sum_modes(const std::vector<Eigen::MatrixXd>& modes, int i, int j, double azimuth) {
    std::vector<double> here;
    for (const Eigen::MatrixXd& mode : modes) here.push_back(mode(i, j));
    return sum_modes(here, azimuth);
}

}  // namespace stratus
