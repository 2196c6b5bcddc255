#include <stratus/scene/plan.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include <stratus/runtime/argument.h>
#include <stratus/scene/render.h>

namespace stratus {
namespace {

constexpr double coarse_tolerance = 1e-2;  // of tables that contributions are looked up in
constexpr double most_pixels = 16384;      // looked at
constexpr double darkest_share =
    0.01;                             // of the brightest pixel, least that changes are relative to
constexpr double sparse_share = 0.5;  // of the tolerance, for what sparse pixels may change by

/// What saves most comes first: a table, a side of one, its azimuths, fifteen suns of sixteen.
constexpr const char* dearest_first[] = {"multiple",   "transmission", "reflection", "azimuth",
                                         "sun_size",   "opposition",   "density",    "shadows",
                                         "background", "single"};

bool SceneEffects::*effect_named(const char* name) {
    for (const auto& [known, member] : scene_effects())
        if (std::string(known) == name) return member;
    return nullptr;
}

Scene with_effects(Scene scene, const SceneEffects& effects) {
    scene.effects = effects;
    return scene;
}

Scene without(Scene scene, bool SceneEffects::*effect) {
    scene.effects.*effect = false;
    return scene;
}

/// The same picture of fewer pixels, one ray each through the middle of what they stand for.
Scene sparse(Scene scene) {
    const double pixels = static_cast<double>(scene.width) * scene.height;
    const double step = std::max(1.0, std::sqrt(pixels / most_pixels));
    scene.width = std::max(1, static_cast<int>(scene.width / step));
    scene.height = std::max(1, static_cast<int>(scene.height / step));
    scene.samples = 1;
    return scene;
}

Image sparse_picture(const Scene& scene, const LayerTables* tables, int threads) {
    const LayerLight light(scene, tables);
    RenderOptions options;
    options.threads = threads;
    return render(sparse(scene), light, options);
}

double brightest_channel(const float* pixel) {
    return double{std::max({pixel[0], pixel[1], pixel[2]})};
}

struct Change {
    double mean = 0, largest = 0;
};

Change change_between(const Image& all, const Image& some) {
    double brightest = 0, light = 0, sum = 0;
    for (int y = 0; y < all.height; ++y)
        for (int x = 0; x < all.width; ++x) {
            brightest = std::max(brightest, brightest_channel(all.pixel(x, y)));
            light += brightest_channel(all.pixel(x, y));
        }
    Change change;
    if (brightest == 0) return change;
    for (int y = 0; y < all.height; ++y)
        for (int x = 0; x < all.width; ++x) {
            const float *const one = all.pixel(x, y), *const other = some.pixel(x, y);
            double difference = 0;
            for (int c = 0; c < 3; ++c)
                difference = std::max(difference, std::abs(double{one[c]} - double{other[c]}));
            sum += difference;
            change.largest =
                std::max(change.largest,
                         difference / std::max(brightest_channel(one), darkest_share * brightest));
        }
    change.mean = sum / light;
    return change;
}

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Seconds and bytes of what a scene bakes. `resolved` is filled in where it is empty, else its
/// choices serve again.
SceneCost bake_cost(const Scene& scene, std::optional<Recipe>& resolved, double& resolve_seconds,
                    const BakeOptions& options) {
    std::optional<Recipe> recipe = needed_recipe(scene);
    if (!recipe) return {};
    if (!resolved) {
        const auto started = Clock::now();
        resolved = resolve(*recipe, options);
        resolve_seconds = seconds_since(started);
    }
    const Discretisation own = recipe->discretisation;
    recipe->discretisation = resolved->discretisation;
    if (own.modes > 0) recipe->discretisation.modes = own.modes;
    if (own.azimuth_samples > 0) recipe->discretisation.azimuth_samples = own.azimuth_samples;
    const double albedos = recipe->discretisation.albedo_samples;
    recipe->albedo.min = recipe->albedo.max;
    recipe->discretisation.albedo_samples = 1;
    const auto started = Clock::now();
    const Table one = solve_table(*recipe, options);
    const double mixtures = static_cast<double>(mixture_fractions(scene).size());
    const double sides = (recipe->reflection ? 1 : 0) + (recipe->transmission ? 1 : 0);
    return {mixtures * (resolve_seconds + albedos * seconds_since(started)),
            mixtures * albedos * sides * static_cast<double>(one.sample_count() * sizeof(float)),
            0};
}

double ray_nanoseconds(const Scene& scene, const LayerTables* tables) {
    double least = 0;
    for (int round = 0; round < 3; ++round) {
        const auto started = Clock::now();
        const Image image = sparse_picture(scene, tables, 1);
        const double now = seconds_since(started) / (image.width * image.height);
        if (round == 0 || now < least) least = now;
    }
    return 1e9 * least;
}

}  // namespace

std::vector<Plan> plan_scenes(const std::vector<Scene>& scenes, double tolerance,
                              const BakeOptions& options) {
    require(tolerance >= 0 && tolerance < 1, "plan_scenes", "tolerance", "in (0, 1)", tolerance);
    const std::size_t effects = scene_effects().size();
    std::vector<Scene> variants;  // of each scene: with everything, then without one effect each
    for (Scene scene : scenes) {
        scene.tolerance = std::max(scene.tolerance, coarse_tolerance);
        variants.push_back(scene);
        for (const auto& [name, effect] : scene_effects())
            variants.push_back(without(scene, effect));
    }
    const auto tables = bake_for(variants, options);
    std::vector<Plan> plans;
    for (std::size_t s = 0; s < scenes.size(); ++s) {
        const std::size_t first = s * (effects + 1);
        const Scene& scene = variants[first];
        const Image all = sparse_picture(scene, tables[first].get(), options.threads);
        Plan plan;
        plan.tolerance = tolerance > 0 ? tolerance : scenes[s].tolerance;
        plan.effects = scene.effects;
        plan.pixels = all.width * all.height;
        std::size_t without_azimuth = first;
        for (std::size_t e = 0; e < effects; ++e) {
            const auto& [name, effect] = scene_effects()[e];
            if (effect == &SceneEffects::azimuth) without_azimuth = first + 1 + e;
            if (!(scene.effects.*effect)) continue;
            const std::size_t variant = first + 1 + e;
            const Change change = change_between(
                all, sparse_picture(variants[variant], tables[variant].get(), options.threads));
            plan.shares.push_back({name, change.mean, change.largest, true});
        }
        const double limit = sparse_share * plan.tolerance;
        for (const char* const name : dearest_first) {
            const auto share =
                std::find_if(plan.shares.begin(), plan.shares.end(),
                             [&](const EffectShare& each) { return each.name == name; });
            if (share == plan.shares.end() || share->largest > limit) continue;
            const Scene less = without(with_effects(scene, plan.effects), effect_named(name));
            const auto& looked_up = tables[less.effects.azimuth ? first : without_azimuth];
            const Change change =
                change_between(all, sparse_picture(less, looked_up.get(), options.threads));
            if (change.largest > limit) continue;
            share->needed = false;
            plan.effects = less.effects;
            plan.change = change.largest;
        }
        plans.push_back(std::move(plan));
    }
    return plans;
}

PlanCosts measure_costs(const Scene& scene, const Plan& plan, const BakeOptions& options) {
    std::vector<Scene> variants{scene, with_effects(scene, plan.effects)};
    for (const EffectShare& share : plan.shares)
        variants.push_back(without(scene, effect_named(share.name.c_str())));
    std::vector<Scene> coarse = variants;
    for (Scene& each : coarse) each.tolerance = std::max(each.tolerance, coarse_tolerance);
    const auto tables = bake_for(coarse, options);
    std::vector<SceneCost> costs;
    std::optional<Recipe> resolved;
    double resolve_seconds = 0;
    for (std::size_t v = 0; v < variants.size(); ++v) {
        costs.push_back(bake_cost(variants[v], resolved, resolve_seconds, options));
        costs.back().ray_ns = ray_nanoseconds(coarse[v], tables[v].get());
    }
    return {costs[0], costs[1], {costs.begin() + 2, costs.end()}};
}

AskedRange measure_range(const Scene& scene) {
    Scene once = scene;
    once.effects.multiple = false;
    LayerLight light(once, nullptr);
    AskedRange asked;
    light.watch(&asked);
    RenderOptions options;
    options.threads = 1;
    render(sparse(once), light, options);
    return asked;
}

}  // namespace stratus
