#include "classic.h"

#include <stratus/layer/single_scattering.h>

#include "../beam_matrix.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace stratus {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// (I + F)^-1 (I - F) = 2 (I + F)^-1 - I.
BeamMatrix cayley(const BeamMatrix& F, int nodes) {
    const BeamMatrix half = inverse({F.d.array() + 1, F.K}, nodes);
    return {2 * half.d.array() - 1, 2 * half.K};
}

}  // namespace

int count_classic_doublings(const Directions& directions, double optical_depth,
                            double start_depth) {
    const double thickest = start_depth > 0 ? start_depth : 1e-3 * directions.mu.minCoeff();
    int doublings = 0;
    while (std::ldexp(optical_depth, -doublings) > thickest) ++doublings;
    return doublings;
}

ClassicLayer::ClassicLayer(const Directions& directions, const PhaseKernels& kernels, int mode,
                           double albedo, double thin_depth, ClassicStart start)
    : directions_(directions), mode_(mode), optical_depth_(thin_depth) {
    if (start == ClassicStart::diamond)
        start_diamond(kernels, albedo);
    else
        start_single(kernels, albedo);
}

void ClassicLayer::start_diamond(const PhaseKernels& kernels, double albedo) {
    const int N = directions_.nodes;
    const double h = optical_depth_ / 2;
    const VectorXd scale = directions_.s.cwiseQuotient(directions_.mu) / std::sqrt(2.0);
    const VectorXd slant = h * directions_.mu.cwiseInverse();
    const MatrixXd t = h * albedo / 2 * (scale.asDiagonal() * kernels.same * scale.asDiagonal());
    const MatrixXd r = h * albedo / 2 * (scale.asDiagonal() * kernels.other * scale.asDiagonal());
    const BeamMatrix sum = cayley({slant, -t - r}, N);
    const BeamMatrix difference = cayley(inverse({slant, r - t}, N), N);
    reflection_ = (sum.K + difference.K) / 2;
    transmission_ = (sum.K - difference.K) / 2;
}

void ClassicLayer::start_single(const PhaseKernels& kernels, double albedo) {
    const auto n = directions_.size();
    const VectorXd &mu = directions_.mu, &s = directions_.s;
    reflection_.resize(n, n);
    transmission_.resize(n, n);
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            reflection_(i, j) =
                s(i) * s(j) *
                single_reflection(kernels.other(i, j), albedo, optical_depth_, mu(i), mu(j));
            transmission_(i, j) =
                s(i) * s(j) *
                single_transmission(kernels.same(i, j), albedo, optical_depth_, mu(i), mu(j));
        }
}

void ClassicLayer::double_depth() {
    const int N = directions_.nodes;
    const VectorXd none = VectorXd::Zero(directions_.size());
    const BeamMatrix R{none, reflection_};
    const BeamMatrix T{beam_along(directions_, optical_depth_), transmission_};
    BeamMatrix bounce = product(R, R, N);
    const BeamMatrix between =
        product(T, inverse({VectorXd::Ones(none.size()), -bounce.K}, N), N);  // T (I - R R)^-1
    reflection_ += product(between, product(R, T, N), N).K;
    transmission_ = product(between, T, N).K;
    optical_depth_ *= 2;
    if (reflection_.allFinite() && transmission_.allFinite()) return;
    std::ostringstream line;
    line << "solve: classic doubling broke down in mode " << mode_ << " at optical depth "
         << optical_depth_;
    throw std::runtime_error(line.str());
}

void ClassicLayer::double_to_infinity() {
    const int doublings = 60 + std::max(0, -std::ilogb(optical_depth_));
    for (int k = 0; k < doublings; ++k) double_depth();
}

}  // namespace stratus
