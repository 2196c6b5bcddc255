#include <stratus/scene/layer_light.h>

#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/single_scattering.h>
#include <stratus/scene/contents.h>

#include "planet_shine.h"
#include "ring_shine.h"

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

Rgb3 widened(const Rgb& value) { return {double{value.r}, double{value.g}, double{value.b}}; }

Opposition opposition_of(const Scene& scene) {
    const bool on = scene.effects.opposition && scene.effects.single;
    if (!on) return {};
    return seen_opposition(scene.layer.opposition, scene.effects.density ? scene.layer.density : 0);
}

}  // namespace

void LookupRange::add(const Matter& matter, const Geometry& geometry, Side side) noexcept {
    widen(mu_in, geometry.mu_in);
    widen(mu_out, geometry.mu_out);
    widen(azimuth, std::abs(std::remainder(geometry.azimuth, 2 * pi)) * 180 / pi);
    widen(optical_depth, matter.optical_depth);
    for (const double each : matter.albedo) widen(albedo, each);
    (side == Side::reflection ? reflection : transmission) = true;
}

LayerLight::LayerLight(const Scene& scene, const LayerTables* tables, int threads)
    : scene_(scene), tables_(tables), opposition_(opposition_of(scene)) {
    const bool needed = needed_recipe(scene).has_value();
    require(!needed || tables != nullptr, "LayerLight", "tables", "there for orders n >= 2",
            "none");
    if (!needed) tables_ = nullptr;
    if (tables_ && seen_light(scene).fluxes)
        for (const Table& table : tables_->tables)
            require(table.transmission_multiple.empty() || !table.diffuse_transmittance.empty(),
                    "LayerLight", "table",
                    "one of all mu_in, whose fluxes light what lies behind the layer",
                    "one without diffuse_transmittance");
    if (!scene.layer.channels.empty()) {
        channel_scenes_ = channel_scenes(scene);
        for (std::size_t c = 0; c < channel_scenes_.size(); ++c)
            channels_.emplace_back(channel_scenes_[c],
                                   tables_ ? tables_->channels[c].get() : nullptr);
        return;
    }
    const bool background_scatters = scene.effects.background && scene.effects.transmission &&
                                     scene.background.pattern == Texture::Pattern::plain &&
                                     !scene.background.is_black();
    if (background_scatters && (!tables_ || !scene.effects.single))
        for (const PhaseFunction& component : scene.layer.components)
            scattered_once_.emplace_back(component);
    background_scatters_ = background_scatters;
    std::optional<TableView> table;
    if (tables_) table = tables_->tables[0].view();
    bind(table ? &*table : nullptr, needed);
    shine(threads);
}

LayerLight::LayerLight(const Scene& scene, const TableView& table)
    : scene_(scene), tables_(nullptr), opposition_(opposition_of(scene)) {
    bind(&table, scene.effects.multiple);
}

void LayerLight::shine(int threads) {
    const Rings* const rings = std::get_if<Rings>(&scene_.subject);
    if (!rings) return;
    if (scene_.effects.ringshine) {
        Scene scattering = scene_;
        scattering.effects.opposition = false;
        scattering.effects.ringshine = scattering.effects.planetshine = false;
        const LayerLight light(scattering, tables_);
        ring_shine_ = std::make_shared<const RingShine>(scattering, *rings, light, threads);
    }
    if (scene_.effects.planetshine && !rings->surface.is_black())
        planet_shine_ =
            std::make_shared<const PlanetShine>(scene_, *rings, *this, tables_, threads);
}

Rgb3 LayerLight::ringshine(const Vector3& point) const noexcept {
    return ring_shine_ ? ring_shine_->irradiance(point) : Rgb3{};
}

void LayerLight::bind(const TableView* table, bool multiple) {
    const std::optional<Matter> matter = uniform_matter(scene_);
    if (!matter) opposition_table_ = OppositionTable(opposition_);
    if (!matter || matter->optical_depth == 0) return;
    const auto depth = [&](std::size_t c) { return seen_depth_of(*matter, c); };
    const Medium<3> medium{{depth(0), depth(1), depth(2)},
                           {matter->albedo[0], matter->albedo[1], matter->albedo[2]}};
    Effects effects;
    effects.single = scene_.effects.single;
    effects.multiple = multiple;
    effects.reflection = scene_.effects.reflection;
    effects.transmission = scene_.effects.transmission;
    effects.background = is_stack() && background_scatters_;  // else LayerLight::background
    effects.opposition = opposition_;
    if (table)
        slice_.emplace(*table, medium, effects);
    else if (is_stack())
        slice_.emplace(scene_.layer.stack, effects);
    else
        slice_.emplace(scene_.layer.components[0], medium, effects);
}

double LayerLight::seen_depth_of(const Matter& matter, std::size_t c) const noexcept {
    return seen_depth(scene_, matter.optical_depth) * scene_.layer.extinction[c];
}

template <class Function>
Rgb3 LayerLight::each_channel(const Matter& matter, const Function& of) const noexcept {
    const auto& extinction = scene_.layer.extinction;
    Rgb3 value{};
    for (std::size_t c = 0; c < 3; ++c) {
        const LayerLight& own = channels_.empty() ? *this : channels_[c];
        const bool as_before = channels_.empty() && c > 0 &&
                               matter.albedo[c] == matter.albedo[c - 1] &&
                               extinction[c] == extinction[c - 1];
        value[c] = as_before ? value[c - 1] : of(own, matter.albedo[c], seen_depth_of(matter, c));
    }
    return value;
}

template <class Function>
Rgb3 LayerLight::of_channels(const Function& of) const noexcept {
    Rgb3 value;
    for (std::size_t c = 0; c < value.size(); ++c) value[c] = of(channels_[c], c)[c];
    return value;
}

Matter LayerLight::channel_matter(const Matter& matter, std::size_t c) const noexcept {
    Matter own = matter;
    own.albedo.fill(matter.albedo[c]);
    own.optical_depth *= scene_.layer.extinction[c];
    return own;
}

Rgb3 LayerLight::textured_light(const Matter& matter, const Geometry& geometry,
                                Side side) const noexcept {
    const bool reflected = side == Side::reflection;
    const double cosine = reflected ? cos_scattering_angle_reflected(geometry)
                                    : cos_scattering_angle_transmitted(geometry);
    const auto& components = scene_.layer.components;
    double phase = 0;
    if (scene_.effects.single) {
        phase = components[0](cosine);
        if (components.size() > 1)
            phase = matter.mixture * phase + (1 - matter.mixture) * components[1](cosine);
    }
    const auto single_of = [&](double depth) {  // of albedo 1
        return reflected
                   ? single_reflection(phase, 1, depth, geometry.mu_in, geometry.mu_out) *
                         opposition_table_.factor(cosine, depth, geometry.mu_in, geometry.mu_out)
                   : single_transmission(phase, 1, depth, geometry.mu_in, geometry.mu_out);
    };
    double single_depth = 0, single = 0;  // of the last channel
    Stencil mixture{0, {1, 0, 0, 0}};
    if (tables_ && !tables_->mixture.values.empty())
        mixture = tables_->mixture.view().stencil(matter.mixture);
    return each_channel(matter, [&](const LayerLight&, double albedo, double depth) {
        if (depth == 0) return 0.0;
        if (scene_.effects.single && depth != single_depth) {
            single_depth = depth;
            single = single_of(depth);
        }
        double value = albedo * single;
        for (int k = 0; tables_ && k < stencil_size; ++k) {
            const double share = double{mixture.weight[k]};
            if (share == 0) continue;
            const TexturedTable& table =
                tables_->textured[static_cast<std::size_t>(mixture.first + k)];
            value += share * (reflected ? table.reflection(albedo, depth, geometry)
                                        : table.transmission(albedo, depth, geometry))
                                 .multiple;
        }
        return value;
    });
}

Rgb3 LayerLight::light(const Matter& matter, const Geometry& geometry, Side side) const noexcept {
    const bool reflected = side == Side::reflection;
    const bool wanted = reflected ? scene_.effects.reflection : scene_.effects.transmission;
    if (!wanted || matter.optical_depth == 0) return {};
    if (recorded_) recorded_->add(matter, geometry, side);
    if (!channels_.empty())
        return of_channels([&](const LayerLight& light, std::size_t c) {
            return light.light(channel_matter(matter, c), geometry, side);
        });
    if (!slice_) return textured_light(matter, geometry, side);
    const auto mu_in = static_cast<float>(geometry.mu_in),
               mu_out = static_cast<float>(geometry.mu_out),
               azimuth = static_cast<float>(geometry.azimuth);
    return widened(reflected ? slice_->reflection(mu_in, mu_out, azimuth)
                             : slice_->transmission(mu_in, mu_out, azimuth));
}

Rgb3 LayerLight::beam(const Matter& matter, double mu) const noexcept {
    return each_channel(matter, [&](const LayerLight&, double, double depth) {
        return direct_transmittance(depth, mu);
    });
}

double LayerLight::flux(const Table& table, const std::vector<float>& flux, double albedo,
                        double optical_depth, const Stencil* mu) const noexcept {
    const AxisView albedos = table.albedo.view(), depths = table.optical_depth.view();
    const std::size_t mus = mu ? table.mu_in.values.size() : 1;
    const auto depth_count = static_cast<std::size_t>(depths.size());
    auto at = [&](int a, int d) {
        const std::size_t row =
            (static_cast<std::size_t>(std::min(a, albedos.count - 1)) * depth_count +
             static_cast<std::size_t>(d)) *
            mus;
        if (!mu) return double{flux[row]};
        double sum = 0;
        for (int i = 0; i < stencil_size; ++i)
            if (mu->weight[i] != 0)
                sum += double{mu->weight[i]} *
                       double{flux[row + static_cast<std::size_t>(mu->first + i)]};
        return sum;
    };
    const Stencil in_albedo = albedos.stencil(albedo);
    double sum = 0;
    for (int a = 0; a < stencil_size; ++a) {
        if (in_albedo.weight[a] == 0) continue;
        const double share = double{in_albedo.weight[a]};
        if (depths.count == 0 || std::isinf(optical_depth)) {
            sum += share * at(in_albedo.first + a, depths.size() - 1);
            continue;
        }
        const Stencil in_depth = depths.stencil(optical_depth);
        for (int d = 0; d < stencil_size; ++d)
            if (in_depth.weight[d] != 0)
                sum += share * double{in_depth.weight[d]} *
                       at(in_albedo.first + a, in_depth.first + d);
    }
    // Thinner than the table: proportional to the depth.
    if (depths.count > 0 && optical_depth < depths.lowest) sum *= optical_depth / depths.lowest;
    return sum;
}

double LayerLight::transmittance(double albedo, double optical_depth, double mu) const noexcept {
    if (optical_depth == 0) return 1;
    const double beam = direct_transmittance(optical_depth, mu);
    if (!tables_ || !scene_.effects.transmission) return beam;
    const Table& table = tables_->tables[0];
    if (table.diffuse_transmittance.empty()) return beam;
    const Stencil stencil = table.mu_in.view().stencil(mu);
    return beam + flux(table, table.diffuse_transmittance, albedo, optical_depth, &stencil);
}

double LayerLight::spherical_albedo(double albedo, double optical_depth) const noexcept {
    if (!tables_ || optical_depth == 0) return 0;
    const Table& table = tables_->tables[0];
    if (table.is_stack()) return table.spherical_albedo_below;
    return flux(table, table.spherical_albedo, albedo, optical_depth, nullptr);
}

double LayerLight::diffuse_transmittance(const Matter& matter, double albedo, double optical_depth,
                                         double mu) const noexcept {
    double once = 0;
    if (!scattered_once_.empty()) {
        once = scattered_once_[0](optical_depth, mu);
        if (scattered_once_.size() > 1)
            once = matter.mixture * once +
                   (1 - matter.mixture) * scattered_once_[1](optical_depth, mu);
        once *= albedo;
    }
    if (!tables_) return scene_.effects.single ? once : 0;
    Stencil mixture{0, {1, 0, 0, 0}};
    if (!tables_->mixture.values.empty()) mixture = tables_->mixture.view().stencil(matter.mixture);
    double all = 0;
    for (int k = 0; k < stencil_size; ++k) {
        if (mixture.weight[k] == 0) continue;
        const Table& table = tables_->tables[static_cast<std::size_t>(mixture.first + k)];
        if (table.diffuse_transmittance.empty()) continue;
        const Stencil cosine = table.mu_in.view().stencil(mu);
        all += double{mixture.weight[k]} *
               flux(table, table.diffuse_transmittance, albedo, optical_depth, &cosine);
    }
    return scene_.effects.single ? all : std::max(0.0, all - once);
}

double LayerLight::plane_albedo(double albedo, double optical_depth, double mu) const noexcept {
    if (!tables_ || !scene_.effects.reflection || optical_depth == 0) return 0;
    const Table& table = tables_->tables[0];
    if (table.plane_albedo.empty()) return 0;
    const Stencil stencil = table.mu_in.view().stencil(mu);
    return flux(table, table.plane_albedo, albedo, optical_depth, &stencil);
}

Rgb3 LayerLight::background(const Matter& matter, double mu) const noexcept {
    if (slice_ && is_stack() && background_scatters_ && matter.optical_depth > 0)
        return widened(slice_->background(static_cast<float>(mu)));
    return each_channel(matter, [&](const LayerLight& light, double albedo, double depth) {
        const double direct = direct_transmittance(depth, mu);
        return light.background_scatters_ && depth > 0 && depth < infinity
                   ? std::min(1.0, direct + light.diffuse_transmittance(matter, albedo, depth, mu))
                   : direct;
    });
}

Rgb3 LayerLight::ground(const Matter& lit, double mu_in, const Rgb& ground_albedo) const noexcept {
    if (!scene_.effects.background) return {};
    const Rgb3 transmitted =
        each_channel(lit, [&](const LayerLight& light, double albedo, double depth) {
            return light.transmittance(albedo, depth, mu_in);
        });
    const Rgb3 returned =
        each_channel(lit, [&](const LayerLight& light, double albedo, double depth) {
            return light.spherical_albedo(albedo, depth);
        });
    const double ground[] = {double{ground_albedo.r}, double{ground_albedo.g},
                             double{ground_albedo.b}};
    Rgb3 value{};
    for (std::size_t c = 0; c < 3; ++c)
        value[c] = ground[c] * transmitted[c] / (1 - ground[c] * returned[c]);
    return value;
}

Rgb3 LayerLight::total_transmittance(const Matter& matter, double mu) const noexcept {
    return each_channel(matter, [&](const LayerLight& light, double albedo, double depth) {
        return light.transmittance(albedo, depth, mu);
    });
}

Rgb3 LayerLight::plane_albedo(const Matter& matter, double mu) const noexcept {
    return each_channel(matter, [&](const LayerLight& light, double albedo, double depth) {
        return light.plane_albedo(albedo, depth, mu);
    });
}

}  // namespace stratus
