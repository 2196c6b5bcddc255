// Reports for people on what each effect of a scene changes and costs.
#include <stratus/bake/accuracy.h>
#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/scene/contents.h>
#include <stratus/scene/render.h>

#include "render_forecast.h"

#include <cmath>
#include <utility>

namespace stratus {
namespace {

constexpr int listed_orders = 5, solved_orders = 30;  // the later ones tell how the series goes on
constexpr std::size_t order_places = 3;               // of each side, at which orders are counted

/// Returns the scene with at most so many pixels, one ray each.
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
    int pixel = 0;                // of max, row by row
    std::vector<float> relative;  // of each pixel
};

PictureChange change_between(const Image& all, const Image& some) {
    double largest = 0, light = 0, sum = 0;
    for (std::size_t k = 0; k < all.rgb.size(); k += 3) {
        largest = std::max(largest, brightest_channel(&all.rgb[k]));
        light += brightest_channel(&all.rgb[k]);
    }
    PictureChange change;
    if (largest == 0) return change;
    for (std::size_t k = 0; k < all.rgb.size(); k += 3) {
        double difference = 0;
        for (std::size_t c = k; c < k + 3; ++c)
            difference = std::max(difference, std::abs(double{all.rgb[c]} - double{some.rgb[c]}));
        sum += difference;
        const double relative =
            difference / std::max(brightest_channel(&all.rgb[k]), min_reference * largest);
        change.relative.push_back(static_cast<float>(relative));
        if (relative <= change.max) continue;
        change.max = relative;
        change.pixel = static_cast<int>(k / 3);
    }
    change.mean = sum / light;
    return change;
}

/// The effects under a point sun, which needs far fewer rays, and without what rings and their planet
/// exchange, which takes long: each of these is measured by itself.
SceneEffects plain_effects(SceneEffects effects) {
    effects.sun_size = effects.ringshine = effects.planetshine = false;
    return effects;
}

/// Sparse pictures of one scene with some of its effects, looked up in small tables.
class SparsePictures {
  public:
    SparsePictures(const Scene& scene, double pixels) : all_(scene), pixels_(pixels) {
        all_.effects.sun_size = all_.effects.sun_size && all_.sun_diameter > 0;
    }

    /// The scenes that tables have to serve: two with azimuth, for one table, and one without.
    Scenes to_bake() const {
        return {all_, with_effects(all_, without(all_.effects, &SceneEffects::density)),
                with_effects(all_, without(all_.effects, &SceneEffects::azimuth))};
    }
    void set_tables(SharedLayerTables tables, SharedLayerTables without_azimuth) {
        with_azimuth_ = std::move(tables);
        without_azimuth_ = std::move(without_azimuth);
    }
    /// Lends the light of some effects, which must outlive this, to pictures with part of what rings and
    /// their planet exchange: it takes long to make.
    void lend(const LayerLight& light) { lent_ = &light; }

    /// Made once for each set of effects.
    const Image& with(const SceneEffects& effects) {
        const auto known = std::ranges::find(made_, effects, &Made::effects);
        if (known != made_.end()) return *known->picture;
        const Scene scene = sparse(with_effects(all_, effects), pixels_);
        RenderOptions options;
        options.threads = 1;
        options.finer = false;
        const bool shines = effects.ringshine || effects.planetshine,
                   is_lent = shines && lent_ &&
                             plain_effects(effects) == plain_effects(lent_->scene().effects);
        std::optional<LayerLight> own;
        if (!is_lent) own.emplace(scene, tables(effects), 1, LightDetail::sketch);
        made_.push_back(
            {effects, std::make_unique<Image>(render(scene, is_lent ? *lent_ : *own, options))});
        return *made_.back().picture;
    }

    const Scene& scene() const { return all_; }
    const LayerTables* tables(const SceneEffects& effects) const {
        return effects.azimuth ? with_azimuth_.get() : without_azimuth_.get();
    }

  private:
    struct Made {
        SceneEffects effects;
        std::unique_ptr<const Image> picture;
    };

    Scene all_;
    double pixels_;
    SharedLayerTables with_azimuth_, without_azimuth_;
    const LayerLight* lent_ = nullptr;
    std::vector<Made> made_;
};

/// Estimates what the opposition of single scattering adds, at the smallest phase angle that is seen.
ChangeEstimate opposition_estimate(const Scene& scene) {
    ChangeEstimate change;
    if (const std::optional<Scene> planet = planet_scene(scene))
        change = opposition_estimate(*planet);
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
                change.found = change.change = share;
                change.where = "phase angle " + short_number(180 - angle, 3) +
                               " deg, optical depth " + short_number(span.optical_depth.max, 3);
            }
    return change;
}

bool is_seen(const Scene& scene, EffectFlag effect) {
    if (const std::optional<Scene> planet = planet_scene(scene))
        if (is_seen(*planet, effect)) return true;
    const SeenLight seen = seen_light(scene);
    if (effect == &SceneEffects::reflection) return seen.reflection;
    if (effect == &SceneEffects::transmission) return seen.transmission || seen.fluxes;
    if (effect == &SceneEffects::sun_size) return scene.sun_diameter > 0;
    if (effect == &SceneEffects::density) return scene.layer.density > 0;
    if (effect == &SceneEffects::azimuth) return scene.effects.multiple && seen.any();
    if (effect == &SceneEffects::shadows) return scene.subject_as<Rings>() != nullptr;
    if (effect == &SceneEffects::ringshine || effect == &SceneEffects::planetshine)
        return seen.shine;
    if (effect == &SceneEffects::shell) return seen_shell(scene) > 0;
    if (effect == &SceneEffects::opposition)
        return seen.reflection && scene.layer.opposition.is_present();
    return true;
}

/// Pictures with and without an effect.
PictureChange effect_change(EffectFlag effect, SparsePictures& pictures) {
    SceneEffects effects = plain_effects(pictures.scene().effects);
    const Image& plain = pictures.with(effects);
    if (effect == &SceneEffects::sun_size) {
        effects.sun_size = true;
        return change_between(pictures.with(effects), plain);
    }
    if (effect == &SceneEffects::ringshine || effect == &SceneEffects::planetshine) {
        SceneEffects shining = pictures.scene().effects;
        shining.sun_size = false;
        return change_between(pictures.with(shining), pictures.with(without(shining, effect)));
    }
    const PictureChange change = change_between(plain, pictures.with(without(effects, effect)));
    if (change.max > 0 || !seen_light(pictures.scene()).shine) return change;
    // It may show in what rings and their planet exchange alone.
    const bool rings = pictures.scene().effects.ringshine;
    effects.*(rings ? &SceneEffects::ringshine : &SceneEffects::planetshine) = true;
    return change_between(pictures.with(effects), pictures.with(without(effects, effect)));
}

std::vector<EffectShare> effect_shares(SparsePictures& pictures, const Plan& plan) {
    const Scene& scene = pictures.scene();
    const int width = pictures.with(plain_effects(scene.effects)).width;
    std::vector<EffectShare> shares;
    for (const auto& [name, effect] : scene_effects()) {
        if (!(scene.effects.*effect)) continue;
        EffectShare& share = shares.emplace_back();
        share.name = name;
        share.effect = effect;
        share.seen = is_seen(scene, effect);
        share.fate = share.seen ? "kept" : "not seen";
        if (!share.seen) continue;
        const PictureChange change = effect_change(effect, pictures);
        share.mean = change.mean;
        share.max = change.max;
        share.changes = change.relative;
        if (change.max > 0)
            share.where = "pixel (" + std::to_string(change.pixel % width) + ", " +
                          std::to_string(change.pixel / width) + ") of the sparse picture";
        std::optional<ChangeEstimate> estimate;
        if (effect == &SceneEffects::opposition) estimate = opposition_estimate(scene);
        for (const LeftOut& left : plan.left_out)
            if (left.name == name) estimate = left.change;
        if (estimate) {
            share.estimated = true;
            share.max = estimate->change;
            share.where = estimate->where;
        }
        if (std::ranges::find(scene.named, effect) != scene.named.end())
            share.fate = "kept, being named";
        if (!(plan.effects.*effect)) share.fate = "left out";
    }
    return shares;
}

// ---- orders -------------------------------------------------------------------------------------

/// The layer as one ray of the sparse picture sees it.
struct SeenPlace {
    Geometry geometry;
    double albedo, optical_depth, mixture;
    double light;  // R or T
};

/// The places on the lit and on the unlit side that rays of a scene see under a point sun, each with
/// its light.
PerSide<std::vector<SeenPlace>> seen_places(const Scene& scene, const LayerTables* tables) {
    LayerLight light(scene, tables, 1, LightDetail::sketch);
    const PictureRays rays(scene.camera, scene.width, scene.height);
    PerSide<std::vector<SeenPlace>> places;
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x) {
            LookupRange seen;
            light.record(&seen);
            radiance_along(scene, light, rays.through(x + 0.5, y + 0.5), scene.to_sun);
            light.record(nullptr);
            const Geometry at{seen.mu_in.max, seen.mu_out.max, radians(seen.azimuth.max)};
            const Matter matter{seen.optical_depth.max,
                                {seen.albedo.max, seen.albedo.max, seen.albedo.max},
                                seen.mixture.max};
            const auto add = [&](Side side) {
                const double sent = light.light(matter, at, side)[1];
                if (sent > 0)
                    places[side].push_back({at, seen.albedo.max,
                                            seen_depth(scene, seen.optical_depth.max),
                                            seen.mixture.max, sent});
            };
            if (seen.reflection) add(Side::reflection);
            if (seen.transmission) add(Side::transmission);
        }
    return places;
}

/// A few places that stand for equal parts of all light.
std::vector<SeenPlace> places_of_equal_light(const std::vector<SeenPlace>& places) {
    double light = 0, sum = 0;
    for (const SeenPlace& place : places) light += place.geometry.mu_in * place.light;
    std::vector<SeenPlace> chosen;
    for (const SeenPlace& place : places) {
        sum += place.geometry.mu_in * place.light;
        if (sum > light * (static_cast<double>(chosen.size()) + 0.5) / order_places)
            chosen.push_back(place);
    }
    return chosen;
}

std::string range_text(const std::string& name, const std::vector<SeenPlace>& places,
                       double Geometry::*cosine) {
    Range range{infinity, -infinity};
    for (const SeenPlace& place : places) widen(range, place.geometry.*cosine);
    return name + " " + short_number(range.min, 3) +
           (range.min == range.max ? "" : " to " + short_number(range.max, 3));
}

std::vector<OrderReport> order_reports(const Scene& whole, const LayerTables* tables) {
    std::vector<OrderReport> orders;
    if (!tables || !whole.effects.single || seen_shell(whole) > 0 || !whole.layer.stacks.empty())
        return orders;
    // Where three channels have phase functions of their own, green stands for all.
    const bool has_channels = !whole.layer.channels.empty();
    const Scene scene = has_channels ? channel_scenes(whole)[1] : whole;
    if (has_channels) tables = tables->channels[1].get();
    const auto seen = seen_places(scene, tables);
    for (const Side side : both_sides) {
        const auto places = places_of_equal_light(seen[side]);
        if (places.empty()) continue;
        const SeenPlace& middle = places[places.size() / 2];
        std::vector<WeightedGeometry> directions;
        for (const SeenPlace& place : places)
            directions.push_back({place.geometry, 1 / place.light});
        const auto& parts = scene.layer.components;
        OrderReport report{side, {}, 0, ""};
        report.share = order_shares(
            parts.size() < 2 ? parts[0]
                             : PhaseFunction::mixture(middle.mixture, parts[0], parts[1]),
            middle.albedo, middle.optical_depth, side, directions, solved_orders);
        report.enough = orders_for(report.share, scene.tolerance);
        report.share.resize(listed_orders);
        report.where = joined({"optical depth " + short_number(middle.optical_depth, 3),
                               "albedo " + short_number(middle.albedo, 3),
                               range_text("mu_in", places, &Geometry::mu_in),
                               range_text("mu_out", places, &Geometry::mu_out)});
        orders.push_back(std::move(report));
    }
    return orders;
}

}  // namespace

SharedLayerTable small_table(const Recipe& recipe) {
    Recipe small = recipe;
    Discretisation& d = small.discretisation;
    const bool peaked = is_peaked(recipe.phase_function), has_azimuth = d.modes != 1;
    small.leaves_path_law = small.exact_fluxes = false;
    small.tolerance = std::max(recipe.tolerance, 0.01);  // no finer than so few nodes
    d.nodes = peaked ? 12 : 8;
    d.mu_samples = 10;
    if (has_azimuth) {
        d.modes = peaked ? 8 : 6;
        d.azimuth_samples = 9;
        d.azimuth_scale = AxisScale::linear;
    }
    d.optical_depth_samples_per_octave = 1;
    d.albedo_samples = 3;
    d.albedo_scale = AxisScale::square_root_of_complement;
    d.family_samples.fill(2);
    if (std::isinf(recipe.optical_depth.max) && !std::isinf(recipe.optical_depth.min))
        d.deepest_optical_depth = std::ldexp(
            recipe.optical_depth.min,
            static_cast<int>(std::ceil(std::log2(std::max(
                2.0, 20 / (1 - recipe.phase_function.asymmetry()) / recipe.optical_depth.min)))));
    return make_layer_table(PackedTable(pack(solve_table(small))));
}

FileReport report_plans(const Scenes& scenes, const BakeOptions& options, TableCache* cache,
                        double pixels, const Scenes& later) {
    FileReport file;
    std::vector<SparsePictures> pictures;
    Scenes planned, to_bake;
    for (const Scene& scene : scenes) {
        PlanReport& report = file.scenes.emplace_back();
        std::vector<const Scene*> frames{&scene};
        for (std::size_t k = file.scenes.size() - 1; k < later.size(); k += scenes.size())
            frames.push_back(&later[k]);
        report.plan = plan_frames(frames);
        planned.push_back(with_effects(scene, report.plan.effects));
        pictures.emplace_back(scene, pixels);
        for (Scene& each : pictures.back().to_bake()) to_bake.push_back(std::move(each));
    }
    for (std::size_t k = 0; k < later.size(); ++k)
        leave_out(file.scenes[k % scenes.size()].plan, planned.emplace_back(later[k]));
    RenderForecast forecast(planned, options, cache);
    const auto tables = make_tables(to_bake, small_table);
    const std::size_t each = scenes.empty() ? 0 : tables.size() / scenes.size();
    for (std::size_t s = 0; s < scenes.size(); ++s) {
        PlanReport& report = file.scenes[s];
        pictures[s].set_tables(tables[s * each], tables[(s + 1) * each - 1]);
        pictures[s].lend(forecast.add_rays(planned[s], pictures[s].tables(planned[s].effects)));
        report.shares = effect_shares(pictures[s], report.plan);
        forecast.add_table_costs(scenes[s], report.shares);
        const SceneEffects plain = plain_effects(scenes[s].effects);
        report.picture = pictures[s].with(plain);
        const Scene few = sparse(with_effects(scenes[s], plain), few_pixels);
        report.orders = order_reports(few, pictures[s].tables(scenes[s].effects));
    }
    file.cost = forecast.cost();
    if (cache) std::swap(file.kept_seconds, file.cost.tables.choose_seconds);
    return file;
}

}  // namespace stratus
