#include "light_inside.h"

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include "adding.h"
#include "boundary_modes.h"
#include "flush_subnormals.h"
#include "layer.h"
#include "mode_recorder.h"
#include "options.h"
#include "stack_modes.h"
#include "stack_path.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace stratus {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Layers divided at levels, and how many pieces are above each.
struct Divided {
    std::vector<StackLayer> pieces;
    std::vector<std::size_t> above;
};

Divided divide(const std::vector<StackLayer>& layers, const std::vector<double>& levels) {
    std::vector<double> sorted = levels;
    std::ranges::sort(sorted);
    Divided divided;
    std::vector<double> bottoms;  // of the pieces
    double top = 0, begin = 0;    // of a layer, of a piece
    for (const StackLayer& layer : layers) {
        const double bottom = top + layer.optical_depth;
        const auto add_piece = [&](double end) {
            divided.pieces.push_back({layer.phase_function, layer.albedo, end - begin});
            bottoms.push_back(begin = end);
        };
        for (const double level : sorted)
            if (level > begin && level < bottom) add_piece(level);
        if (bottom > begin) add_piece(bottom);
        top = bottom;
    }
    if (divided.pieces.empty()) {
        divided.pieces = {layers.front()};
        bottoms = {0};
    }
    for (const double level : levels)
        divided.above.push_back(static_cast<std::size_t>(
            level == 0 ? 0 : std::ranges::upper_bound(bottoms, level) - bottoms.begin()));
    return divided;
}

/// Pieces as single scattering knows them: themselves, or truncated.
struct SinglePieces {
    std::vector<double> albedos, depths;

    double depth(std::size_t first, std::size_t end) const {
        return std::accumulate(depths.begin() + static_cast<std::ptrdiff_t>(first),
                               depths.begin() + static_cast<std::ptrdiff_t>(end), 0.0);
    }

    /// Light that piece k scatters once, for each unit of its phase function, to the level below the
    /// first `above` pieces: down if it is one of them, up otherwise.
    double scattered(std::size_t k, std::size_t above, double mu_in, double mu_out) const {
        if (k < above)
            return single_transmission_through({depth(0, k), depth(k + 1, above)}, 1, albedos[k],
                                               depths[k], mu_in, mu_out);
        return direct_transmittance(depth(0, above), mu_in) *
               single_reflection_through({depth(above, k), 0}, 1, albedos[k], depths[k], mu_in,
                                         mu_out);
    }
};

SinglePieces as_they_are(const std::vector<StackLayer>& pieces) {
    SinglePieces single;
    for (const StackLayer& piece : pieces) {
        single.albedos.push_back(piece.albedo);
        single.depths.push_back(piece.optical_depth);
    }
    return single;
}

SinglePieces truncated_pieces(const std::vector<StackLayer>& pieces,
                              const std::vector<Truncation>& truncations) {
    SinglePieces single;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        const double w = pieces[k].albedo;
        single.albedos.push_back(truncations[k].albedo(w));
        single.depths.push_back(truncations[k].optical_depth(pieces[k].optical_depth, w));
    }
    return single;
}

class InsideRun {
  public:
    InsideRun(const Divided& divided, const LowerBoundary& boundary,
              const std::vector<double>& levels, const std::vector<double>& mu,
              const SolverOptions& options)
        : options_(options),
          solution_(blank(divided.pieces, boundary, options)),
          directions_(
              stack_directions(solution_.truncations, solution_.boundary_truncation, mu, options)),
          boundary_modes_(solution_.lower_boundary, solution_.boundary_truncation, directions_),
          single_(truncated_pieces(solution_.pieces, solution_.truncations)),
          pieces_(solution_.pieces, solution_.truncations, directions_) {
        for (std::size_t l = 0; l < levels.size(); ++l)
            solution_.levels.push_back(blank_level(levels[l], divided.above[l]));
        for (LightAtLevel& level : solution_.levels)
            recorders_.emplace_back(directions_, level, single_factors(level),
                                    pieces_.beam(level.pieces_above));
    }

    InsideSolution run() {
        const FlushSubnormals flush(std::ranges::min(pieces_.depths()));
        solve_modes(
            options_, std::max({1, boundary_modes_.count(), pieces_.count()}),
            [&](int mode) { solve_mode(mode); },
            [&](int count) {
                return std::ranges::all_of(recorders_, [&](const ModeRecorder& recorder) {
                    return recorder.is_negligible(count, options_.mode_tolerance);
                });
            });
        return std::move(solution_);
    }

  private:
    static InsideSolution blank(const std::vector<StackLayer>& pieces,
                                const LowerBoundary& boundary, const SolverOptions& options) {
        InsideSolution solution;
        solution.pieces = pieces;
        const StackTruncation truncation(pieces, options, false);
        solution.truncations = truncation.layers;
        if (truncation.follows_paths)
            solution.path = std::make_shared<const StackPath>(pieces, truncation.layers);
        solution.lower_boundary = boundary;
        solution.boundary_truncation = truncation_of(boundary, options);
        return solution;
    }

    LightAtLevel blank_level(double optical_depth, std::size_t above) const {
        LightAtLevel level;
        level.mu = solved_cosines(directions_);
        level.optical_depth = optical_depth;
        level.pieces_above = above;
        level.direct_flux =
            level.mu.unaryExpr([&](double mu) { return direct_transmittance(optical_depth, mu); });
        return level;
    }

    /// Each piece has factors of its own; the lower boundary counts as one more piece.
    std::vector<SingleFactors> single_factors(const LightAtLevel& level) const {
        const std::size_t pieces = solution_.pieces.size(), above = level.pieces_above;
        const auto count = level.mu.size();
        const SingleFactors none{MatrixXd::Zero(count, count), MatrixXd::Zero(count, count)};
        std::vector<SingleFactors> all(pieces + 1, none);
        for (Eigen::Index in = 0; in < count; ++in)
            for (Eigen::Index out = 0; out < count; ++out) {
                const double mu_in = level.mu(in), mu_out = level.mu(out);
                for (std::size_t k = 0; k < pieces; ++k)
                    (k < above ? all[k].transmission : all[k].reflection)(out, in) =
                        single_.scattered(k, above, mu_in, mu_out);
                all[pieces].reflection(out, in) =
                    direct_transmittance(single_.depth(0, pieces), mu_in) *
                    direct_transmittance(single_.depth(above, pieces), mu_out);
            }
        return all;
    }

    LayerMode nothing() const {
        const auto n = directions_.size();
        const MatrixXd none = MatrixXd::Zero(n, n);
        return {none, none, none, VectorXd::Ones(n)};
    }

    void solve_mode(int mode) {
        const std::size_t pieces = pieces_.size();
        const int N = directions_.nodes;
        std::vector<LayerMode> below(pieces + 1);     // the first k pieces
        below[pieces] = boundary_modes_.layer(mode);  // reflects nothing where there is none
        for (std::size_t k = pieces; k-- > 0;) {
            const LayerMode piece = pieces_.layer(k, mode);
            below[k] = piece.is_opaque() ? piece : add(piece, below[k + 1], N);
        }
        std::vector<const PhaseKernels*> kernels;
        for (std::size_t k = 0; k < pieces; ++k) kernels.push_back(pieces_.kernels(k, mode));
        const PhaseKernels of_boundary{MatrixXd::Zero(directions_.size(), directions_.size()),
                                       boundary_modes_.once(mode)};
        kernels.push_back(&of_boundary);
        LayerMode above = nothing();
        for (std::size_t k = 0; k <= pieces; ++k) {
            for (std::size_t l = 0; l < solution_.levels.size(); ++l)
                if (solution_.levels[l].pieces_above == k)
                    record(mode, l, light_between(above, below[k], N), kernels);
            if (k == pieces || std::isinf(pieces_.depths()[k])) break;
            above = k == 0 ? pieces_.layer(0, mode) : add(above, pieces_.layer(k, mode), N);
        }
    }

    void record(int mode, std::size_t l, const LightBetween& light,
                const std::vector<const PhaseKernels*>& kernels) {
        recorders_[l].record({light.upward, {}, light.downward, {}}, kernels, nothing_below_);
        if (mode == 0) record_fluxes(light, recorders_[l].beam(), solution_.levels[l]);
    }

    /// Computes the actinic fluxes, and the upward ones anew: the recorder takes the matrix of upward
    /// light for symmetric, as R is.
    void record_fluxes(const LightBetween& light, const VectorXd& beam, LightAtLevel& level) const {
        const int N = directions_.nodes;
        const auto count = level.mu.size();
        const VectorXd s = directions_.s.head(N),
                       unscale = directions_.s.tail(count).cwiseInverse();
        const MatrixXd upward = light.upward.topRightCorner(N, count);
        const MatrixXd both = upward + light.downward.topRightCorner(N, count);
        level.plane_albedo = (upward.transpose() * s).cwiseProduct(unscale);
        level.actinic_flux =
            (both.transpose() * s.cwiseQuotient(directions_.mu.head(N))).cwiseProduct(unscale) +
            beam.tail(count).cwiseQuotient(level.mu);
        const std::size_t here = std::min(level.pieces_above, solution_.pieces.size() - 1);
        level.heating_rate = (1 - solution_.pieces[here].albedo) * level.actinic_flux;
    }

    const SolverOptions& options_;
    InsideSolution solution_;
    const Directions directions_;
    BoundaryModes boundary_modes_;
    const LowerBoundary nothing_{};  // the lower boundary counts as a piece
    const Truncation untruncated_{};
    BoundaryModes nothing_below_{nothing_, untruncated_, directions_};
    const SinglePieces single_;
    StackModes pieces_;
    std::vector<ModeRecorder> recorders_;
};

}  // namespace

InsideSolution solve_inside(const std::vector<StackLayer>& layers, const LowerBoundary& boundary,
                            const std::vector<double>& levels, const std::vector<double>& mu,
                            const SolverOptions& options) {
    const char* const caller = "solve_inside";
    check_options(options);
    require(options.scheme == Scheme::harmonic, caller, "scheme", "harmonic", "another");
    require(options.orders == 0, caller, "orders", "0, all", options.orders);
    check_layers(layers, boundary.is_present(), caller);
    check_boundary(boundary);
    double depth = 0;
    for (const StackLayer& layer : layers) depth += layer.optical_depth;
    require(!levels.empty(), caller, "levels", "one or more", "none");
    for (const double level : levels)
        require(level >= 0 && level <= depth && level < infinity, caller, "levels",
                depth < infinity ? "in [0, " + shortest_text(depth) + "], the optical depth"
                                 : "in [0, inf)",
                level);
    return InsideRun(divide(layers, levels), boundary, levels, mu, options).run();
}

std::vector<SolvedValue> InsideSolution::values(std::size_t level, Side side, int in, int out,
                                                const std::vector<double>& azimuths) const {
    const bool upward = side == Side::reflection;
    const LightAtLevel& light = levels[level];
    const std::size_t above = light.pieces_above;
    const double mu_in = light.mu(in), mu_out = light.mu(out);
    const SinglePieces plain = as_they_are(pieces);
    SinglePieces corrected = truncated_pieces(pieces, truncations);
    for (std::size_t k = 0; k < pieces.size(); ++k)
        corrected.albedos[k] = truncations[k].single_scattering_albedo(pieces[k].albedo);
    std::vector<double> modes;
    for (const MatrixXd& mode : upward ? light.reflection_modes : light.transmission_modes)
        modes.push_back(mode(out, in));
    const auto geometry = [&](double azimuth) { return Geometry{mu_in, mu_out, azimuth}; };
    const auto cosine_at = [&](double azimuth) {
        return upward ? cos_scattering_angle_reflected(geometry(azimuth))
                      : cos_scattering_angle_transmitted(geometry(azimuth));
    };
    const auto by_layers = [&](const SinglePieces& single, double azimuth) {
        double sum = 0;
        for (std::size_t k = upward ? above : 0; k < (upward ? pieces.size() : above); ++k)
            sum += pieces[k].phase_function(cosine_at(azimuth)) *
                   single.scattered(k, above, mu_in, mu_out);
        return sum;
    };
    const auto by_boundary = [&](const SinglePieces& single, const LowerBoundary& boundary,
                                 double azimuth) {
        if (!upward || !boundary.is_present()) return 0.0;
        return direct_transmittance(single.depth(0, above), mu_in) *
               single_reflection_of_boundary(boundary, single.depth(above, pieces.size()),
                                             geometry(azimuth));
    };
    const LowerBoundary ground = truncated(lower_boundary, boundary_truncation);
    std::vector<double> along_path;
    if (path) along_path = path->legendre(side, above, mu_in, mu_out);
    std::vector<SolvedValue> all;
    for (const double azimuth : azimuths)
        // The path law is added to single scattering by the layers as they are.
        all.push_back(put_together(
            by_layers(plain, azimuth) + by_boundary(plain, lower_boundary, azimuth),
            by_layers(path ? plain : corrected, azimuth) + by_boundary(corrected, ground, azimuth),
            sum_modes(modes, azimuth) + sum_legendre(along_path, cosine_at(azimuth))));
    return all;
}

}  // namespace stratus
