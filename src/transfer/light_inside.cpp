#include "light_inside.h"

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/transfer/stack.h>

#include "stack_solver.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace stratus {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Layers divided at levels, and how many pieces are above each.
struct Divided {
    StackLayers pieces;
    std::vector<std::size_t> above;
};

Divided divide(const StackLayers& layers, const std::vector<double>& levels) {
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
        divided.above.push_back(
            size(level == 0 ? 0 : std::ranges::upper_bound(bottoms, level) - bottoms.begin()));
    return divided;
}

}  // namespace

SingleLayers::SingleLayers(const StackLayers& layers, const std::vector<Truncation>& truncations,
                           double (Truncation::*albedo)(double) const) {
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const double w = layers[k].albedo;
        albedos.push_back((truncations[k].*albedo)(w));
        depths.push_back(truncations[k].optical_depth(layers[k].optical_depth, w));
    }
}

double SingleLayers::depth(std::size_t first, std::size_t end) const {
    return std::accumulate(depths.data() + first, depths.data() + end, 0.0);
}

double SingleLayers::scattered(std::size_t k, std::size_t above, double phase, double mu_in,
                               double mu_out) const {
    if (k < above)
        return single_scattering_through(Side::transmission, {depth(0, k), depth(k + 1, above)},
                                         phase, albedos[k], depths[k], mu_in, mu_out);
    return direct_transmittance(depth(0, above), mu_in) *
           single_scattering_through(Side::reflection, {depth(above, k), 0}, phase, albedos[k],
                                     depths[k], mu_in, mu_out);
}

MatrixXd SingleLayers::factors(std::size_t k, std::size_t above, const VectorXd& mu) const {
    return MatrixXd::NullaryExpr(mu.size(), mu.size(), [&](Eigen::Index out, Eigen::Index in) {
        return scattered(k, above, 1, mu(in), mu(out));
    });
}

namespace {

class InsideRun : StackSolver {
  public:
    InsideRun(const Divided& divided, const LowerBoundary& boundary,
              const std::vector<double>& levels, const std::vector<double>& mu,
              const SolverOptions& options)
        : StackSolver(divided.pieces, boundary, mu, options, false),
          solution_(blank<InsideSolution>()),
          single_(layers_, truncation_.layers, &Truncation::albedo) {
        for (std::size_t l = 0; l < levels.size(); ++l) {
            LightAtLevel& level = solution_.levels.emplace_back();
            level.mu = solved_cosines(directions_);
            level.optical_depth = levels[l];
            level.pieces_above = divided.above[l];
            level.direct_flux = beam_along(level.mu, levels[l]);
        }
        for (LightAtLevel& level : solution_.levels)
            recorders_.emplace_back(directions_, level, single_factors(level),
                                    layer_modes_.beam(level.pieces_above));
    }

    InsideSolution run() {
        solve_modes([&](int first, int end) {
            for (int mode = first; mode < end; ++mode) solve_mode(mode);
        });
        return std::move(solution_);
    }

  private:
    /// Each piece has factors of its own; the lower boundary counts as one more piece.
    std::vector<SingleFactors> single_factors(const LightAtLevel& level) const {
        const std::size_t pieces = layers_.size(), above = level.pieces_above;
        const auto count = level.mu.size();
        const MatrixXd none = MatrixXd::Zero(count, count);
        std::vector<SingleFactors> all;
        for (std::size_t k = 0; k < pieces; ++k) {
            all.push_back({none, none});
            (k < above ? all[k].transmission : all[k].reflection) =
                single_.factors(k, above, level.mu);
        }
        const auto beam = [&](std::size_t first) {
            return beam_along(level.mu, single_.depth(first, pieces));
        };
        all.push_back({beam(above) * beam(0).transpose(), none});
        return all;
    }

    void solve_mode(int mode) {
        const std::size_t pieces = layer_modes_.size();
        const int N = directions_.nodes, n = directions_.size();
        const MatrixXd none = MatrixXd::Zero(n, n);
        std::vector<LayerMode> below(pieces + 1);     // the first k pieces
        below[pieces] = boundary_modes_.layer(mode);  // reflects nothing where there is none
        for (std::size_t k = pieces; k-- > 0;) {
            const LayerMode piece = layer_modes_.layer(k, mode);
            below[k] = piece.is_opaque() ? piece : add(piece, below[k + 1], N);
        }
        std::vector<const PhaseKernels*> kernels = layer_modes_.kernels(mode);
        const PhaseKernels of_boundary{boundary_modes_.once(mode), none};
        kernels.push_back(&of_boundary);
        LayerMode above{none, none, none, VectorXd::Ones(n)};
        for (std::size_t k = 0; k <= pieces; ++k) {
            for (std::size_t l = 0; l < solution_.levels.size(); ++l)
                if (solution_.levels[l].pieces_above == k)
                    record(mode, l, light_between(above, below[k], N), kernels);
            if (k == pieces || std::isinf(layer_modes_.depths()[k])) break;
            above =
                k == 0 ? layer_modes_.layer(0, mode) : add(above, layer_modes_.layer(k, mode), N);
        }
    }

    void record(int mode, std::size_t l, const LightBetween& light,
                const std::vector<const PhaseKernels*>& kernels) {
        recorders_[l].record({light.upward, {}, light.downward}, kernels, nullptr);
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
        const std::size_t here = std::min(level.pieces_above, layers_.size() - 1);
        level.heating_rate = (1 - layers_[here].albedo) * level.actinic_flux;
    }

    InsideSolution solution_;
    const SingleLayers single_;
};

}  // namespace

InsideSolution solve_inside(const StackLayers& layers, const LowerBoundary& boundary,
                            const std::vector<double>& levels, const std::vector<double>& mu,
                            const SolverOptions& options) {
    const char* const caller = "solve";
    check_options(options);
    require(options.scheme == Scheme::harmonic, caller, "scheme", "harmonic", "another");
    require(options.orders == 0, caller, "orders", "0, all", options.orders);
    check_layers(layers, boundary.is_present(), caller);
    check_boundary(boundary);
    const double depth = total_depth(layers);
    require(!levels.empty(), caller, "levels", "one or more", "none");
    constexpr double rounding = 1e-14;  // of sums of depths, to all of which a level may be given
    std::vector<double> within;
    for (const double level : levels) {
        require(level >= 0 && level <= depth * (1 + rounding) && level < infinity, caller, "levels",
                depth < infinity ? "in [0, " + shortest_text(depth) + "], the optical depth"
                                 : "in [0, inf)",
                level);
        within.push_back(std::min(level, depth));
    }
    return InsideRun(divide(layers, within), boundary, within, mu, options).run();
}

namespace {

/// Diffuse light at the level below the first `above` layers of a stack or an InsideSolution, going up
/// (Side::reflection) or down. `scattered_again`: Legendre coefficients of what is added to the modes;
/// empty: those of the path law.
template <class Solved>
std::vector<SolvedValue> light_at_level(const Solved& solved, const ModeSolution& light,
                                        std::vector<double> scattered_again, Side side,
                                        std::size_t above, int in, int out,
                                        const std::vector<double>& azimuths) {
    const StackLayers& layers = solved.layers;
    const bool upward = side == Side::reflection;
    const std::size_t first = upward ? above : 0, end = upward ? layers.size() : above;
    const double mu_in = light.mu(in), mu_out = light.mu(out);
    if (scattered_again.empty() && solved.path)
        scattered_again = solved.path->legendre(side, above, mu_in, mu_out);
    const SingleLayers plain(layers, std::vector<Truncation>(layers.size()), &Truncation::albedo),
        corrected(layers, solved.truncations, &Truncation::single_scattering_albedo);
    const LowerBoundary boundary_corrected =
        truncated(solved.lower_boundary, solved.boundary_truncation);
    std::vector<double> cosines;
    for (const double azimuth : azimuths)
        cosines.push_back(cos_scattering_angle(side, {mu_in, mu_out, azimuth}));
    const std::vector<double> again = sum_legendre(scattered_again, cosines);
    std::vector<SolvedValue> all;
    for (std::size_t a = 0; a < azimuths.size(); ++a) {
        double single = 0, truncated = 0;
        for (std::size_t k = first; k < end; ++k) {
            const double phase = layers[k].phase_function(cosines[a]);
            single += plain.scattered(k, above, phase, mu_in, mu_out);
            if (!solved.path) truncated += corrected.scattered(k, above, phase, mu_in, mu_out);
        }
        // The path law is added to single scattering by the layers as they are.
        if (solved.path) truncated = single;
        if (upward && solved.lower_boundary.is_present()) {
            const auto by_boundary = [&](const SingleLayers& by, const LowerBoundary& boundary) {
                return direct_transmittance(by.depth(0, above), mu_in) *
                       single_reflection_of_boundary(boundary, by.depth(above, layers.size()),
                                                     {mu_in, mu_out, azimuths[a]});
            };
            single += by_boundary(plain, solved.lower_boundary);
            truncated += by_boundary(corrected, boundary_corrected);
        }
        const double orders = sum_modes(light.modes[side], out, in, azimuths[a]) + again[a];
        all.push_back({truncated + orders, single, orders + (truncated - single)});
    }
    return all;
}

}  // namespace

std::vector<SolvedValue> InsideSolution::values(Side side, int in, int out,
                                                const std::vector<double>& azimuths,
                                                std::size_t level) const {
    const LightAtLevel& light = levels[level];
    return light_at_level(*this, light, {}, side, light.pieces_above, in, out, azimuths);
}

/// Light at the level above all layers, or below.
std::vector<SolvedValue> StackSolution::values(Side side, int in, int out,
                                               const std::vector<double>& azimuths) const {
    if (alone) return alone->values(side, in, out, azimuths);
    const bool reflected = side == Side::reflection;
    if (!reflected && is_opaque()) return std::vector<SolvedValue>(azimuths.size());
    std::vector<double> scattered_back;
    if (backward_path)
        scattered_back = backward_path->legendre(side, layers[0].albedo, layers[0].optical_depth,
                                                 mu(in), mu(out));
    std::vector<SolvedValue> all = light_at_level(*this, *this, scattered_back, side,
                                                  reflected ? 0 : layers.size(), in, out, azimuths);
    if (order > 1)  // orders are not truncated: what is not scattered once is all there is
        for (SolvedValue& value : all) value = {value.multiple, 0, value.multiple};
    return all;
}

}  // namespace stratus
