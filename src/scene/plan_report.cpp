// What each effect of a scene changes and costs, for people.
#include <stratus/bake/clock.h>
#include <stratus/bake/parallel.h>
#include <stratus/base/angle.h>
#include <stratus/base/number_text.h>
#include <stratus/io/table_file.h>
#include <stratus/scene/contents.h>
#include <stratus/scene/plan.h>
#include <stratus/scene/render.h>

#include "forecast.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <utility>

namespace stratus {
namespace {

constexpr double coarse_tolerance = 1e-2;  // of the sparse picture's tables
constexpr double max_pixels = 16384;       // of the sparse picture
constexpr double min_reference =
    0.01;  // a pixel's change is relative to at least this share of the brightest
constexpr int timings = 5;
constexpr int timed_rows = 6;
constexpr int listed_orders = 64;

Scene without(Scene scene, bool SceneEffects::*effect) {
    scene.effects.*effect = false;
    return scene;
}

/// The same picture with at most so many pixels, one ray each.
Scene sparse(Scene scene, double most) {
    const double pixels = static_cast<double>(scene.width) * scene.height;
    const double step = std::max(1.0, std::sqrt(pixels / most));
    scene.width = std::max(1, static_cast<int>(scene.width / step));
    scene.height = std::max(1, static_cast<int>(scene.height / step));
    scene.samples = 1;
    return scene;
}

// ---- changes ------------------------------------------------------------------------------------

double brightest_channel(const float* pixel) {
    return double{std::max({pixel[0], pixel[1], pixel[2]})};
}

struct PictureChange {
    double mean = 0, max = 0;
    int x = 0, y = 0;  // of max
};

PictureChange change_between(const Image& all, const Image& some) {
    double brightest = 0, light = 0, sum = 0;
    for (int y = 0; y < all.height; ++y)
        for (int x = 0; x < all.width; ++x) {
            brightest = std::max(brightest, brightest_channel(all.pixel(x, y)));
            light += brightest_channel(all.pixel(x, y));
        }
    PictureChange change;
    if (brightest == 0) return change;
    for (int y = 0; y < all.height; ++y)
        for (int x = 0; x < all.width; ++x) {
            const float *const one = all.pixel(x, y), *const other = some.pixel(x, y);
            double difference = 0;
            for (int c = 0; c < 3; ++c)
                difference = std::max(difference, std::abs(double{one[c]} - double{other[c]}));
            sum += difference;
            const double relative =
                difference / std::max(brightest_channel(one), min_reference * brightest);
            if (relative > change.max) {
                change.max = relative;
                change.x = x;
                change.y = y;
            }
        }
    change.mean = sum / light;
    return change;
}

/// Of a whole picture.
double rays_of(const Scene& scene) {
    return static_cast<double>(scene.width) * scene.height *
           std::max(static_cast<double>(scene.samples) * scene.samples,
                    static_cast<double>(sun_directions(scene).size()));
}

/// Pictures of one scene with some of its effects, looked up in coarse tables.
class CoarseScene {
  public:
    CoarseScene(const Scene& scene, int threads) : all_(scene), threads_(threads) {
        all_.tolerance = std::max(all_.tolerance, coarse_tolerance);
    }

    /// The scenes that tables have to serve: two with azimuth, for one table, and one without.
    std::vector<Scene> to_bake() const {
        return {all_, without(all_, &SceneEffects::density), without(all_, &SceneEffects::azimuth)};
    }
    void set_tables(std::shared_ptr<const LayerTables> tables,
                    std::shared_ptr<const LayerTables> without_azimuth) {
        with_azimuth_ = std::move(tables);
        without_azimuth_ = std::move(without_azimuth);
    }

    /// A sparse picture, and what a ray costs.
    struct Trial {
        Image picture;
        Measured ray_ns;
    };
    /// Made once for each set of effects: light that rings and their planet exchange takes a second.
    const Trial& with(SceneEffects effects) {
        effects.sun_size = effects.sun_size && all_.sun_diameter > 0;
        const auto known = std::ranges::find(tried_, effects, &Tried::effects);
        if (known != tried_.end()) return *known->trial;
        Scene scene = all_;
        scene.effects = effects;
        const LayerLight light(scene, tables(effects));
        RenderOptions options;
        options.threads = threads_;
        Image picture = render(sparse(scene, max_pixels), light, options);
        tried_.push_back({effects, std::make_unique<const Trial>(
                                       Trial{std::move(picture), ray_ns(scene, light)})});
        return *tried_.back().trial;
    }

    /// Seconds on one thread until a picture may begin: binding the layer, and what rings and their
    /// planet send one another.
    double light_seconds(const SceneEffects& effects) const {
        Scene scene = all_;
        scene.effects = effects;
        const double started = processor_seconds();
        const LayerLight light(scene, tables(effects), 1);
        return processor_seconds() - started;
    }

    const LayerTables* tables() const { return with_azimuth_.get(); }

  private:
    struct Tried {
        SceneEffects effects;
        std::unique_ptr<const Trial> trial;
    };

    const LayerTables* tables(const SceneEffects& effects) const {
        return effects.azimuth ? with_azimuth_.get() : without_azimuth_.get();
    }

    static Measured ray_ns(const Scene& scene, const LayerLight& light) {
        // A few whole rows: neighbouring rays, as in the picture, are faster than scattered ones.
        RenderOptions options;
        options.threads = 1;
        options.row_step = std::max(1, scene.height / timed_rows);
        const int rows = (scene.height - 1 - options.row_step / 2) / options.row_step + 1;
        const double rays = rays_of(scene) * rows / scene.height;
        std::vector<double> ns;
        for (int round = 0; round < timings; ++round) {
            const double started = processor_seconds();
            render(scene, light, options);
            ns.push_back(1e9 * (processor_seconds() - started) / rays);
        }
        std::ranges::sort(ns);
        // The outermost two are left out: what the machine does besides.
        return {ns[timings / 2], (ns[timings - 2] - ns[1]) / 2};
    }

    Scene all_;
    int threads_;
    std::shared_ptr<const LayerTables> with_azimuth_, without_azimuth_;
    std::vector<Tried> tried_;
};

/// What the opposition of single scattering adds, at the smallest phase angle that is seen.
ChangeBound opposition_bound(const Scene& scene) {
    ChangeBound change;
    const SeenDirections seen = seen_directions(scene);
    const double angle = seen_scattering_angles(scene, Side::reflection).max;
    const Opposition opposition =
        seen_opposition(scene.layer.opposition, scene.effects.density ? scene.layer.density : 0);
    for (const MatterSpan& span : matter_spans(scene))
        for (const double mu_in : {seen.mu_in.min, seen.mu_in.max})
            for (const double mu_out : {seen.mu_out.min, seen.mu_out.max}) {
                const double share =
                    1 - 1 / opposition_factor(opposition, std::cos(radians(angle)),
                                              span.optical_depth.max, mu_in, mu_out);
                if (share <= change.found) continue;
                change.found = change.bound = share;
                change.where = "phase angle " + short_number(180 - angle, 3) +
                               " deg, optical depth " + short_number(span.optical_depth.max, 3);
            }
    return change;
}

bool is_seen(const Scene& scene, bool SceneEffects::*effect) {
    const SeenLight seen = seen_light(scene);
    if (effect == &SceneEffects::reflection) return seen.reflection;
    if (effect == &SceneEffects::transmission) return seen.transmission || seen.fluxes;
    if (effect == &SceneEffects::sun_size) return scene.sun_diameter > 0;
    if (effect == &SceneEffects::density) return scene.layer.density > 0;
    if (effect == &SceneEffects::azimuth) return scene.effects.multiple && seen.any();
    if (effect == &SceneEffects::shadows) return std::holds_alternative<Rings>(scene.subject);
    if (effect == &SceneEffects::ringshine || effect == &SceneEffects::planetshine)
        return seen.shine;
    if (effect == &SceneEffects::opposition)
        return seen.reflection && scene.layer.opposition.law != Opposition::Law::none;
    return true;
}

std::vector<EffectShare> shares_of(const Scene& scene, CoarseScene& coarse, const Plan& plan,
                                   const OrderBounds& bounds) {
    // The size of the sun is measured by itself and all else under a point sun, which needs far
    // fewer rays.
    const auto sun_size = &SceneEffects::sun_size;
    SceneEffects point_sun = scene.effects;
    point_sun.sun_size = false;
    const Image& all = coarse.with(point_sun).picture;
    std::vector<EffectShare> shares;
    for (const auto& [name, effect] : scene_effects()) {
        if (!(scene.effects.*effect)) continue;
        EffectShare share{name, effect, is_seen(scene, effect), false, 0, 0, "", "kept"};
        if (!share.seen) {
            share.fate = "not seen";
            shares.push_back(share);
            continue;
        }
        SceneEffects less = point_sun;
        less.*effect = false;
        const PictureChange change = effect == sun_size
                                         ? change_between(coarse.with(scene.effects).picture, all)
                                         : change_between(all, coarse.with(less).picture);
        share.mean = change.mean;
        share.max = change.max;
        if (change.max > 0)
            share.where = "pixel (" + std::to_string(change.x) + ", " + std::to_string(change.y) +
                          ") of the sparse picture";
        std::optional<ChangeBound> bound;
        if (effect == &SceneEffects::multiple) bound = bounds.multiple;
        if (effect == &SceneEffects::azimuth) bound = bounds.azimuth;
        if (effect == &SceneEffects::opposition) bound = opposition_bound(scene);
        if (bound && (bound->bound < 1 || bound->found > 0)) {
            share.bounded = true;
            share.max = bound->bound;
            share.where = bound->where;
        }
        if (std::ranges::find(scene.named, effect) != scene.named.end())
            share.fate = "kept, being named";
        if (!(plan.effects.*effect)) share.fate = "left out";
        shares.push_back(share);
    }
    return shares;
}

// ---- costs --------------------------------------------------------------------------------------

/// Identifies a recipe, whatever its title.
std::string text_of(Recipe recipe) {
    recipe.title.clear();
    return resolved_text(recipe);
}

/// Seconds that packing a table and keeping it take per byte of it, measured on another one.
double keep_seconds_per_byte(const LayerTables* tables) {
    const LayerTables* one = tables;
    while (one && !one->at(LightPath::sunlight)) {  // channels
        const LayerTables* next = nullptr;
        for (const auto& channel : one->channels)
            if (channel) next = channel.get();
        one = next;
    }
    if (!one) return 0;
    const Table table = one->at(LightPath::sunlight)->packed.unpacked();
    const double bytes =
        static_cast<double>(sizeof(float)) *
        static_cast<double>(table.reflection_multiple.size() + table.transmission_multiple.size());
    const double started = processor_seconds();
    const std::vector<char> packed = pack(table);
    return (processor_seconds() - started) / bytes;
}

/// Costs of tables, each recipe's forecast made once.
class TableCosts {
  public:
    explicit TableCosts(const BakeOptions& options) : options_(table_options(options)) {}

    /// Of scenes that share tables.
    SceneCost of(const std::vector<Scene>& scenes, double keep_seconds_per_byte) {
        std::vector<Scene> channels;
        for (const Scene& scene : scenes)
            for (Scene& channel : channel_scenes(scene)) channels.push_back(std::move(channel));
        SceneCost sum;
        for (const SharedRecipe& shared : shared_recipes(channels)) {
            const SceneCost& one = of(shared.recipe);
            sum.choose_seconds += one.choose_seconds;
            sum.solve_seconds += one.solve_seconds;
            sum.check_seconds += one.check_seconds;
            sum.bytes += one.bytes;
        }
        sum.keep_seconds = keep_seconds_per_byte * sum.bytes;
        return sum;
    }

  private:
    const SceneCost& of(const Recipe& recipe) {
        const auto [known, fresh] = known_.try_emplace(text_of(recipe));
        if (!fresh) return known->second;
        SceneCost& cost = known->second;
        const double started = processor_seconds();
        const Resolution resolution = resolve_as_first(recipe, options_);
        cost.choose_seconds = (processor_seconds() - started) / thread_count(options_.threads);
        const Forecast ahead = forecast_of(resolution, options_);
        cost.solve_seconds = ahead.bake_seconds;
        cost.check_seconds = ahead.check_seconds;
        cost.bytes = ahead.bytes;
        return cost;
    }

    BakeOptions options_;
    std::map<std::string, SceneCost> known_;  // by recipe
};

PlanCosts costs_of(const Scene& scene, CoarseScene& coarse, const PlanReport& report,
                   TableCosts& tables, double keeping) {
    const auto cost = [&](const Scene& some) {
        SceneCost all = tables.of({some}, keeping);
        all.ray_ns = coarse.with(some.effects).ray_ns;
        all.rays = rays_of(some);
        return all;
    };
    PlanCosts costs;
    costs.all = cost(scene);
    Scene planned = scene;
    planned.effects = report.plan.effects;
    costs.planned = report.plan.left_out.empty() ? costs.all : cost(planned);
    for (const EffectShare& share : report.shares)
        costs.without.push_back(share.seen ? cost(without(scene, share.effect)) : costs.all);
    return costs;
}

}  // namespace

FileReport report_plans(const std::vector<Scene>& scenes, const BakeOptions& options,
                        TableCache* cache) {
    std::vector<CoarseScene> coarse;
    std::vector<Scene> to_bake;
    for (const Scene& scene : scenes) {
        coarse.emplace_back(scene, options.threads);
        for (Scene& each : coarse.back().to_bake()) to_bake.push_back(std::move(each));
    }
    const auto tables = bake_for(to_bake, options, cache);
    TableCosts table_costs(options);
    FileReport file;
    std::vector<Scene> planned;
    double keeping = 0;
    const double threads = thread_count(options.threads);
    for (std::size_t s = 0; s < scenes.size(); ++s) {
        const Scene& scene = scenes[s];
        const std::size_t each = tables.size() / scenes.size();
        coarse[s].set_tables(tables[s * each], tables[(s + 1) * each - 1]);

        PlanReport report;
        const auto started = Clock::now();
        report.plan = plan_scene(scene);
        report.plan_seconds = seconds_since(started);
        OrderBounds bounds;
        if (scene.effects.multiple)
            for (const Scene& channel : channel_scenes(scene)) {
                const OrderBounds one =
                    bound_orders(channel, std::numeric_limits<double>::infinity());
                join(bounds.multiple, one.multiple);
                join(bounds.azimuth, one.azimuth);
            }
        report.shares = shares_of(scene, coarse[s], report.plan, bounds);
        const Scene few = sparse(scene, max_pixels);
        report.width = few.width;
        report.height = few.height;
        if (bounds.multiple.place) {
            report.orders.emplace();
            report.orders->share = order_shares(*bounds.multiple.place, listed_orders);
            report.orders->enough = orders_for(report.orders->share, scene.tolerance);
            report.orders->where = bounds.multiple.place->text();
        }
        const double keeping_here = keep_seconds_per_byte(coarse[s].tables());
        keeping = std::max(keeping, keeping_here);
        report.costs = costs_of(scene, coarse[s], report, table_costs, keeping_here);
        const SceneCost& cost = report.costs.planned;
        file.cost.light_seconds += coarse[s].light_seconds(report.plan.effects) / threads;
        file.cost.ray_seconds += 1e-9 * cost.ray_ns.median * cost.rays / threads;
        file.cost.ray_spread += 1e-9 * cost.ray_ns.spread * cost.rays / threads;
        planned.push_back(scene);
        planned.back().effects = report.plan.effects;
        file.scenes.push_back(std::move(report));
    }
    file.cost.tables = table_costs.of(planned, keeping);
    return file;
}

}  // namespace stratus
