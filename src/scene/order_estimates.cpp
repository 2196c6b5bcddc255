#include <stratus/scene/plan.h>

#include <stratus/base/number_text.h>
#include <stratus/scene/contents.h>
#include <stratus/transfer/stack.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace stratus {

void join(ChangeEstimate& all, const ChangeEstimate& one) {
    const double change = std::max(all.change, one.change);
    if (one.found >= all.found) all = one;
    all.change = change;
}

namespace {

/// Margin for larger changes between the geometries that are solved, by the record of
/// bench/plan_bench.cpp.
constexpr double margin = 1.5;

constexpr int grid_cosines = 13, grid_azimuths = 13;
constexpr int max_octaves = 8;  // in shallower matter the orders n >= 2 matter less

SolverOptions quick_solver(const std::vector<PhaseFunction>& phase_functions, bool fluxes = false) {
    SolverOptions options;
    const bool peaked = std::ranges::any_of(phase_functions, [](const PhaseFunction& each) {
        return std::abs(each.asymmetry()) >= 0.6;
    });
    options.nodes = peaked ? 24 : 12;
    options.mode_tolerance = 1e-4;
    options.exact_fluxes = fluxes;
    return options;
}

// ---- matter -------------------------------------------------------------------------------------

/// The depths of a scene's matter, and the largest albedo of any.
struct ScatteringMatter {
    DepthLadder ladder{1, 0, false};
    double albedo = 0;
};

ScatteringMatter scattering_matter(const MatterSpan& span) {
    const auto [thinnest, deepest] = span.optical_depth;
    const double albedo = span.albedo.max;
    if (std::isinf(deepest)) return {{1, 1, true}, albedo};
    const double octaves =
        thinnest > 0 ? 1 + std::ceil(std::log2(deepest / thinnest) - 1e-9) : max_octaves;
    const int count = static_cast<int>(std::min<double>(octaves, max_octaves));
    return {{std::ldexp(deepest, 1 - count), count, false}, albedo};
}

/// The phase functions that scatter together: of mixtures both ends and the middle, each alone; all
/// of a stack at once.
std::vector<std::vector<PhaseFunction>> mixed_phase_functions(const Scene& scene,
                                                              const Range& mixture) {
    if (!scene.layer.stacks.empty()) {
        std::vector<PhaseFunction> of_stack;
        for (const StackLayer& layer : scene.layer.stacks[0])
            of_stack.push_back(layer.phase_function);
        return {of_stack};
    }
    const auto& parts = scene.layer.components;
    if (parts.size() < 2) return {{parts[0]}};
    std::vector<std::vector<PhaseFunction>> all;
    for (const double share : {mixture.min, (mixture.min + mixture.max) / 2, mixture.max}) {
        all.push_back({PhaseFunction::mixture(std::clamp(share, 0.0, 1.0), parts[0], parts[1])});
        if (mixture.min == mixture.max) break;
    }
    return all;
}

// ---- directions ---------------------------------------------------------------------------------

/// Values over a range, even in their cube roots or as they are; the middle where one is asked for.
std::vector<double> values_over(const Range& range, int count, bool by_cube_root) {
    const auto forward = [&](double value) { return by_cube_root ? std::cbrt(value) : value; };
    const double first = forward(range.min), last = forward(range.max);
    if (last - first < 1e-9) return {range.max};
    std::vector<double> values;
    for (int k = 0; k < count; ++k) {
        const double x =
            first + (last - first) * (count == 1 ? 0.5 : static_cast<double>(k) / (count - 1));
        values.push_back(by_cube_root ? std::clamp(x * x * x, range.min, range.max) : x);
    }
    return values;
}

/// Cosines, more of them at grazing angles.
std::vector<double> cosines_over(const Range& range, int count) {
    const double least = std::max(range.min, 1e-3);
    return values_over({least, std::max(range.max, least)}, count, true);
}

/// Geometries that a scene sees on one side, as azimuths for each pair of cosines.
struct SeenPair {
    double mu_in, mu_out;
    std::vector<double> azimuths;
};

std::vector<SeenPair> seen_pairs(const Scene& scene, Side side, int cosines, int azimuths) {
    const SeenDirections seen = seen_directions(scene);
    const bool on_globe = scene.subject_as<Planet>() != nullptr;
    const std::vector<double> along =
        on_globe ? values_over(seen_scattering_angles(scene, side), std::min(azimuths, 3), false)
                 : values_over(seen.azimuth, azimuths, false);
    std::vector<SeenPair> pairs;
    for (const double mu_in : cosines_over(seen.mu_in, cosines))
        for (const double mu_out : cosines_over(seen.mu_out, cosines)) {
            SeenPair pair{mu_in, mu_out, {}};
            for (const double angle : along) {
                if (!on_globe) {
                    pair.azimuths.push_back(radians(angle));
                    continue;
                }
                // On a globe the angle between sun and eye fixes the azimuth of each pair.
                const double sines = std::sqrt((1 - mu_in * mu_in) * (1 - mu_out * mu_out)),
                             along_plane = std::cos(radians(angle)) + mu_in * mu_out;
                if (std::abs(along_plane) <= sines + 1e-9)
                    pair.azimuths.push_back(
                        sines > 0 ? std::acos(std::clamp(along_plane / sines, -1.0, 1.0)) : 0);
            }
            if (!pair.azimuths.empty()) pairs.push_back(std::move(pair));
        }
    return pairs;
}

/// Cosines to solve at, each once, and where they stand.
class SolvedCosines {
  public:
    int place(double mu) {
        const auto [known, fresh] = place_.try_emplace(mu, int_size(mu_));
        if (fresh) mu_.push_back(mu);
        return known->second;
    }
    const std::vector<double>& mu() const { return mu_; }

  private:
    std::vector<double> mu_;
    std::map<double, int> place_;
};

// ---- changes ------------------------------------------------------------------------------------

void raise(ChangeEstimate& change, double found, const auto& where) {
    if (!(found > change.found)) return;
    change.found = found;
    change.where = where();
}

/// The estimates of one phase function of a scene, or of a stack.
struct Estimates {
    const Scene& scene;
    const std::vector<PhaseFunction>& phase_functions;
    const ScatteringMatter& matter;
    const SeenLight light = seen_light(scene);

    /// Estimates on a grid of so many cosines and azimuths, in all octaves or the deepest alone.
    OrderEstimates find(int cosines, int azimuths, bool deepest_alone) const {
        std::vector<std::pair<Side, std::vector<SeenPair>>> sides;
        SolvedCosines solved;
        for (const Side side : both_sides) {
            if (side == Side::reflection ? !light.reflection : !light.transmission) continue;
            sides.emplace_back(side, seen_pairs(scene, side, cosines, azimuths));
            for (const SeenPair& pair : sides.back().second) {
                solved.place(pair.mu_in);
                solved.place(pair.mu_out);
            }
        }
        const SeenDirections seen = seen_directions(scene);
        if (light.fluxes)
            for (const Range& range : {seen.mu_in, seen.mu_out})
                for (const double mu : cosines_over(range, cosines)) solved.place(mu);
        OrderEstimates found;
        // Without orders n >= 2 nothing is reflected back to the ground.
        if (light.underside)
            raise(found.multiple, 1,
                  [] { return "light of the ground that the layer reflects down"; });
        if (solved.mu().empty()) return found;
        DepthLadder ladder = matter.ladder;
        if (deepest_alone && !ladder.to_infinity)
            ladder = {std::ldexp(ladder.first, ladder.octaves - 1), 1, false};
        for (const LayerSolution& layer : solve(ladder, solved.mu())) {
            for (const auto& [side, pairs] : sides)
                for (const SeenPair& pair : pairs)
                    add(layer, side, pair, solved.place(pair.mu_in), solved.place(pair.mu_out),
                        found);
            if (light.fluxes && !std::isinf(layer.optical_depth)) add_fluxes(layer, found);
        }
        return found;
    }

    std::vector<LayerSolution> solve(const DepthLadder& ladder,
                                     const std::vector<double>& mu) const {
        const SolverOptions options = quick_solver(phase_functions, light.fluxes);
        const auto& stacks = scene.layer.stacks;
        if (stacks.empty())
            return solve_ladder(phase_functions[0], {matter.albedo}, ladder, mu, options)[0];
        return {as_one_layer(solve_stack(stacks[0], {}, mu, options))};
    }

    static std::string layer_text(const LayerSolution& layer) {
        return "optical depth " + short_number(layer.optical_depth, 3) + ", albedo " +
               short_number(layer.albedo, 3);
    }

    void add(const LayerSolution& layer, Side side, const SeenPair& pair, int in, int out,
             OrderEstimates& found) const {
        if (side == Side::transmission && std::isinf(layer.optical_depth)) return;
        const auto& modes = layer.modes[side];
        const double mean = modes.empty() ? 0 : modes[0](in, out);
        const std::vector<SolvedValue> values = layer.values(side, in, out, pair.azimuths);
        for (std::size_t k = 0; k < values.size(); ++k) {
            const SolvedValue& value = values[k];
            const double light = scene.effects.single ? value.total : value.multiple;
            if (light <= 0) continue;
            const auto where = [&] {
                return layer_text(layer) + ", mu_in " + short_number(pair.mu_in, 3) + ", mu_out " +
                       short_number(pair.mu_out, 3) + ", azimuth " +
                       short_number(degrees(pair.azimuths[k]), 3) + " deg";
            };
            raise(found.multiple, std::min(1.0, value.multiple / light), where);
            raise(found.azimuth, std::abs(value.multiple - mean) / light, where);
        }
    }

    /// Adds what the orders n >= 2 add to light through the layer.
    void add_fluxes(const LayerSolution& layer, OrderEstimates& found) const {
        const double ground = brightest_ground(scene);
        const std::optional<SingleDiffuseTransmittance> once =
            ground > 0 || layer.stack
                ? std::nullopt
                : std::optional<SingleDiffuseTransmittance>(phase_functions[0]);
        const double underside =
            layer.stack ? layer.stack->spherical_albedo_below : layer.spherical_albedo;
        double least_direct = 1;
        for (Eigen::Index m = 0; m < layer.mu.size(); ++m) {
            const double direct = direct_transmittance(layer.optical_depth, layer.mu(m));
            // In stacks all that is diffuse counts.
            const double single =
                once ? layer.albedo * (*once)(layer.optical_depth, layer.mu(m)) : 0;
            const double multiple = layer.diffuse_transmittance(m) - single;
            const double all = direct + multiple + (scene.effects.single ? single : 0);
            if (all <= 0) continue;
            least_direct = std::min(least_direct, direct / all);
            if (ground == 0)
                raise(found.multiple, multiple / all,
                      [&] { return "the background through " + layer_text(layer); });
        }
        if (ground > 0)
            raise(found.multiple,
                  1 - least_direct * least_direct * (1 - std::min(1.0, ground * underside)),
                  [&] { return "the ground through " + layer_text(layer); });
    }
};

/// Whether so few nodes as the bake may choose resolve a phase function's moments, so that mode 0 is
/// the mean over azimuth.
bool is_smooth(const PhaseFunction& phase_function) {
    constexpr int least_nodes = 8;
    return std::abs(phase_function.moments(2 * least_nodes + 1).back()) < 1e-4;
}

/// The estimates of one of channel_scenes.
OrderEstimates estimate_channel(const Scene& scene, double enough) {
    const MatterSpan span = whole_matter_span(scene);
    const ScatteringMatter matter = scattering_matter(span);
    OrderEstimates all;
    if (matter.albedo == 0 || !seen_light(scene).any()) return all;
    if (seen_shell(scene) > 0) {
        const ChangeEstimate unknown{1, 1, "a shell, of which nothing is estimated"};
        return {unknown, unknown};
    }
    const bool shines = seen_light(scene).shine;
    const auto with_margin = [&](ChangeEstimate& change) {
        change.change = std::min(1.0, margin * change.found);
        // Light that rings scatter is scattered by rings once more.
        if (shines) change.change = 1 - (1 - change.change) * (1 - change.change);
    };
    for (const std::vector<PhaseFunction>& together : mixed_phase_functions(scene, span.mixture)) {
        const Estimates estimates{scene, together, matter};
        const bool isotropic = std::ranges::all_of(together, &PhaseFunction::is_isotropic),
                   smooth = std::ranges::all_of(together, is_smooth);
        OrderEstimates one = estimates.find(1, 1, true);
        const bool needed =
            one.multiple.found > enough && (one.azimuth.found > enough || isotropic || !smooth);
        if (!needed) one = estimates.find(grid_cosines, grid_azimuths, false);
        with_margin(one.multiple);
        with_margin(one.azimuth);
        if (isotropic) one.azimuth = {};
        if (!isotropic && !smooth) one.azimuth.change = 1;
        join(all.multiple, one.multiple);
        join(all.azimuth, one.azimuth);
        if (needed && all.azimuth.change > enough) break;
    }
    return all;
}

}  // namespace

OrderEstimates estimate_orders(const Scene& scene, double enough) {
    OrderEstimates all;
    for (const Scene& channel : channel_scenes(scene)) {
        const OrderEstimates one = estimate_channel(channel, enough);
        join(all.multiple, one.multiple);
        join(all.azimuth, one.azimuth);
        if (all.multiple.change > enough && all.azimuth.change > enough) break;
    }
    return all;
}

std::vector<double> order_shares(const PhaseFunction& phase_function, double albedo,
                                 double optical_depth, Side side,
                                 const std::vector<WeightedGeometry>& directions, int orders) {
    SolvedCosines solved;
    for (const auto& [at, weight] : directions) {
        solved.place(at.mu_in);
        solved.place(at.mu_out);
    }
    const auto light = [&](const LayerSolution& layer) {
        double sum = 0;
        for (const auto& [at, weight] : directions)
            sum +=
                weight *
                layer.values(side, solved.place(at.mu_in), solved.place(at.mu_out), {at.azimuth})[0]
                    .total;
        return sum;
    };
    SolverOptions options = quick_solver({phase_function});
    options.nodes = std::max(8, options.nodes / 2);
    options.modes = 6;  // of the orders n >= 2; single scattering has a closed form

    const double all =
        light(solve_layer(phase_function, albedo, optical_depth, solved.mu(), options));
    options.orders = orders;
    std::vector<double> shares;
    for (const LayerSolution& order :
         solve_orders(phase_function, albedo, optical_depth, solved.mu(), options))
        shares.push_back(all > 0 ? light(order) / all : 0);
    return shares;
}

int orders_for(const std::vector<double>& shares, double tolerance) {
    double left = 1;
    for (std::size_t n = 0; n < shares.size(); ++n) {
        left -= shares[n];
        if (left <= tolerance) return static_cast<int>(n) + 1;
    }
    const double ratio = left / (left + std::max(0.0, shares.back()));
    const double beyond = ratio < 1 ? std::log(tolerance / left) / std::log(ratio) : infinity;
    return int_size(shares) + static_cast<int>(std::ceil(std::min(beyond, 1e6)));
}

}  // namespace stratus
