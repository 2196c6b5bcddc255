#include "orders.h"

#include <stratus/layer/single_scattering.h>

#include <cmath>

namespace stratus {

using Eigen::VectorXd;

VectorXd weights_of_orders(double albedo, int highest) {
    VectorXd weights(highest + 1);
    double power = 1;
    for (int n = 0; n <= highest; ++n, power *= albedo) weights(n) = power;
    return weights;
}

double sum_paths(Side side, const LayerSolution& layer, int lowest, double in, double out) {
    const double f = layer.truncation.fraction;
    const int highest = f > 0 ? static_cast<int>(layer.order_weights.size()) - 1 : 1;
    const PathWeights paths = path_weights(side, highest + 1, layer.optical_depth, in, out);
    double sum = 0;
    for (int n = lowest; n < paths.count; ++n)
        sum += layer.order_weights(n) * n * std::pow(f, n - 1) * paths.of_order[n];
    return sum;
}

double truncated_beam(const LayerSolution& layer, double mu) {
    const double f = layer.truncation.fraction, tau = layer.optical_depth;
    if (f == 0 || std::isinf(tau)) return 0;
    const VectorXd& weights = layer.order_weights;
    if (weights.size() == 0)
        return direct_transmittance(layer.truncation.optical_depth(tau, layer.albedo), mu) *
               -std::expm1(-f * layer.albedo * tau / mu);
    double sum = 0, term = direct_transmittance(tau, mu);
    for (Eigen::Index n = 1; n < weights.size(); ++n) {
        term *= f * tau / mu / static_cast<double>(n);
        sum += weights(n) * term;
    }
    return sum;
}

}  // namespace stratus
