#include <stratus/scene/plan.h>

#include <stratus/bake/clock.h>
#include <stratus/runtime/constants.h>
#include <stratus/scene/render.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <utility>

namespace stratus {
namespace {

constexpr double coarse_tolerance = 1e-2;  // of the tables for measurements
constexpr double max_pixels = 16384;       // measured
constexpr double min_reference =
    0.01;  // changes are relative to at least this share of the brightest pixel
constexpr double sparse_share = 0.5;  // of the tolerance; the rest is for pixels not measured

/// The most expensive first: a table, a side of one, its azimuths, fifteen suns of sixteen.
constexpr bool SceneEffects::*dearest_first[] = {
    &SceneEffects::multiple, &SceneEffects::transmission, &SceneEffects::reflection,
    &SceneEffects::azimuth,  &SceneEffects::sun_size,     &SceneEffects::opposition,
    &SceneEffects::density,  &SceneEffects::shadows,      &SceneEffects::background,
    &SceneEffects::single};

Scene with_effects(Scene scene, const SceneEffects& effects) {
    scene.effects = effects;
    return scene;
}

SceneEffects without(SceneEffects effects, bool SceneEffects::*effect) {
    effects.*effect = false;
    return effects;
}

Scene without(const Scene& scene, bool SceneEffects::*effect) {
    return with_effects(scene, without(scene.effects, effect));
}

/// The same picture with at most so many pixels, one ray each.
Scene sparse(Scene scene, double max_pixels) {
    const double pixels = static_cast<double>(scene.width) * scene.height;
    const double step = std::max(1.0, std::sqrt(pixels / max_pixels));
    scene.width = std::max(1, static_cast<int>(scene.width / step));
    scene.height = std::max(1, static_cast<int>(scene.height / step));
    scene.samples = 1;
    return scene;
}

double brightest_channel(const float* pixel) {
    return double{std::max({pixel[0], pixel[1], pixel[2]})};
}

struct Change {
    double mean = 0, max = 0;
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
            change.max = std::max(change.max, difference / std::max(brightest_channel(one),
                                                                    min_reference * brightest));
        }
    change.mean = sum / light;
    return change;
}

/// Identifies a recipe, whatever its title.
std::string text_of(Recipe recipe) {
    recipe.title.clear();
    return resolved_text(recipe);
}

/// Seconds and bytes of a scene's bake. One resolution serves all scenes that differ in effects
/// alone.
class BakeCosts {
  public:
    explicit BakeCosts(const BakeOptions& options) : options_(options) {}

    /// Channels with their own phase functions cost what green does, each.
    SceneCost of(const Scene& scene) {
        const std::vector<Scene> channels = channel_scenes(scene);
        const std::optional<Recipe> recipe = needed_recipe(channels[channels.size() / 2]);
        if (!recipe) return {};
        const std::string text = text_of(*recipe);
        const auto known = known_.find(text);
        const SceneCost one =
            known != known_.end() ? known->second : known_[text] = measured(*recipe);
        const auto count = static_cast<double>(channels.size());
        return {count * one.bake_seconds, count * one.bytes, 0};
    }

  private:
    SceneCost measured(Recipe recipe) {
        if (!resolved_) {
            const auto started = Clock::now();
            resolved_ = resolve(recipe, options_);
            resolve_seconds_ = seconds_since(started);
        }
        const Discretisation own = recipe.discretisation;
        recipe.discretisation = resolved_->discretisation;
        if (own.modes > 0) recipe.discretisation.modes = own.modes;
        if (own.azimuth_samples > 0) {
            recipe.discretisation.azimuth_samples = own.azimuth_samples;
            recipe.discretisation.azimuth_scale = own.azimuth_scale;
        }
        const double albedos = recipe.discretisation.albedo_samples;
        recipe.albedo.min = recipe.albedo.max;
        recipe.discretisation.albedo_samples = 1;
        const auto started = Clock::now();
        const Table one = solve_table(recipe, options_);
        const double sides = (recipe.reflection ? 1 : 0) + (recipe.transmission ? 1 : 0);
        return {resolve_seconds_ + albedos * seconds_since(started),
                albedos * sides * static_cast<double>(one.sample_count() * sizeof(float)), 0};
    }

    const BakeOptions& options_;
    std::optional<Recipe> resolved_;
    double resolve_seconds_ = 0;
    std::map<std::string, SceneCost> known_;  // by recipe
};

double ray_nanoseconds(const Scene& scene, const LayerTables* tables) {
    const Scene few = sparse(scene, max_pixels / 8);
    const LayerLight light(scene, tables);
    RenderOptions options;
    options.threads = 1;
    double fastest = 0;
    for (int round = 0; round < 5; ++round) {
        const auto started = Clock::now();
        render(few, light, options);
        const double now = seconds_since(started) / (few.width * few.height);
        if (round == 0 || now < fastest) fastest = now;
    }
    return 1e9 * fastest;
}

/// Shares of an azimuth axis' samples in the mean over azimuth.
std::vector<double> azimuth_shares(const AxisView& axis) {
    const int azimuths = 64 * axis.count;
    std::vector<double> shares(static_cast<std::size_t>(axis.count));
    for (int n = 0; n < azimuths; ++n) {
        const Stencil stencil = axis.mirrored_stencil(pi * (n + 0.5) / azimuths);
        for (int i = 0; i < std::min(stencil_size, axis.count); ++i)
            shares[static_cast<std::size_t>(stencil.first + i)] +=
                double{stencil.weight[i]} / azimuths;
    }
    return shares;
}

/// A table's mean over azimuth.
Table azimuth_mean(const Table& table) {
    Table mean = table;
    mean.azimuth = {AxisScale::linear, {0}};
    const std::vector<double> shares = azimuth_shares(table.azimuth.view());
    const std::size_t azimuths = shares.size();
    if (azimuths > 1)
        for (std::vector<float>* side : {&mean.reflection_multiple, &mean.transmission_multiple}) {
            for (std::size_t row = 0; row < side->size() / azimuths; ++row) {
                const float* const around = side->data() + row * azimuths;
                double sum = 0;
                for (std::size_t k = 0; k < azimuths; ++k) sum += shares[k] * double{around[k]};
                (*side)[row] = static_cast<float>(sum);
            }
            side->resize(side->size() / azimuths);
        }
    prepare(mean);
    return mean;
}

std::shared_ptr<const LayerTables> azimuth_mean(const LayerTables& tables) {
    auto mean = std::make_shared<LayerTables>();
    mean->mixture = tables.mixture;
    for (std::size_t c = 0; c < tables.channels.size(); ++c)
        if (tables.channels[c]) mean->channels[c] = azimuth_mean(*tables.channels[c]);
    for (const Table& table : tables.tables) mean->tables.push_back(azimuth_mean(table));
    if (!tables.textured.empty())
        for (const Table& table : mean->tables) mean->textured.emplace_back(table.view());
    return mean;
}

/// Pictures of one scene with some of its effects, looked up in coarse tables.
class CoarseScene {
  public:
    CoarseScene(const Scene& scene, const BakeOptions& options) : all_(scene), options_(options) {
        all_.tolerance = std::max(all_.tolerance, coarse_tolerance);
    }

    /// The scenes that one table has to serve.
    std::vector<Scene> to_bake() const {
        std::vector<Scene> scenes{all_};
        if (all_.layer.density > 0) scenes.push_back(without(all_, &SceneEffects::density));
        return scenes;
    }
    void set_tables(std::shared_ptr<const LayerTables> tables,
                    std::shared_ptr<const LayerTables> without_azimuth) {
        with_azimuth_ = std::move(tables);
        without_azimuth_ = std::move(without_azimuth);
    }

    Image picture(const SceneEffects& effects) const {
        const Scene scene = with_effects(all_, effects);
        const LayerLight light(scene, tables(effects));
        RenderOptions options;
        options.threads = options_.threads;
        return render(sparse(scene, max_pixels), light, options);
    }

    double ray_ns(const SceneEffects& effects) const {
        return ray_nanoseconds(with_effects(all_, effects), tables(effects));
    }

  private:
    const LayerTables* tables(const SceneEffects& effects) const {
        return effects.azimuth ? with_azimuth_.get() : without_azimuth_.get();
    }

    Scene all_;
    const BakeOptions& options_;
    std::shared_ptr<const LayerTables> with_azimuth_, without_azimuth_;
};

/// The size of the sun is measured by itself and all else under a point sun, which needs far fewer
/// rays.
Plan plan_scene(const Scene& scene, const CoarseScene& coarse) {
    const auto sun_size = &SceneEffects::sun_size;
    SceneEffects now = without(scene.effects, sun_size);  // still needed
    const Image all = coarse.picture(now);
    Plan plan;
    plan.tolerance = scene.tolerance;
    plan.pixels = all.width * all.height;
    for (const auto& [name, effect] : scene_effects()) {
        if (!(scene.effects.*effect)) continue;
        Change change;
        if (effect != sun_size)
            change = change_between(all, coarse.picture(without(now, effect)));
        else if (scene.sun_diameter > 0)
            change = change_between(coarse.picture(scene.effects), all);
        plan.shares.push_back({name, effect, change.mean, change.max, true});
    }
    const double limit = sparse_share * plan.tolerance;
    double sun_change = 0;
    bool keeps_sun_size = false;
    for (const auto effect : dearest_first) {
        const auto share = std::ranges::find(plan.shares, effect, &EffectShare::effect);
        if (share == plan.shares.end()) continue;
        if (effect == sun_size) {
            keeps_sun_size = share->max > limit / 2;
            if (!keeps_sun_size) sun_change = share->max;
            share->needed = keeps_sun_size;
            continue;
        }
        if (share->max > limit) continue;
        const SceneEffects less = without(now, effect);
        const Change change = change_between(all, coarse.picture(less));
        if (change.max > limit) continue;
        share->needed = false;
        now = less;
        plan.max_change = change.max;
    }
    plan.effects = now;
    plan.effects.sun_size = keeps_sun_size;
    plan.max_change += sun_change;
    return plan;
}

PlanCosts costs_of(const Scene& scene, const CoarseScene& coarse, const Plan& plan,
                   BakeCosts& bake_costs) {
    const auto cost = [&](const SceneEffects& effects) {
        SceneCost all = bake_costs.of(with_effects(scene, effects));
        all.ray_ns = coarse.ray_ns(effects);
        return all;
    };
    PlanCosts costs{cost(scene.effects), cost(plan.effects), {}};
    for (const EffectShare& share : plan.shares)
        costs.without.push_back(cost(without(scene.effects, share.effect)));
    return costs;
}

}  // namespace

std::vector<Plan> plan_scenes(const std::vector<Scene>& scenes, const PlanOptions& options) {
    std::vector<CoarseScene> coarse;
    std::vector<Scene> to_bake;
    std::vector<std::size_t> first;  // of each scene's
    for (const Scene& scene : scenes) {
        coarse.emplace_back(scene, options.bake);
        first.push_back(to_bake.size());
        for (Scene& each : coarse.back().to_bake()) to_bake.push_back(std::move(each));
    }
    const auto tables = bake_for(to_bake, options.bake);
    // Tables that scenes share are averaged over azimuth once.
    std::map<std::shared_ptr<const LayerTables>, std::shared_ptr<const LayerTables>> means;
    std::map<std::string, BakeCosts> bake_costs;  // by recipe
    std::vector<Plan> plans;
    for (std::size_t s = 0; s < scenes.size(); ++s) {
        const auto& shared = tables[first[s]];
        auto& mean = means[shared];
        if (shared && !mean) mean = azimuth_mean(*shared);
        coarse[s].set_tables(shared, mean);
        plans.push_back(plan_scene(scenes[s], coarse[s]));
        if (!options.costs) continue;
        const std::optional<Recipe> recipe = needed_recipe(scenes[s]);
        const auto costs = bake_costs.try_emplace(recipe ? text_of(*recipe) : "", options.bake);
        plans.back().costs = costs_of(scenes[s], coarse[s], plans.back(), costs.first->second);
    }
    return plans;
}

LookupRange measure_range(const Scene& scene) {
    Scene once = scene;
    once.effects.multiple = false;
    LayerLight light(once, nullptr);
    LookupRange range;
    light.record(&range);
    RenderOptions options;
    options.threads = 1;
    render(sparse(once, max_pixels), light, options);
    return range;
}

}  // namespace stratus
