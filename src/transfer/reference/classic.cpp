#include "classic.h"

#include <stratus/base/number_text.h>
#include <stratus/layer/single_scattering.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace stratus {

using Eigen::MatrixXd;
using Eigen::VectorXd;

PhaseKernels reference_phase_kernels(const Directions& directions,
                                     const std::vector<double>& moments, int mode) {
    const auto n = directions.size();
    const auto L = int_size(moments);
    // Rows l - m = k of sqrt((l-m)!/(l+m)!) P_l^m at all directions.
    MatrixXd legendre = MatrixXd::Zero(std::max(1, L - mode), n);
    for (int k = 0; k < L - mode; ++k) {
        const double l = mode + k, m = mode;
        if (k == 0) {
            legendre.row(0).setOnes();
            for (int j = 1; j <= mode; ++j)
                legendre.row(0).array() *=
                    ((2.0 * j - 1) / (2.0 * j) * (1 - directions.mu.array().square()))
                        .sqrt()
                        .transpose();
            continue;
        }
        legendre.row(k) = (2 * l - 1) * directions.mu.transpose().cwiseProduct(legendre.row(k - 1));
        if (k > 1) legendre.row(k) -= std::sqrt((l - 1) * (l - 1) - m * m) * legendre.row(k - 2);
        legendre.row(k) /= std::sqrt(l * l - m * m);
    }
    MatrixXd even = MatrixXd::Zero(n, n), odd = MatrixXd::Zero(n, n);
    for (int k = 0; k < L - mode; ++k) {
        const double c = (2 * (mode + k) + 1) * moments[size(mode + k)];
        (k % 2 ? odd : even) += c * legendre.row(k).transpose() * legendre.row(k);
    }
    if (mode == 0) {  // scale symmetrically until every row integrates to 1 (Sinkhorn)
        VectorXd d = VectorXd::Ones(n);
        for (int round = 0; round < 2000; ++round) {
            const VectorXd sum = d.asDiagonal() * (even * (directions.weight.cwiseProduct(d)));
            if ((sum.array() - 1).abs().maxCoeff() < 5e-16) break;
            d.head(directions.nodes).array() /= sum.head(directions.nodes).array().sqrt();
            d.tail(n - directions.nodes).array() /= sum.tail(n - directions.nodes).array();
        }
        even = MatrixXd(d.asDiagonal() * even * d.asDiagonal());
        odd = MatrixXd(d.asDiagonal() * odd * d.asDiagonal());
    }
    return {even - odd, even + odd};
}

namespace {

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
    const MatrixXd t =
        h * albedo / 2 * (scale.asDiagonal() * kernels.transmission * scale.asDiagonal());
    const MatrixXd r =
        h * albedo / 2 * (scale.asDiagonal() * kernels.reflection * scale.asDiagonal());
    const BeamMatrix sum = cayley({slant, -t - r}, N);
    const BeamMatrix difference = cayley(inverse({slant, r - t}, N), N);
    layer_ = {(sum.K + difference.K) / 2, (sum.K - difference.K) / 2};
}

void ClassicLayer::start_single(const PhaseKernels& kernels, double albedo) {
    const auto n = directions_.size();
    const VectorXd &mu = directions_.mu, &s = directions_.s;
    for (const Side side : both_sides) {
        layer_[side].resize(n, n);
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i)
                layer_[side](i, j) = s(i) * s(j) *
                                     single_scattering(side, kernels[side](i, j), albedo,
                                                       optical_depth_, mu(i), mu(j));
    }
}

void ClassicLayer::double_depth() {
    const int N = directions_.nodes;
    const VectorXd none = VectorXd::Zero(directions_.size());
    const BeamMatrix R{none, layer_.reflection};
    const BeamMatrix T{beam_along(directions_.mu, optical_depth_), layer_.transmission};
    BeamMatrix bounce = product(R, R, N);
    const BeamMatrix between =
        product(T, inverse({VectorXd::Ones(none.size()), -bounce.K}, N), N);  // T (I - R R)^-1
    layer_.reflection += product(between, product(R, T, N), N).K;
    layer_.transmission = product(between, T, N).K;
    optical_depth_ *= 2;
    if (layer_.reflection.allFinite() && layer_.transmission.allFinite()) return;
    throw std::runtime_error("solve: classic doubling broke down in mode " + std::to_string(mode_) +
                             " at optical depth " + short_number(optical_depth_, 6));
}

void ClassicLayer::double_to_infinity() {
    const int doublings = 60 + std::max(0, -std::ilogb(optical_depth_));
    for (int k = 0; k < doublings; ++k) double_depth();
}

}  // namespace stratus
