#include "boundary_modes.h"

#include <stratus/base/constants.h>

namespace stratus {

using Eigen::MatrixXd;
using Eigen::VectorXd;

BoundaryModes::BoundaryModes(const LowerBoundary& boundary, const Truncation& truncation,
                             const Directions& directions)
    : boundary_(boundary), truncation_(truncation), directions_(directions) {
    if (boundary.kind == LowerBoundary::Kind::layer)
        modes_.emplace(directions, LayerTask{truncation.moments, truncation.albedo(boundary.albedo),
                                             truncation.co_albedo(boundary.albedo), infinity});
}

int BoundaryModes::count() const {
    if (modes_) return modes_->count();
    if (boundary_.law) return 2 * directions_.nodes;
    return boundary_.kind == LowerBoundary::Kind::surface ? 1 : 0;
}

LayerMode BoundaryModes::layer(int mode) {
    const auto n = directions_.size();
    if (mode >= count()) return {MatrixXd::Zero(n, n), {}, {}, {}};
    if (modes_) return modes_->layer(mode);
    return {directions_.s.asDiagonal() * once(mode) * directions_.s.asDiagonal(), {}, {}, {}};
}

MatrixXd BoundaryModes::once(int mode) {
    const auto n = directions_.size();
    if (mode >= count()) return MatrixXd::Zero(n, n);
    // The weights of uniform illumination sum to 1 only from three nodes on; dividing by their sum
    // keeps a white surface from absorbing with fewer.
    if (boundary_.law) return ground(mode);
    if (!modes_)
        return MatrixXd::Constant(
            n, n, boundary_.albedo / directions_.s.head(directions_.nodes).squaredNorm());
    const double w = truncation_.albedo(boundary_.albedo);
    MatrixXd once = modes_->kernels(mode).other;
    for (Eigen::Index j = 0; j < n; ++j)
        for (Eigen::Index i = 0; i < n; ++i)
            once(i, j) *= single_reflection(1, w, infinity, directions_.mu(i), directions_.mu(j));
    return once;
}

const MatrixXd& BoundaryModes::ground(int mode) {
    constexpr int group = 16;
    if (ground_.empty() || mode < first_ || mode >= first_ + group) {
        first_ = mode / group * group;
        const auto n = directions_.size();
        ground_.assign(group, MatrixXd(n, n));
        const AzimuthalModes modes_at(first_, first_ + group);
        for (Eigen::Index j = 0; j < n; ++j)
            for (Eigen::Index i = 0; i <= j; ++i) {
                const std::vector<double> modes =
                    modes_at(*boundary_.law, directions_.mu(j), directions_.mu(i));
                for (std::size_t m = 0; m < group; ++m)
                    ground_[m](i, j) = ground_[m](j, i) = modes[m];
            }
    }
    return ground_[static_cast<std::size_t>(mode - first_)];
}

VectorXd BoundaryModes::entering() {
    const VectorXd& s = directions_.s;
    if (boundary_.kind == LowerBoundary::Kind::surface) return (1 - boundary_.albedo) * s;
    if (boundary_.albedo == 1) return VectorXd::Zero(s.size());
    const int N = directions_.nodes;
    return s - layer(0).reflection.leftCols(N) * s.head(N);
}

}  // namespace stratus
