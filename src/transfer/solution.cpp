#include <stratus/transfer/solve.h>

#include <stratus/base/size.h>

#include "options.h"
#include "orders.h"
#include "paths.h"

#include <algorithm>
#include <utility>

namespace stratus {

namespace {

/// TMS minus the closed form of the layer itself, per unit of phase function. [NT88]
double single_correction(const LayerSolution& layer, Side side, int in, int out) {
    const double x = layer.mu(in), y = layer.mu(out);
    if (layer.order_weights.size()) return sum_paths(side, layer, 2, x, y);
    const Truncation& truncation = layer.truncation;
    return single_scattering(side, 1, truncation.single_scattering_albedo(layer.albedo),
                             truncation.optical_depth(layer.optical_depth, layer.albedo), x, y) -
           single_scattering(side, 1, layer.albedo, layer.optical_depth, x, y);
}

PeakCorrection path_correction(const LayerSolution& layer, Side side, int in, int out) {
    const PathWeights weights = layer.path_weights(side, in, out);
    std::vector<double> sum = layer.path->law().legendre(weights);
    const Eigen::VectorXd rest = layer.path->rest({&weights, 1});
    sum.resize(std::max(sum.size(), size(rest.size())));
    for (Eigen::Index l = 0; l < rest.size(); ++l) sum[size(l)] += rest(l);
    return {0, std::move(sum)};
}

}  // namespace

AzimuthalMode AzimuthalMode::symmetric(const Eigen::MatrixXd& all) {
    AzimuthalMode mode{Eigen::MatrixXd(all.cols() * (all.cols() + 1) / 2, 1)};
    Eigen::Index next = 0;
    for (Eigen::Index column = 0; column < all.cols(); next += ++column)
        mode.values.col(0).segment(next, column + 1) = all.col(column).head(column + 1);
    return mode;
}

PeakCorrection LayerSolution::peak_correction(Side side, int in, int out) const {
    if (path) return path_correction(*this, side, in, out);
    if (backward_path)
        return {0, backward_path->legendre(side, albedo, optical_depth, mu(in), mu(out))};
    if (truncation.fraction == 0) return {};
    return {single_correction(*this, side, in, out), {}};
}

Eigen::VectorXd LayerSolution::path_orders() const {
    const int orders = path->law().order_count();
    if (order_weights.size() == 0) return weights_of_orders(albedo, orders - 1);
    return order_weights.head(std::min<Eigen::Index>(order_weights.size(), orders));
}

PathWeights LayerSolution::path_weights(Side side, int in, int out) const {
    const Eigen::VectorXd orders = path_orders();
    PathWeights weights =
        stratus::path_weights(side, int_size(orders), optical_depth, mu(in), mu(out));
    for (int n = 0; n < weights.count; ++n) weights.of_order[n] *= orders(n);
    return weights;
}

double LayerSolution::boundary_correction(int in, int out) const {
    if (truncation.fraction == 0 && boundary_truncation.fraction == 0) return 0;
    const double depth = truncation.optical_depth(optical_depth, albedo);
    return single_reflection_of_boundary(truncated(lower_boundary, boundary_truncation), 1, depth,
                                         mu(in), mu(out)) -
           single_reflection_of_boundary(lower_boundary, 1, optical_depth, mu(in), mu(out));
}

}  // namespace stratus
