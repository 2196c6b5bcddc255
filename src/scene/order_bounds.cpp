#include <stratus/scene/order_bounds.h>

#include <stratus/bake/accuracy.h>
#include <stratus/base/angle.h>
#include <stratus/base/number_text.h>
#include <stratus/layer/diffuse_transmittance.h>
#include <stratus/transfer/solve.h>

#include "geometry_grid.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace stratus {
namespace {

constexpr double thinnest_solved = 1e-4;  // below, ratios are smaller still
constexpr int max_octaves = 24;
constexpr int max_rounds = 3;
constexpr double agreement = 1.1;  // of bound and largest value

SolverOptions quick_solver(const PhaseFunction& phase_function) {
    SolverOptions options;
    options.nodes = std::abs(phase_function.asymmetry()) < 0.6 ? 12 : 24;
    options.mode_tolerance = 1e-4;
    options.exact_fluxes = false;
    return options;
}

// ---- matter -------------------------------------------------------------------------------------

/// Depths that bound all matter of a scene from above, and the largest albedo that occurs between
/// each and the one before.
struct Levels {
    DepthLadder ladder;
    struct Level {
        std::size_t octave;
        double depth, albedo;
        double radius;  // of the span with that albedo
    };
    std::vector<Level> level;
};

Levels levels_of(const std::vector<MatterSpan>& spans) {
    Levels levels;
    double deepest = 0, thinnest = infinity;
    const MatterSpan* brightest = nullptr;
    for (const MatterSpan& span : spans) {
        deepest = std::max(deepest, span.optical_depth.max);
        thinnest = std::min(thinnest, span.optical_depth.min);
        if (!brightest || span.albedo.max > brightest->albedo.max) brightest = &span;
    }
    if (!brightest) return levels;
    if (std::isinf(deepest)) {
        levels.ladder = {1, 1, true};
        levels.level.push_back({1, infinity, brightest->albedo.max, brightest->radius});
        return levels;
    }
    thinnest = std::min(deepest, std::max(thinnest, thinnest_solved));
    const int octaves = std::min(
        max_octaves, 1 + static_cast<int>(std::ceil(std::log2(deepest / thinnest) - 1e-9)));
    levels.ladder = {std::ldexp(deepest, 1 - octaves), octaves, false};
    for (int k = 0; k < octaves; ++k) {
        const double depth = std::ldexp(levels.ladder.first, k);
        Levels::Level level{static_cast<std::size_t>(k), depth, 0, 0};
        for (const MatterSpan& span : spans)
            if (span.optical_depth.min <= depth && (k == 0 || span.optical_depth.max > depth / 2) &&
                span.albedo.max > level.albedo) {
                level.albedo = span.albedo.max;
                level.radius = span.radius;
            }
        if (level.albedo > 0) levels.level.push_back(level);
    }
    return levels;
}

/// The phase functions of a scene's matter: of mixtures both ends and the middle.
std::vector<PhaseFunction> phase_functions_of(const Scene& scene,
                                              const std::vector<MatterSpan>& spans) {
    const auto& parts = scene.layer.components;
    if (parts.size() < 2) return {parts[0]};
    Range mixture{1, 0};
    for (const MatterSpan& span : spans) {
        widen(mixture, span.mixture.min);
        widen(mixture, span.mixture.max);
    }
    if (spans.empty()) return {parts[0]};
    std::vector<PhaseFunction> all;
    for (const double share : {mixture.min, (mixture.min + mixture.max) / 2, mixture.max}) {
        all.push_back(PhaseFunction::mixture(std::clamp(share, 0.0, 1.0), parts[0], parts[1]));
        if (mixture.min == mixture.max) break;
    }
    return all;
}

// ---- shares -------------------------------------------------------------------------------------

void raise(ChangeBound& change, double found, double bound, const auto& at) {
    if (found > change.found) {
        change.found = found;
        change.place = at();
        change.where = change.place->text();
    }
    change.bound = std::max({change.bound, bound, change.found});
}

void raise_flux(ChangeBound& change, double value, const std::string& where) {
    if (value > change.found) {
        change.found = value;
        change.place.reset();
        change.where = where;
    }
    change.bound = std::max(change.bound, std::min(1.0, agreement * value));
}

double share(double ratio, double phase) { return ratio > 0 ? ratio / (phase + ratio) : 0; }

/// R_m / S of one solution over a grid, and its mean over azimuth at each pair of cosines.
struct Ratios {
    std::vector<double> ratio, mean;
};

Ratios ratios_of(const LayerSolution& solution, const GeometryGrid& grid,
                 const std::vector<int>& in, const std::vector<int>& out) {
    Ratios ratios;
    const bool lit = grid.side == Side::reflection;
    for (std::size_t i = 0; i < grid.mu_in.size(); ++i)
        for (std::size_t j = 0; j < grid.mu_out.size(); ++j) {
            const double mu_in = grid.mu_in[i], mu_out = grid.mu_out[j];
            const double once =
                lit ? single_reflection(1, solution.albedo, solution.optical_depth, mu_in, mu_out)
                    : single_transmission(1, solution.albedo, solution.optical_depth, mu_in,
                                          mu_out);
            const auto values = lit ? solution.reflection(in[i], out[j], grid.azimuth)
                                    : solution.transmission(in[i], out[j], grid.azimuth);
            const auto& modes = lit ? solution.reflection_modes : solution.transmission_modes;
            const double mean = modes.empty() ? 0 : modes[0](in[i], out[j]);
            // Nothing is scattered once where light is scattered at all: any ratio.
            const auto over = [&](double value) {
                return once > 0 ? std::max(0.0, value) / once : value > 0 ? infinity : 0.0;
            };
            for (const SolvedValue& value : values) {
                ratios.ratio.push_back(over(value.multiple));
                ratios.mean.push_back(over(mean));
            }
        }
    return ratios;
}

/// Solutions at all cosines of a grid.
struct SolvedLevels {
    std::vector<double> mu;
    std::vector<LayerSolution> solution;  // of each octave

    std::vector<int> places(const std::vector<double>& cosines) const {
        std::vector<int> found;
        for (const double cosine : cosines)
            found.push_back(static_cast<int>(std::ranges::find(mu, cosine) - mu.begin()));
        return found;
    }
};

/// Of a scene's levels, all with the largest albedo of any.
SolvedLevels solve_levels(const PhaseFunction& phase_function, Levels& levels,
                          const std::vector<double>& first, const std::vector<double>& second) {
    double albedo = 0;
    for (const Levels::Level& level : levels.level) albedo = std::max(albedo, level.albedo);
    for (Levels::Level& level : levels.level) level.albedo = albedo;
    SolvedLevels solved;
    solved.mu = first;
    for (const double cosine : second)
        if (std::ranges::find(solved.mu, cosine) == solved.mu.end()) solved.mu.push_back(cosine);
    solved.solution = std::move(solve_ladder(phase_function, {albedo}, levels.ladder, solved.mu,
                                             quick_solver(phase_function))[0]);
    return solved;
}

/// A side of the layer that is seen.
struct SeenSide {
    Side side;
    Range scattering_angles;
};

std::vector<SeenSide> seen_sides(const Scene& scene, const SeenLight& light) {
    std::vector<SeenSide> sides;
    for (const Side side : {Side::reflection, Side::transmission})
        if (side == Side::reflection ? light.reflection : light.transmission)
            sides.push_back({side, seen_scattering_angles(scene, side)});
    return sides;
}

/// One phase function of a scene.
class Bounds {
  public:
    Bounds(const Scene& scene, const PhaseFunction& phase_function, Levels levels,
           const SeenLight& light, const SeenDirections& directions,
           const std::vector<SeenSide>& sides)
        : scene_(scene),
          phase_function_(phase_function),
          levels_(std::move(levels)),
          light_(light),
          directions_(directions),
          sides_(sides),
          least_phase_(phase_function) {}

    /// The change at one geometry of the matter that scatters most.
    OrderBounds sample() {
        Levels one = levels_;
        const auto most = std::ranges::max_element(one.level, {}, [](const Levels::Level& level) {
            return level.albedo * std::min(1.0, level.depth);
        });
        one.level = {*most};
        if (std::isfinite(one.level[0].depth)) {
            one.ladder = {one.level[0].depth, 1, false};
            one.level[0].octave = 0;
        }
        SeenDirections middle = directions_;
        const auto between = [](const Range& range) {
            const double value = (range.min + range.max) / 2;
            return Range{value, value};
        };
        middle.mu_in = between(directions_.mu_in);
        middle.mu_out = between(directions_.mu_out);
        OrderBounds bounds;
        measure(one, middle, 1, bounds);
        bounds.multiple.bound = bounds.azimuth.bound = 1;
        return bounds;
    }

    /// The bound over all matter and directions.
    OrderBounds bound(double enough) {
        OrderBounds bounds;
        for (int round = 0; round < max_rounds; ++round) {
            OrderBounds now;
            measure(levels_, directions_, 1 << round, now);
            bounds = now;
            const auto settled = [&](const ChangeBound& change) {
                return change.bound <= agreement * change.found || change.found > enough ||
                       change.bound <= enough;
            };
            if (settled(bounds.multiple) && settled(bounds.azimuth)) break;
        }
        return bounds;
    }

  private:
    void measure(Levels levels, const SeenDirections& directions, int refinement,
                 OrderBounds& bounds) {
        std::vector<GeometryGrid> grids;
        for (const SeenSide& seen : sides_)
            grids.push_back(grid_of(seen.side, directions, seen.scattering_angles, phase_function_,
                                    least_phase_, refinement));
        const SolvedLevels solved =
            solve_levels(phase_function_, levels, cosines_over(directions.mu_in, refinement),
                         cosines_over(directions.mu_out, refinement));
        for (const GeometryGrid& grid : grids)
            for (const Levels::Level& level : levels.level) add(grid, level, solved, bounds);
        if (light_.fluxes) add_fluxes(levels, solved, bounds);
        // Without orders n >= 2 nothing is reflected back to the ground.
        if (light_.underside)
            raise_flux(bounds.multiple, 1, "light of the ground that the layer reflects down");
    }

    void add(const GeometryGrid& grid, const Levels::Level& level, const SolvedLevels& solved,
             OrderBounds& bounds) const {
        if (grid.side == Side::transmission && std::isinf(level.depth)) return;
        const LayerSolution& solution = solved.solution[level.octave];
        const Ratios ratios =
            ratios_of(solution, grid, solved.places(grid.mu_in), solved.places(grid.mu_out));
        std::vector<double> deviation;
        for (std::size_t n = 0; n < ratios.ratio.size(); ++n)
            deviation.push_back(std::isinf(ratios.ratio[n])
                                    ? infinity
                                    : std::abs(ratios.ratio[n] - ratios.mean[n]));
        const std::vector<double> rise = rises(grid, ratios.ratio),
                                  deviation_rise = rises(grid, deviation);
        for (std::size_t i = 0; i < grid.mu_in.size(); ++i)
            for (std::size_t j = 0; j < grid.mu_out.size(); ++j)
                for (std::size_t k = 0; k < grid.azimuth.size(); ++k) {
                    const std::size_t n = grid.at(i, j, k);
                    if (!grid.seen[n]) continue;
                    const auto here = [&] {
                        return ScatteringPlace{
                            phase_function_, level.albedo,
                            level.depth,     level.radius,
                            grid.side,       {grid.mu_in[i], grid.mu_out[j], grid.azimuth[k]}};
                    };
                    if (!std::isfinite(ratios.ratio[n] + rise[n])) {
                        raise(bounds.multiple, 1, 1, here);
                        raise(bounds.azimuth, 0, 1, here);
                        continue;
                    }
                    const double ratio = ratios.ratio[n], most = ratio + rise[n];
                    raise(bounds.multiple, share(ratio, grid.phase[n]),
                          share(most, grid.least_phase[n]), here);
                    const double total = grid.phase[n] + ratio,
                                 least = grid.least_phase[n] + std::max(0.0, ratio - rise[n]);
                    const double change = deviation[n], raised = change + deviation_rise[n];
                    raise(bounds.azimuth, total > 0 ? change / total : 0,
                          raised > 0 ? (least > 0 ? std::min(1.0, raised / least) : 1) : 0, here);
                }
    }

    /// What the orders n >= 2 add to light through the layer.
    void add_fluxes(const Levels& levels, const SolvedLevels& solved, OrderBounds& bounds) const {
        const double ground = brightest_ground(scene_);
        const std::optional<SingleDiffuseTransmittance> once =
            ground > 0 ? std::nullopt : std::optional<SingleDiffuseTransmittance>(phase_function_);
        double least_direct = 1, spherical_albedo = 0;
        const Levels::Level* deepest = nullptr;
        for (const Levels::Level& level : levels.level) {
            if (std::isinf(level.depth)) continue;
            const LayerSolution& solution = solved.solution[level.octave];
            for (std::size_t m = 0; m < solved.mu.size(); ++m) {
                const double mu = solved.mu[m], direct = direct_transmittance(level.depth, mu),
                             diffuse = solution.diffuse_transmittance(static_cast<Eigen::Index>(m));
                const double all = direct + diffuse;
                if (all <= 0) continue;
                if (ground > 0) {
                    if (direct / all < least_direct) {
                        least_direct = direct / all;
                        deepest = &level;
                    }
                    continue;
                }
                const double more =
                    std::max(0.0, diffuse - level.albedo * (*once)(level.depth, mu)) / all;
                raise_flux(bounds.multiple, more,
                           "the background through optical depth " + short_number(level.depth, 3) +
                               ", albedo " + short_number(level.albedo, 3));
            }
            spherical_albedo = std::max(spherical_albedo, solution.spherical_albedo);
        }
        if (ground == 0) return;
        const double change =
            1 - least_direct * least_direct * (1 - std::min(1.0, ground * spherical_albedo));
        raise_flux(
            bounds.multiple, change,
            "the ground through optical depth " + short_number(deepest ? deepest->depth : 0, 3));
    }

    const Scene& scene_;
    const PhaseFunction phase_function_;
    const Levels levels_;
    const SeenLight light_;
    const SeenDirections directions_;
    const std::vector<SeenSide> sides_;
    const LeastPhase least_phase_;
};

/// Whether so few nodes as the bake may choose resolve a phase function's moments, so that mode 0 is
/// the mean over azimuth.
bool is_smooth(const PhaseFunction& phase_function) {
    constexpr int least_nodes = 8;
    return std::abs(phase_function.moments(2 * least_nodes + 1).back()) < 1e-4;
}

}  // namespace

void join(ChangeBound& all, const ChangeBound& one) {
    const double bound = std::max(all.bound, one.bound);
    if (one.found >= all.found) all = one;
    all.bound = bound;
}

std::string ScatteringPlace::text() const {
    std::string text =
        "optical depth " + short_number(optical_depth, 3) + ", albedo " + short_number(albedo, 3);
    if (radius > 0) text += ", radius " + short_number(radius, 5);
    return text + ", mu_in " + short_number(geometry.mu_in, 3) + ", mu_out " +
           short_number(geometry.mu_out, 3) + ", azimuth " +
           short_number(degrees(geometry.azimuth), 3) + " deg";
}

OrderBounds bound_orders(const Scene& scene, double enough) {
    const std::vector<MatterSpan> spans = matter_spans(scene);
    const Levels levels = levels_of(spans);
    const SeenLight light = seen_light(scene);
    OrderBounds all;
    if (levels.level.empty() || !light.any()) return all;
    if (!scene.layer.stack.empty()) {
        const ChangeBound unknown{1, 1, "a stack, for which nothing is bounded", std::nullopt};
        return {unknown, unknown};
    }
    const SeenDirections directions = seen_directions(scene);
    const std::vector<SeenSide> sides = seen_sides(scene, light);
    std::vector<double> found;  // of each mixture
    for (const PhaseFunction& phase_function : phase_functions_of(scene, spans)) {
        if (is_peaked(phase_function)) {
            const ChangeBound unknown{1, 1, "a narrow forward peak, for which nothing is bounded",
                                      std::nullopt};
            return {unknown, unknown};
        }
        Bounds bounds(scene, phase_function, levels, light, directions, sides);
        OrderBounds one = bounds.sample();
        const bool isotropic = phase_function.is_isotropic(), smooth = is_smooth(phase_function);
        const bool needed =
            one.multiple.found > enough && (one.azimuth.found > enough || isotropic || !smooth);
        if (!needed) one = bounds.bound(enough);
        if (isotropic) one.azimuth = {};
        if (!isotropic && !smooth) one.azimuth.bound = 1;
        join(all.multiple, one.multiple);
        join(all.azimuth, one.azimuth);
        found.push_back(one.multiple.bound);
        if (needed && all.azimuth.bound > enough) return all;
    }
    if (found.size() == 3) {  // between mixtures
        const double bend = std::abs(found[0] - 2 * found[1] + found[2]) / 4;
        all.multiple.bound = std::min(1.0, all.multiple.bound + bend);
        all.azimuth.bound = std::min(1.0, all.azimuth.bound + bend);
    }
    // What rings scatter is scattered by rings once more.
    if (light.shine)
        for (ChangeBound* const change : {&all.multiple, &all.azimuth})
            change->bound = 1 - (1 - change->bound) * (1 - change->bound);
    return all;
}

std::vector<double> order_shares(const ScatteringPlace& place, int orders) {
    const bool same = place.geometry.mu_in == place.geometry.mu_out;
    std::vector<double> mu{place.geometry.mu_in};
    if (!same) mu.push_back(place.geometry.mu_out);
    SolverOptions options = quick_solver(place.phase_function);
    const auto value = [&](const LayerSolution& solution) {
        const int out = same ? 0 : 1;
        return place.side == Side::reflection
                   ? solution.reflection(0, out, place.geometry.azimuth).total
                   : solution.transmission(0, out, place.geometry.azimuth).total;
    };
    const double all =
        value(solve_layer(place.phase_function, place.albedo, place.optical_depth, mu, options));
    options.orders = orders;
    std::vector<double> shares;
    for (const LayerSolution& order :
         solve_orders(place.phase_function, place.albedo, place.optical_depth, mu, options))
        shares.push_back(all > 0 ? value(order) / all : 0);
    return shares;
}

std::optional<int> orders_for(const std::vector<double>& shares, double tolerance) {
    double left = 1;
    for (std::size_t n = 0; n < shares.size(); ++n) {
        left -= shares[n];
        if (left <= tolerance) return static_cast<int>(n) + 1;
    }
    return std::nullopt;
}

}  // namespace stratus
