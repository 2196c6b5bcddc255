#include "depth_regime.h"

#include <stratus/base/constants.h>

#include <algorithm>
#include <cmath>

namespace stratus {

namespace {

/// Reduced depth (1 - g) tau beyond which a conservative layer transmits by the law of diffusion to
/// rounding, also where scattering keeps to two opposite directions. Doubling resolves the gap between
/// Y and Z, of order 1/tau, the worse the deeper the layer.
constexpr double conservative_depth = 4096;  // 2^12

/// T of a conservative layer over T of one of depth `last_depth`, given T there and at half of it:
/// 1/T grows in proportion to the depth, by 3/4 (1 - g) [vdH80] to the accuracy of the nodes.
double transmitted_share_beyond(double last_depth, double of_half, double of_last_depth,
                                double optical_depth) {
    const double growth = (1 / of_last_depth - 1 / of_half) / (last_depth / 2);
    return 1 / (1 + growth * of_last_depth * (optical_depth - last_depth));
}

}  // namespace

DepthTarget choose_target(double optical_depth, bool conservative, double asymmetry) {
    if (std::isinf(optical_depth)) return {optical_depth, DepthRegime::infinite, infinity};
    if (optical_depth < thinnest_depth) return {optical_depth, DepthRegime::thin, thinnest_depth};
    const double last_depth = conservative_depth / std::max(1e-16, 1 - asymmetry);
    if (conservative && optical_depth > last_depth)
        return {optical_depth, DepthRegime::conservative, last_depth};
    return {optical_depth};
}

DepthLadder ladder_to(const DepthTarget& target) {
    switch (target.regime) {
        case DepthRegime::infinite: return {1, 0, true};
        case DepthRegime::conservative: return {target.doubled_depth / 2, 2, false};
        default: return {target.doubled_depth, 1, false};
    }
}

ModeMatrices reach(const DepthTarget& target, int mode, double half_transmittance,
                   const Directions& directions, ModeMatrices layer) {
    switch (target.regime) {
        case DepthRegime::solved: break;
        case DepthRegime::thin: {
            const double share = target.optical_depth / target.doubled_depth;
            layer.reflection *= share;
            layer.transmission *= share;
            break;
        }
        case DepthRegime::conservative: {  // R gains what T loses; T of higher modes is 0
            if (mode > 0) break;
            const double kept = transmitted_share_beyond(
                target.doubled_depth, half_transmittance,
                uniform_mean(directions, layer.transmission), target.optical_depth);
            layer.reflection += (1 - kept) * layer.transmission;
            layer.transmission *= kept;
            break;
        }
        case DepthRegime::infinite:  // DoublingLadder::is_converged
            layer.reflection += layer.transmission;
            layer.transmission.resize(0, 0);
            break;
    }
    return layer;
}

double uniform_mean(const Directions& directions, const Eigen::MatrixXd& mode) {
    const int N = directions.nodes;
    const Eigen::VectorXd s = directions.s.head(N);
    return s.dot(mode.topLeftCorner(N, N) * s) / s.squaredNorm();
}

int count_doublings(double smallest_cosine, double optical_depth) {
    return optical_depth <= smallest_cosine
               ? 0
               : static_cast<int>(std::ceil(std::log2(optical_depth) - std::log2(smallest_cosine)));
}

int max_doublings_to_infinity(double optical_depth) {
    return 120 + std::max(0, -std::ilogb(optical_depth));
}

}  // namespace stratus
