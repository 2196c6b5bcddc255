#include <stratus/scene/layer_light.h>

#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/single_scattering.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

Rgb3 widened(const Rgb& value) { return {double{value.r}, double{value.g}, double{value.b}}; }

/// `value_of(c)` for each channel, evaluated once where neighbours have the same albedo.
template <class Function>
Rgb3 each_channel(const std::array<double, 3>& albedo, const Function& value_of) {
    Rgb3 value;
    for (std::size_t c = 0; c < 3; ++c)
        value[c] = c > 0 && albedo[c] == albedo[c - 1] ? value[c - 1] : value_of(c);
    return value;
}

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

LayerLight::LayerLight(const Scene& scene, const LayerTables* tables)
    : scene_(scene), tables_(tables), opposition_(opposition_of(scene)) {
    const bool needed = needed_recipe(scene).has_value();
    require(!needed || tables != nullptr, "LayerLight", "tables", "there for orders n >= 2",
            "none");
    if (!needed) tables_ = nullptr;
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
}

LayerLight::LayerLight(const Scene& scene, const TableView& table)
    : scene_(scene), tables_(nullptr), opposition_(opposition_of(scene)) {
    bind(&table, scene.effects.multiple);
}

void LayerLight::bind(const TableView* table, bool multiple) {
    const std::optional<Matter> matter = uniform_matter(scene_);
    if (!matter) opposition_table_ = OppositionTable(opposition_);
    if (!matter || matter->optical_depth == 0) return;
    const double depth = seen_depth(scene_, matter->optical_depth);
    const Medium<3> medium{{depth, depth, depth},
                           {matter->albedo[0], matter->albedo[1], matter->albedo[2]}};
    Effects effects;
    effects.single = scene_.effects.single;
    effects.multiple = multiple;
    effects.reflection = scene_.effects.reflection;
    effects.transmission = scene_.effects.transmission;
    effects.background = false;  // see LayerLight::background
    effects.opposition = opposition_;
    if (table)
        slice_.emplace(*table, medium, effects);
    else
        slice_.emplace(scene_.layer.components[0], medium, effects);
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
    const double depth = seen_depth(scene_, matter.optical_depth);
    const double cosine = reflected ? cos_scattering_angle_reflected(geometry)
                                    : cos_scattering_angle_transmitted(geometry);
    const auto& components = scene_.layer.components;
    double single = 0;  // of albedo 1
    if (scene_.effects.single) {
        double phase = components[0](cosine);
        if (components.size() > 1)
            phase = matter.mixture * phase + (1 - matter.mixture) * components[1](cosine);
        single = reflected
                     ? single_reflection(phase, 1, depth, geometry.mu_in, geometry.mu_out) *
                           opposition_table_.factor(cosine, depth, geometry.mu_in, geometry.mu_out)
                     : single_transmission(phase, 1, depth, geometry.mu_in, geometry.mu_out);
    }
    Stencil mixture{0, {1, 0, 0, 0}};
    if (tables_ && !tables_->mixture.values.empty())
        mixture = tables_->mixture.view().stencil(matter.mixture);
    return each_channel(matter.albedo, [&](std::size_t c) {
        double value = matter.albedo[c] * single;
        for (int k = 0; tables_ && k < stencil_size; ++k) {
            const double share = double{mixture.weight[k]};
            if (share == 0) continue;
            const TexturedTable& table =
                tables_->textured[static_cast<std::size_t>(mixture.first + k)];
            value += share * (reflected ? table.reflection(matter.albedo[c], depth, geometry)
                                        : table.transmission(matter.albedo[c], depth, geometry))
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

double LayerLight::beam(const Matter& matter, double mu) const noexcept {
    return matter.optical_depth == 0
               ? 1
               : direct_transmittance(seen_depth(scene_, matter.optical_depth), mu);
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
    const double beam = direct_transmittance(optical_depth, mu);
    if (!tables_ || !scene_.effects.transmission) return beam;
    const Table& table = tables_->tables[0];
    if (table.diffuse_transmittance.empty()) return beam;
    const Stencil stencil = table.mu_in.view().stencil(mu);
    return beam + flux(table, table.diffuse_transmittance, albedo, optical_depth, &stencil);
}

double LayerLight::spherical_albedo(double albedo, double optical_depth) const noexcept {
    if (!tables_) return 0;
    const Table& table = tables_->tables[0];
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

Rgb3 LayerLight::background(const Matter& matter, double mu) const noexcept {
    if (!channels_.empty())
        return of_channels([&](const LayerLight& light, std::size_t c) {
            return light.background(channel_matter(matter, c), mu);
        });
    const double direct = beam(matter, mu), depth = seen_depth(scene_, matter.optical_depth);
    const bool scatters = background_scatters_ && depth > 0 && depth < infinity;
    return each_channel(matter.albedo, [&](std::size_t c) {
        return scatters ? std::min(1.0, direct + diffuse_transmittance(matter, matter.albedo[c],
                                                                       depth, mu))
                        : direct;
    });
}

Rgb3 LayerLight::ground(const Matter& lit, double mu_in, const Matter& seen, double mu_out,
                        const Rgb& ground_albedo) const noexcept {
    if (!scene_.effects.background) return {};
    if (!channels_.empty())
        return of_channels([&](const LayerLight& light, std::size_t c) {
            return light.ground(channel_matter(lit, c), mu_in, channel_matter(seen, c), mu_out,
                                ground_albedo);
        });
    const double lit_depth = seen_depth(scene_, lit.optical_depth),
                 seen_through = seen_depth(scene_, seen.optical_depth);
    struct Channel {
        double transmittance, spherical_albedo;  // on the way in and out; of the layer
    };
    std::array<Channel, 3> channel;
    for (std::size_t c = 0; c < 3; ++c) {
        if (c > 0 && lit.albedo[c] == lit.albedo[c - 1]) {
            channel[c] = channel[c - 1];
            continue;
        }
        auto transmitted = [&](double depth, double mu) {
            return depth == 0 ? 1 : transmittance(lit.albedo[c], depth, mu);
        };
        channel[c] = {transmitted(lit_depth, mu_in) * transmitted(seen_through, mu_out),
                      lit_depth == 0 ? 0 : spherical_albedo(lit.albedo[c], lit_depth)};
    }
    const double albedo[] = {double{ground_albedo.r}, double{ground_albedo.g},
                             double{ground_albedo.b}};
    Rgb3 value;
    for (std::size_t c = 0; c < 3; ++c)
        value[c] =
            albedo[c] * channel[c].transmittance / (1 - albedo[c] * channel[c].spherical_albedo);
    return value;
}

}  // namespace stratus
