#include <stratus/transfer/stack.h>

#include <stratus/runtime/argument.h>
#include <stratus/transfer/adding.h>
#include <stratus/transfer/layer.h>

#include "boundary_modes.h"
#include "layer_modes.h"
#include "options.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace stratus {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Light of one mode that is scattered once, unscaled; or, for a phase value of 1, its mean.
struct Once {
    MatrixXd reflection, transmission;
};

/// The optical depth that lies above and below a layer of a stack.
struct Place {
    double above = 0, below = 0;
};

std::vector<Place> places_of(const std::vector<double>& depths) {
    std::vector<Place> places(depths.size());
    for (std::size_t k = 1; k < depths.size(); ++k)
        places[k].above = places[k - 1].above + depths[k - 1];
    for (std::size_t k = depths.size() - 1; k > 0; --k)
        places[k - 1].below = places[k].below + depths[k];
    return places;
}

/// Single scattering of the layer there, seen from outside the stack.
double single_reflection_at(const Place& place, double phase_value, double albedo, double depth,
                            double mu_in, double mu_out) {
    return direct_transmittance(place.above, mu_in) * direct_transmittance(place.above, mu_out) *
           single_reflection(phase_value, albedo, depth, mu_in, mu_out);
}

double single_transmission_at(const Place& place, double phase_value, double albedo, double depth,
                              double mu_in, double mu_out) {
    return direct_transmittance(place.above, mu_in) * direct_transmittance(place.below, mu_out) *
           single_transmission(phase_value, albedo, depth, mu_in, mu_out);
}

class StackSolver {
  public:
    StackSolver(const std::vector<StackLayer>& layers, const LowerBoundary& boundary,
                const std::vector<double>& mu, const SolverOptions& options)
        : options_(options), directions_(solved_directions(layers, boundary, mu, options)) {
        solution_.layers = layers;
        solution_.lower_boundary = boundary;
        solution_.mu =
            directions_.mu.tail(mu.empty() ? options.nodes : static_cast<Eigen::Index>(mu.size()));
        for (const StackLayer& layer : layers) {
            const Truncation& truncation = solution_.truncations.emplace_back(
                truncation_of(layer.phase_function, options, true));
            depths_.push_back(truncation.optical_depth(layer.optical_depth, layer.albedo));
        }
        solution_.boundary_truncation = truncation_of(boundary, options);
        places_ = places_of(depths_);
    }

    StackSolution run() {
        const DoublingSteps& steps = doubling_steps();
        for (std::size_t k = 0; k < depths_.size(); ++k) {
            const Truncation& truncation = solution_.truncations[k];
            const double albedo = solution_.layers[k].albedo;
            layers_.emplace_back(directions_,
                                 LayerTask{truncation.moments, truncation.albedo(albedo),
                                           truncation.co_albedo(albedo), depths_[k]},
                                 steps);
        }
        BoundaryModes boundary(solution_.lower_boundary, solution_.boundary_truncation, directions_,
                               steps);
        int most = std::max(1, boundary.count());
        for (const LayerModes& layer : layers_) most = std::max(most, layer.count());
        if (options_.modes) most = std::min(options_.modes, most);
        for (int mode = 0; mode < most; ++mode) {
            solve_mode(mode, boundary);
            const bool end_of_pack = (mode + 1) % lane_count == 0;
            if (!options_.modes && end_of_pack && mode >= lane_count && is_negligible(mode)) break;
        }
        return std::move(solution_);
    }

  private:
    /// One set for all layers, fine near mu = 1 when any of them asks for it.
    static Directions solved_directions(const std::vector<StackLayer>& layers,
                                        const LowerBoundary& boundary,
                                        const std::vector<double>& mu,
                                        const SolverOptions& options) {
        auto map_of = [&](const Truncation& truncation) {
            return choose_node_map(truncation.moments, options.nodes);
        };
        NodeMap map = map_of(truncation_of(boundary, options));
        for (const StackLayer& layer : layers)
            map = joint_map(map, map_of(truncation_of(layer.phase_function, options, true)));
        return gauss_directions(options.nodes, map, mu);
    }

    LayerMode mode_of(std::size_t k, int mode) {
        if (mode < layers_[k].count()) return layers_[k].layer(mode);
        const MatrixXd none = MatrixXd::Zero(directions_.size(), directions_.size());
        if (std::isinf(depths_[k])) return {none, {}, {}, {}};
        return {none, none, none, layers_[k].layer(0).beam};
    }

    void solve_mode(int mode, BoundaryModes& boundary) {
        LayerMode sum = mode_of(0, mode);
        for (std::size_t k = 1; k < layers_.size(); ++k)
            sum = add(sum, mode_of(k, mode), directions_.nodes);
        if (solution_.lower_boundary.is_present()) {
            const LayerMode ground = boundary.layer(mode);
            if (mode == 0) record_ground(sum, ground, boundary.entering());
            sum = add(sum, ground, directions_.nodes);
        }
        if (mode == 0) record_fluxes(sum);
        const Once once = scattered_once(mode, boundary);
        solution_.reflection_modes.push_back(unscaled(sum.reflection) - once.reflection);
        if (!sum.is_opaque())
            solution_.transmission_modes.push_back(unscaled(sum.transmission) - once.transmission);
    }

    MatrixXd unscaled(const MatrixXd& matrix) const {
        const auto count = solution_.mu.size();
        const VectorXd unscale = directions_.s.tail(count).cwiseInverse();
        return unscale.asDiagonal() * matrix.bottomRightCorner(count, count) * unscale.asDiagonal();
    }

    /// Closed form of one mode, layer by layer.
    Once scattered_once(int mode, BoundaryModes& boundary) {
        const VectorXd& mu = solution_.mu;
        const auto count = mu.size();
        Once sum{MatrixXd::Zero(count, count), MatrixXd::Zero(count, count)};
        for (std::size_t k = 0; k < layers_.size(); ++k) {
            if (mode >= layers_[k].count()) continue;
            const double w = solution_.truncations[k].albedo(solution_.layers[k].albedo);
            const PhaseKernels& kernels = layers_[k].kernels(mode);
            const MatrixXd other = kernels.other.bottomRightCorner(count, count);
            const MatrixXd same = kernels.same.bottomRightCorner(count, count);
            for (Eigen::Index in = 0; in < count; ++in)
                for (Eigen::Index out = 0; out < count; ++out) {
                    sum.reflection(out, in) += single_reflection_at(places_[k], other(out, in), w,
                                                                    depths_[k], mu(in), mu(out));
                    sum.transmission(out, in) += single_transmission_at(
                        places_[k], same(out, in), w, depths_[k], mu(in), mu(out));
                }
        }
        if (solution_.lower_boundary.is_present()) {
            const VectorXd beam = mu.unaryExpr([this](double cosine) {
                return direct_transmittance(places_.back().above + depths_.back(), cosine);
            });
            sum.reflection += beam.asDiagonal() *
                              boundary.once(mode).bottomRightCorner(count, count) *
                              beam.asDiagonal();
        }
        if (mode == 0) mean_ = sum;
        return sum;
    }

    void record_ground(const LayerMode& above, const LayerMode& ground, const VectorXd& entering) {
        const auto count = solution_.mu.size();
        const VectorXd flux = net_flux_between(above, ground, entering, directions_.nodes);
        const VectorXd s = directions_.s.head(directions_.nodes);
        solution_.ground_absorptance = flux.tail(count).cwiseQuotient(directions_.s.tail(count));
        solution_.spherical_ground_absorptance =
            s.dot(flux.head(directions_.nodes)) / s.squaredNorm();
    }

    void record_fluxes(const LayerMode& stack) {
        const int N = directions_.nodes;
        const auto count = solution_.mu.size();
        const VectorXd s = directions_.s.head(N);
        const VectorXd unscale = directions_.s.tail(count).cwiseInverse();
        // The weights of uniform illumination sum to 1 from three nodes on, not with fewer.
        const double uniform = s.squaredNorm();
        auto mean = [&](const MatrixXd& matrix) {
            return s.dot(matrix.topLeftCorner(N, N) * s) / uniform;
        };
        solution_.spherical_albedo = mean(stack.reflection);
        solution_.plane_albedo =
            unscale.asDiagonal() * (stack.reflection.bottomLeftCorner(count, N) * s);
        solution_.diffuse_transmittance = VectorXd::Zero(count);
        if (stack.is_opaque()) return;
        solution_.spherical_albedo_below = mean(stack.reflection_below);
        solution_.total_transmittance =
            mean(stack.transmission) + s.cwiseProduct(s).dot(stack.beam.head(N)) / uniform;
        solution_.diffuse_transmittance =
            unscale.asDiagonal() * (stack.transmission.topRightCorner(N, count).transpose() * s);
        // What truncation took for beam and is not: exp(-tau*/mu) - exp(-tau/mu).
        double scattered = 0;
        for (std::size_t k = 0; k < depths_.size(); ++k)
            scattered += solution_.truncations[k].fraction * solution_.layers[k].albedo *
                         solution_.layers[k].optical_depth;
        for (Eigen::Index i = 0; i < count; ++i)
            solution_.diffuse_transmittance(i) +=
                stack.beam.tail(count)(i) * -std::expm1(-scattered / solution_.mu(i));
    }

    /// True when the pack of modes that ends with `last` adds nothing anywhere.
    bool is_negligible(int last) const {
        const StackSolution& of = solution_;
        auto adds = [&](const MatrixXd& f, const MatrixXd& mean, const MatrixXd& once) {
            return (2 * f.array().abs() >
                    options_.mode_tolerance * (mean.array().abs() + once.array().abs()))
                .any();
        };
        for (auto m = static_cast<std::size_t>(last + 1 - lane_count);
             m <= static_cast<std::size_t>(last); ++m)
            if (adds(of.reflection_modes[m], of.reflection_modes[0], mean_.reflection) ||
                (!of.transmission_modes.empty() &&
                 adds(of.transmission_modes[m], of.transmission_modes[0], mean_.transmission)))
                return false;
        return true;
    }

    const SolverOptions& options_;
    const Directions directions_;
    std::vector<double> depths_;  // after truncation
    std::vector<Place> places_;
    std::vector<LayerModes> layers_;
    StackSolution solution_;
    Once mean_;  // of mode 0
};

}  // namespace

StackSolution solve_stack(const std::vector<StackLayer>& layers, const LowerBoundary& boundary,
                          const std::vector<double>& mu, const SolverOptions& options) {
    check_options(options);
    require(options.scheme == Scheme::harmonic, "solve_stack", "scheme", "harmonic", "another");
    require(!layers.empty(), "solve_stack", "layers", "at least one", "none");
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const std::string of = " of layer " + std::to_string(k + 1);
        require(layers[k].albedo >= 0 && layers[k].albedo <= 1, "solve_stack", "albedo" + of,
                "in [0, 1]", layers[k].albedo);
        const double depth = layers[k].optical_depth;
        require(depth >= 0, "solve_stack", "optical_depth" + of, "in [0, inf]", depth);
        const bool may_be_infinite = k + 1 == layers.size() && !boundary.is_present();
        require(!std::isinf(depth) || may_be_infinite, "solve_stack", "optical_depth" + of,
                "finite, as something lies beneath", depth);
    }
    check_boundary(boundary);
    return StackSolver(layers, boundary, mu, options).run();
}

bool StackSolution::is_opaque() const {
    return lower_boundary.is_present() || std::isinf(layers.back().optical_depth);
}

SolvedValue StackSolution::reflection(int in, int out, double azimuth) const {
    const Geometry geometry{mu(in), mu(out), azimuth};
    const double cosine = cos_scattering_angle_reflected(geometry);
    double single = 0, corrected = 0;  // with the depths as they are, and after truncation
    Place place, place_corrected;
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const double phase = layers[k].phase_function(cosine), w = layers[k].albedo;
        const double depth = layers[k].optical_depth;
        const double depth_corrected = truncations[k].optical_depth(depth, w);
        single += single_reflection_at(place, phase, w, depth, mu(in), mu(out));
        corrected +=
            single_reflection_at(place_corrected, phase, truncations[k].single_scattering_albedo(w),
                                 depth_corrected, mu(in), mu(out));
        place.above += depth;
        place_corrected.above += depth_corrected;
    }
    if (lower_boundary.is_present()) {
        single += single_reflection_of_boundary(lower_boundary, place.above, geometry);
        corrected += single_reflection_of_boundary(truncated(lower_boundary, boundary_truncation),
                                                   place_corrected.above, geometry);
    }
    return put_together(single, corrected, sum_modes(reflection_modes, out, in, azimuth));
}

SolvedValue StackSolution::transmission(int in, int out, double azimuth) const {
    if (is_opaque()) return {0, 0, 0};
    const double cosine = cos_scattering_angle_transmitted({mu(in), mu(out), azimuth});
    std::vector<double> depths, depths_corrected;
    for (std::size_t k = 0; k < layers.size(); ++k) {
        depths.push_back(layers[k].optical_depth);
        depths_corrected.push_back(
            truncations[k].optical_depth(layers[k].optical_depth, layers[k].albedo));
    }
    const std::vector<Place> places = places_of(depths);
    const std::vector<Place> places_corrected = places_of(depths_corrected);
    double single = 0, corrected = 0;
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const double phase = layers[k].phase_function(cosine), w = layers[k].albedo;
        single += single_transmission_at(places[k], phase, w, depths[k], mu(in), mu(out));
        corrected += single_transmission_at(places_corrected[k], phase,
                                            truncations[k].single_scattering_albedo(w),
                                            depths_corrected[k], mu(in), mu(out));
    }
    return put_together(single, corrected, sum_modes(transmission_modes, out, in, azimuth));
}

}  // namespace stratus
