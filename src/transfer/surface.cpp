#include "surface.h"

#include <limits>

namespace stratus {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

BelowModes::BelowModes(const Below& below, const Truncation& truncation,
                       const Directions& directions, const LaneMethods& methods)
    : below_(below), truncation_(truncation), directions_(directions) {
    if (below.kind == Below::Kind::layer)
        modes_.emplace(directions,
                       LayerTask{truncation.moments, truncation.albedo(below.albedo),
                                 truncation.co_albedo(below.albedo), infinity},
                       methods);
}

int BelowModes::count() const {
    if (modes_) return modes_->count();
    return below_.kind == Below::Kind::surface ? 1 : 0;
}

LayerMode BelowModes::layer(int mode) {
    const auto n = directions_.size();
    if (mode >= count()) return {MatrixXd::Zero(n, n), {}, {}, {}};
    if (modes_) return modes_->layer(mode);
    return {directions_.s.asDiagonal() * once(0) * directions_.s.asDiagonal(), {}, {}, {}};
}

MatrixXd BelowModes::once(int mode) {
    const auto n = directions_.size();
    if (mode >= count()) return MatrixXd::Zero(n, n);
    // The weights of uniform illumination sum to 1 from three nodes on, not with fewer: a white
    // surface absorbs nothing with any number of them.
    if (!modes_)
        return MatrixXd::Constant(
            n, n, below_.albedo / directions_.s.head(directions_.nodes).squaredNorm());
    const double w = truncation_.albedo(below_.albedo);
    MatrixXd once = modes_->kernels(mode).other;
    for (Eigen::Index j = 0; j < n; ++j)
        for (Eigen::Index i = 0; i < n; ++i)
            once(i, j) *= single_reflection(1, w, infinity, directions_.mu(i), directions_.mu(j));
    return once;
}

VectorXd BelowModes::entering() {
    const VectorXd& s = directions_.s;
    if (!modes_) return (1 - below_.albedo) * s;
    if (below_.albedo == 1) return VectorXd::Zero(s.size());
    const int N = directions_.nodes;
    return s - modes_->layer(0).reflection.leftCols(N) * s.head(N);
}

}  // namespace stratus
