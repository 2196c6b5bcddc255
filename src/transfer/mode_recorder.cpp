#include "mode_recorder.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace stratus {

using Eigen::MatrixXd;
using Eigen::RowVector2d;
using Eigen::VectorXd;

ModeRecorder::ModeRecorder(const Directions& directions, ModeSolution& solution,
                           std::vector<SingleFactors> layers, Beam beam, bool is_symmetric,
                           const TakeMode* take)
    : directions_(directions),
      solution_(solution),
      unscale_(directions.s.tail(solution.mu.size()).cwiseInverse()),
      layers_(std::move(layers)),
      beam_(std::move(beam)),
      is_symmetric_(is_symmetric),
      take_(take) {}

MatrixXd ModeRecorder::unscaled(const MatrixXd& matrix) const {
    const auto count = unscale_.size();
    return unscale_.asDiagonal() * matrix.bottomRightCorner(count, count) * unscale_.asDiagonal();
}

void ModeRecorder::record(const LayerMode& all, const std::vector<const PhaseKernels*>& kernels,
                          BoundaryModes* boundary) {
    const int mode = recorded_++;
    const auto count = solution_.mu.size();
    ModeMatrices again{unscaled(all.reflection),
                       all.is_opaque() ? MatrixXd::Zero(count, count) : unscaled(all.transmission)};
    for (std::size_t k = 0; k < layers_.size(); ++k) {
        if (!kernels[k]) continue;
        again.reflection -= layers_[k].reflection.cwiseProduct(
            kernels[k]->reflection.bottomRightCorner(count, count));
        if (!all.is_opaque())
            again.transmission -= layers_[k].transmission.cwiseProduct(
                kernels[k]->transmission.bottomRightCorner(count, count));
    }
    if (boundary && mode < boundary->count()) {
        const VectorXd beam = beam_.unscattered.tail(count);
        again.reflection -= beam.asDiagonal() *
                            boundary->once(mode).bottomRightCorner(count, count) *
                            beam.asDiagonal();
    }
    for (const Side side : both_sides) {
        AzimuthalMode kept = is_symmetric_ ? AzimuthalMode::symmetric(again[side])
                                           : AzimuthalMode{std::move(again[side])};
        if (take_ == nullptr || !(*take_)(solution_, side, mode, kept))
            solution_.modes[side].push_back(std::move(kept));
    }
    if (mode == 0) record_fluxes(all);
}

void ModeRecorder::record_fluxes(const LayerMode& all) {
    const int N = directions_.nodes;
    const auto count = solution_.mu.size();
    const VectorXd s = directions_.s.head(N);
    // The weights of uniform illumination sum to 1 only from three nodes on.
    const double uniform = s.squaredNorm();
    solution_.spherical_albedo = uniform_mean(directions_, all.reflection);
    solution_.plane_albedo =
        unscale_.asDiagonal() * (all.reflection.bottomLeftCorner(count, N) * s);
    if (solution_.lower_boundary.is_present()) return;
    solution_.total_transmittance = 0;
    solution_.diffuse_transmittance = VectorXd::Zero(count);
    if (all.is_opaque()) return;
    solution_.total_transmittance = uniform_mean(directions_, all.transmission) +
                                    s.cwiseProduct(s).dot(beam_.unscattered.head(N)) / uniform;
    solution_.diffuse_transmittance =
        unscale_.asDiagonal() * (all.transmission.topRightCorner(N, count).transpose() * s);
    solution_.diffuse_transmittance += beam_.truncated.tail(count);
}

void ModeRecorder::record_boundary(const LayerMode& above, BoundaryModes& boundary) {
    if (above.is_opaque()) {
        solution_.ground_absorptance = solution_.diffuse_transmittance =
            VectorXd::Zero(solution_.mu.size());
        solution_.spherical_ground_absorptance = solution_.total_transmittance = 0;
        return;
    }
    MatrixXd weights(directions_.size(), 2);
    weights << boundary.entering(), directions_.s;
    const LowerBoundary& below = solution_.lower_boundary;
    record_fluxes_below(
        below.is_surface()
            ? flux_over_surface(above, below.albedo) * RowVector2d(1 - below.albedo, 1)
            : diffuse_flux_between(above, boundary.layer(0), weights, directions_.nodes),
        weights);
}

VectorXd ModeRecorder::flux_over_surface(const LayerMode& above, double albedo) const {
    // The light that falls on the surface is t + A R* t + (A R*)^2 t + ... = t / (1 - A R*), for it sends back
    // uniform light. Without absorption R* = 1 - T, where 1 - R* would lose T of deep layers.
    const int N = directions_.nodes;
    const VectorXd s = directions_.s.head(N);
    const VectorXd diffuse = above.transmission.topRows(N).transpose() * s;
    const VectorXd all = diffuse + above.beam.cwiseProduct(directions_.s);
    const double T = s.dot(all.head(N)) / s.squaredNorm();
    const bool is_conservative = above.is_conservative();
    const double R = is_conservative ? 1 - T : uniform_mean(directions_, above.reflection_below);
    const double lost = 1 - albedo + albedo * (is_conservative ? T : 1 - R);
    return diffuse + albedo * R / lost * all;
}

void ModeRecorder::record_fluxes_below(const MatrixXd& diffuse, const MatrixXd& weights) {
    const auto count = solution_.mu.size();
    const MatrixXd flux = diffuse + beam_.unscattered.asDiagonal() * weights;
    solution_.ground_absorptance = flux.col(0).tail(count).cwiseProduct(unscale_);
    solution_.diffuse_transmittance =
        diffuse.col(1).tail(count).cwiseProduct(unscale_) + beam_.truncated.tail(count);
    const VectorXd s = directions_.s.head(directions_.nodes);
    const Eigen::Vector2d uniform =
        flux.topRows(directions_.nodes).transpose() * s / s.squaredNorm();
    solution_.spherical_ground_absorptance = uniform(0);
    solution_.total_transmittance = uniform(1);
}

bool ModeRecorder::is_negligible(int count, double tolerance) const {
    const auto adds = [&](Side side) {
        const std::vector<AzimuthalMode>& modes = solution_.modes[side];
        const auto last = std::span(modes).last(size(count));
        for (Eigen::Index out = 0; out < solution_.mu.size(); ++out)
            for (Eigen::Index in = 0; in < solution_.mu.size(); ++in) {
                double all = std::abs(modes[0](in, out));
                for (const SingleFactors& layer : layers_) all += layer[side](in, out);
                const auto is_more = [&](const AzimuthalMode& mode) {
                    return 2 * std::abs(mode(in, out)) > tolerance * all;
                };
                if (std::ranges::any_of(last, is_more)) return true;
            }
        return false;
    };
    return std::ranges::none_of(both_sides, adds);
}

}  // namespace stratus
