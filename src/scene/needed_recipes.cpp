#include <stratus/scene/layer_tables.h>

#include <stratus/bake/axes.h>
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include <cmath>
#include <utility>

namespace stratus {
namespace {

/// Limits of recipes.
constexpr double min_table_depth = 1e-6, max_table_depth = 1e9;

/// Where tables of several depths may begin: below, lookups follow the law of thin layers (lookup.h), which
/// looks up to an octave deeper.
double thinnest_tabulated(double deepest) { return std::min(0.02, deepest / 2); }

/// A single value where two differ by rounding alone.
Range merged(const Range& range) {
    return range.max - range.min < 1e-9 ? Range{range.max, range.max} : range;
}

constexpr double min_mixture_range = 1e-6;  // below, one mixture is enough

/// Whether a row is empty and matter thins out towards it from one beside it.
bool is_thin_end(const RingProfile& profile, std::size_t row) {
    const auto& depth = profile.optical_depth;
    return depth[row] == 0 &&
           ((row > 0 && depth[row - 1] > 0) || (row + 1 < depth.size() && depth[row + 1] > 0));
}

/// All of the layer's matter, with the effect of density.
MatterSpan matter_range(const Scene& scene) {
    MatterSpan range;
    auto add = [&](const Matter& matter) {
        if (matter.optical_depth == 0) return;
        for (const double extinction : scene.layer.extinction)
            if (extinction > 0)
                range.add(matter, extinction * seen_depth(scene, matter.optical_depth));
    };
    bool thins_out = false;
    if (const Rings* const rings = scene.subject_as<Rings>()) {
        const RingProfile& profile = rings->profile;
        for (std::size_t row = 0; row < profile.radius.size(); ++row) {
            const Matter matter = profile.at(profile.radius[row], scene.layer.albedo);
            add(matter);
            if (!is_thin_end(profile, row)) continue;
            thins_out = true;
            for (const double albedo : matter.albedo) widen(range.albedo, albedo);
            // Beside matter of albedo 0 the mixture is its neighbour's.
            if (profile.w1[row] + profile.w2[row] > 0) widen(range.mixture, matter.mixture);
        }
    } else {
        add({scene.layer.optical_depth.max, scene.layer.albedo, 1});
        thins_out = !scene.layer.optical_depth.is_plain();
    }
    if (thins_out && range.optical_depth.max > 0)
        widen(range.optical_depth, thinnest_tabulated(range.optical_depth.max));
    return range;
}

/// The scene without light that rings and their planet exchange.
Scene without_shine(Scene scene) {
    scene.effects.ringshine = scene.effects.planetshine = false;
    return scene;
}

/// Whether sunlight's table gives the fluxes, too: where a second table, with its own choices and check,
/// is dearer than what the first takes more. Slabs have few cosines of view, and where their diffuse
/// transmission is seen the first has T at any rate; tables of stacks hold the fluxes at once, at the
/// cosines that a planet's reflection takes.
bool has_fluxes_with_sunlight(const Scene& scene, const SeenLight& sunlight) {
    const bool is_dearer =
        (scene.subject_as<Slab>() && sunlight.transmission) || !scene.layer.stacks.empty();
    return is_dearer && sunlight.fluxes && (sunlight.reflection || sunlight.transmission);
}

/// The directions that one light path asks of a table.
struct Asked {
    SeenDirections directions;
    bool reflection = true, transmission = true;
};

Asked asked_by_sunlight(const Scene& scene) {
    const Scene alone = without_shine(scene);
    const SeenLight seen = seen_light(alone);
    Asked asked{seen_directions(alone), seen.reflection, seen.transmission};
    if (has_fluxes_with_sunlight(scene, seen)) asked.directions.mu_in = all_cosines;
    return asked;
}

/// Fluxes are over mu_in and asked for at cosines of view, too. The one cosine beside them is
/// straight on, where azimuths do not count.
Asked asked_by_fluxes(const Scene& scene) {
    return {{all_cosines, {1, 1}, all_azimuths}, true, scene.effects.transmission};
}

/// Light comes to the rings from any direction and leaves towards the camera, and from the sun's
/// towards any; the latter is looked up the other way round, R and T being the same.
Asked asked_by_shine(const Scene& scene) {
    Range out{1, 0};
    if (scene.effects.ringshine) widen(out, std::abs(scene.to_sun.z));
    if (scene.effects.planetshine) widen(out, seen_directions(without_shine(scene)).mu_out);
    return {{all_cosines, out, all_azimuths}, scene.effects.reflection, scene.effects.transmission};
}

Asked asked_by(LightPath path, const Scene& scene) {
    Asked asked = path == LightPath::sunlight ? asked_by_sunlight(scene)
                  : path == LightPath::fluxes ? asked_by_fluxes(scene)
                                              : asked_by_shine(scene);
    for (Range* const range : {&asked.directions.mu_in, &asked.directions.mu_out}) {
        range->max = std::max(range->max, min_mu);
        if (range->min <= min_mu) range->min = range->max == min_mu ? min_mu : all_cosines.min;
    }
    return asked;
}

/// The tolerance of a light path's table, with which pictures keep the scene's
/// (bench/picture_bench.cpp). Light that rings and their planet exchange is a small part of most
/// pixels, and a sum over many directions, whose errors cancel. Fluxes are judged by what they are
/// sums of, along one cosine, which varies less with the depth than at grazing ones.
double path_tolerance(LightPath path, const Scene& scene) {
    constexpr double coarser = 4, coarsest = 0.1, finer = 3;
    switch (path) {
        case LightPath::shine:
            return std::max(scene.tolerance, std::min(coarser * scene.tolerance, coarsest));
        case LightPath::fluxes: return scene.tolerance / finer;
        default: return scene.tolerance;
    }
}

// Tabulated ranges of view end at these, so that a camera that moves a little asks for the same
// table.
constexpr double mu_marks[] = {0,   0.001, 0.003, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15,
                               0.2, 0.25,  0.3,   0.35, 0.4,  0.45, 0.5,  0.55, 0.6, 0.65,
                               0.7, 0.75,  0.8,   0.85, 0.9,  0.95, 0.98, 1};
constexpr double azimuth_step = 5;  // degrees

constexpr double rounding = 1e-6;  // of ranges against lookups

/// Pairs of cosines that a table solves: where both axes are the same, of two ways round one.
std::size_t solved_pairs(const Range& mu_in, const Range& mu_out) {
    constexpr int samples = 32;  // of all cosines, about as many as are chosen
    const std::size_t in = mu_axis(mu_in, samples).values.size(),
                      out = mu_axis(mu_out, samples).values.size();
    return mu_in.min == mu_out.min && mu_in.max == mu_out.max ? in * (in + 1) / 2 : in * out;
}

/// Cosines of view to tabulate: all unless some take half of the pairs. What saves less is not worth
/// a table that serves fewer pictures.
Range tabulated_cosines(const Range& mu_in, const Range& asked) {
    const Range some{*(std::ranges::upper_bound(mu_marks, std::max(0.0, asked.min - rounding)) - 1),
                     *std::ranges::lower_bound(mu_marks, std::min(1.0, asked.max + rounding))};
    const std::size_t all =
        std::min(solved_pairs(mu_in, all_cosines), solved_pairs(all_cosines, all_cosines));
    return 2 * solved_pairs(mu_in, some) <= all ? some : all_cosines;
}

/// Azimuths to be tabulated for those that are asked for.
Range tabulated_azimuths(const Range& asked) {
    const auto step = [](double steps) { return std::clamp(azimuth_step * steps, 0.0, 180.0); };
    const Range some{step(std::floor((asked.min - rounding) / azimuth_step)),
                     step(std::ceil((asked.max + rounding) / azimuth_step))};
    return 2 * (some.max - some.min) <= all_azimuths.max ? some : all_azimuths;
}

/// Makes mu_in and mu_out the same where that takes no more pairs than both as they are.
void take_fewer_pairs(Recipe& recipe) {
    Range both = recipe.mu_in;
    widen(both, recipe.mu_out);
    if (solved_pairs(both, both) <= solved_pairs(recipe.mu_in, recipe.mu_out))
        recipe.mu_in = recipe.mu_out = both;
}

bool have_same_layers(const Recipe& one, const Recipe& other) {
    return std::ranges::equal(
        one.layers, other.layers, [](const StackLayer& a, const StackLayer& b) {
            return a.albedo == b.albedo && a.optical_depth == b.optical_depth &&
                   a.phase_function.text() == b.phase_function.text();
        });
}

}  // namespace

void check_table(const Scene& scene, const NeededRecipe& need, const PackedTable& packed) {
    const Table& table = packed.header();
    require(!table.lower_boundary.is_present(), "scene", "table.below", "absent", "one");
    require(table.highest_order == 0, "scene", "table.orders", "all", table.highest_order);
    const Recipe* const needed = &need.recipe;
    const auto same = [](const char* name, const PhaseFunction& own, const PhaseFunction& met) {
        require(met.text() == own.text(), "scene", name, own.text(), met.text());
    };
    same("table.phase_function", needed->phase_function, table.phase_function);
    Recipe of_table;
    of_table.layers = table.layers;
    require(have_same_layers(*needed, of_table), "scene", "table.layers",
            needed->layers.empty() ? "absent" : "those of the scene's stack",
            table.is_stack() ? "another stack" : "none");
    const Range* const mixture = mixture_range(*needed);
    require(table.has_family() == (mixture != nullptr), "scene", "table",
            mixture ? "one with a mixture axis" : "one without a mixture axis", "another");
    if (mixture)
        same("table.second_phase_function", needed->second_phase_function,
             table.second_phase_function);
    const auto covers = [&](const std::string& name, const AxisView& axis, const Range& range,
                            double slack = 0) {
        require(axis.lowest <= range.min + slack, "scene", name + ".min",
                "at most the scene's, " + shortest_text(range.min), axis.lowest);
        require(axis.highest >= range.max - slack || axis.ends_at_infinity, "scene", name + ".max",
                "at least the scene's, " + shortest_text(range.max), axis.highest);
    };
    covers("table.albedo", table.albedo.view(), needed->albedo);
    if (mixture) covers("table.mixture", table.family[0].axis.view(), *mixture);
    const AxisView depths = table.optical_depth.view();
    if (std::isinf(needed->optical_depth.max))
        require(depths.ends_at_infinity, "scene", "table.optical_depth.max", "inf", depths.highest);
    if (!std::isinf(needed->optical_depth.min))
        covers("table.optical_depth", depths, needed->optical_depth);
    const Asked asked_for = asked_by(need.path, scene);
    const SeenDirections& asked = asked_for.directions;
    covers("table.mu_in", table.mu_in.view(), {std::max(min_mu, asked.mu_in.min), asked.mu_in.max},
           rounding);
    if (need.path != LightPath::fluxes) {
        covers("table.mu_out", table.mu_out.view(),
               {std::max(min_mu, asked.mu_out.min), asked.mu_out.max}, rounding);
        const AxisView azimuth = table.azimuth.view();
        if (azimuth.count > 1 || azimuth.highest > 0)  // else nothing depends on it
            covers("table.azimuth", azimuth,
                   {radians(asked.azimuth.min), radians(asked.azimuth.max)}, rounding);
        require(!needed->reflection || packed.has_reflection(), "scene", "table",
                "one with reflection", "none");
    }
    require(!needed->transmission || packed.has_transmission(), "scene", "table",
            "one with transmission", "none");
}

std::optional<Matter> uniform_matter(const Scene& scene) {
    if (scene.subject_as<Rings>() || !scene.layer.optical_depth.is_plain()) return std::nullopt;
    return Matter{scene.layer.optical_depth.max, scene.layer.albedo, 1};
}

const char* light_path_name(LightPath path) {
    constexpr const char* names[] = {"sunlight", "fluxes", "shine"};
    return names[static_cast<std::size_t>(path)];
}

std::vector<LightPath> needed_paths(const Scene& scene) {
    const MatterSpan range = matter_range(scene);
    if (!scene.effects.multiple || range.optical_depth.max == 0 || range.albedo.max == 0) return {};
    const SeenLight seen = seen_light(scene), sunlight = seen_light(without_shine(scene));
    std::vector<LightPath> paths;
    if (sunlight.reflection || sunlight.transmission) paths.push_back(LightPath::sunlight);
    // Nothing passes through layers that are infinitely deep.
    if (seen.fluxes && !has_fluxes_with_sunlight(scene, sunlight) &&
        range.optical_depth.min < infinity)
        paths.push_back(LightPath::fluxes);
    if (seen.shine) paths.push_back(LightPath::shine);
    return paths;
}

namespace {

/// The recipe for the matter of a scene's layer.
Recipe matter_recipe(const Scene& scene, const MatterSpan& range) {
    if (!scene.layer.stacks.empty()) return recipe_of_stack(scene.layer.stacks[0], {});
    Recipe recipe;
    recipe.phase_function = scene.layer.components[0];
    if (scene.layer.components.size() > 1) {
        if (range.mixture.max - range.mixture.min < min_mixture_range) {
            const double share = (range.mixture.min + range.mixture.max) / 2;
            recipe.phase_function =
                PhaseFunction::mixture(share, scene.layer.components[0], scene.layer.components[1]);
        } else {
            set_mixture(recipe, scene.layer.components[1], range.mixture);
        }
    }
    recipe.phase_text = recipe.phase_function.text();
    // Beyond the limits of tables, lookups follow the laws of thin and deep layers (lookup.h).
    const auto tabulated = [](double depth, double least) {
        return std::isinf(depth) ? depth : std::clamp(depth, least, max_table_depth);
    };
    const auto [thinnest, deepest] = range.optical_depth;
    const bool is_one = thinnest == deepest && deepest >= min_table_depth;
    const double last = tabulated(deepest, is_one ? deepest : 2 * min_table_depth);
    recipe.optical_depth =
        merged({std::max(tabulated(thinnest, min_table_depth), thinnest_tabulated(last)), last});
    recipe.albedo = merged(range.albedo);
    return recipe;
}

}  // namespace

std::vector<NeededRecipe> needed_recipes(const Scene& scene) {
    std::vector<NeededRecipe> needed;
    const MatterSpan range = matter_range(scene);
    for (const LightPath path : needed_paths(scene)) {
        Recipe recipe = matter_recipe(scene, range);
        recipe.title = scene.title;
        const Asked asked = asked_by(path, scene);
        recipe.tolerance = path_tolerance(path, scene);
        recipe.mu_in = asked.directions.mu_in;
        recipe.mu_out = asked.directions.mu_out;
        const bool has_azimuth = scene.effects.azimuth && path != LightPath::fluxes;
        if (path != LightPath::fluxes)
            recipe.mu_out = tabulated_cosines(recipe.mu_in, recipe.mu_out);
        if (has_azimuth) recipe.azimuth = tabulated_azimuths(asked.directions.azimuth);
        take_fewer_pairs(recipe);
        recipe.transmission = asked.transmission && range.optical_depth.min < infinity;
        recipe.reflection = asked.reflection || !recipe.transmission;
        if (!has_azimuth) {
            recipe.discretisation.modes = recipe.discretisation.azimuth_samples = 1;
            recipe.discretisation.azimuth_scale = AxisScale::linear;
        }
        needed.push_back({path, std::move(recipe)});
    }
    return needed;
}

std::optional<Recipe> common_recipe(const Recipe& one, const Recipe& other) {
    if (one.phase_text != other.phase_text || !have_same_layers(one, other) ||
        std::isinf(one.optical_depth.min) != std::isinf(other.optical_depth.min) ||
        one.discretisation.modes != other.discretisation.modes ||
        one.family.size() != other.family.size() ||
        one.second_phase_function.text() != other.second_phase_function.text())
        return std::nullopt;
    Recipe both = one;
    both.tolerance = std::min(one.tolerance, other.tolerance);
    for (Range Recipe::*const range : {&Recipe::optical_depth, &Recipe::albedo, &Recipe::mu_in,
                                       &Recipe::mu_out, &Recipe::azimuth})
        widen(both.*range, other.*range);
    take_fewer_pairs(both);
    if (Range* const mixture = mixture_range(both)) widen(*mixture, *mixture_range(other));
    both.reflection = one.reflection || other.reflection;
    both.transmission = one.transmission || other.transmission;
    return both;
}

std::vector<SharedRecipe> shared_recipes(const Scenes& scenes) {
    std::vector<SharedRecipe> all;
    for (std::size_t s = 0; s < scenes.size(); ++s) {
        const bool uniform = uniform_matter(scenes[s]).has_value();
        for (NeededRecipe& needed : needed_recipes(scenes[s])) {
            bool found = false;
            for (SharedRecipe& shared : all) {
                if (shared.path != needed.path || shared.uniform != uniform) continue;
                const std::optional<Recipe> both = common_recipe(shared.recipe, needed.recipe);
                if (!both) continue;
                shared.recipe = *both;
                shared.scenes.push_back(s);
                found = true;
                break;
            }
            if (!found) all.push_back({needed.path, std::move(needed.recipe), uniform, {s}});
        }
    }
    return all;
}

}  // namespace stratus
