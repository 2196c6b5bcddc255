
#include <stratus/base/argument.h>
#include <stratus/scene/contents.h>

#include "layer_fluxes.h"
#include "ring_light.h"

#include <functional>

namespace stratus {
namespace {

Opposition scene_opposition(const Scene& scene) {
    const bool on = scene.effects.opposition && scene.effects.single;
    if (!on) return {};
    return seen_opposition(scene.layer.opposition, scene.effects.density ? scene.layer.density : 0);
}

/// Whether a picture has so many samples, all of one sun, that RingOrders saves more than it costs.
bool tabulates_orders(const Scene& scene, const Rings& rings) {
    constexpr double lookups = 200;  // for each row of the profile
    const double samples = 1.0 * scene.width * scene.height * scene.samples * scene.samples;
    const bool one_sun = scene.sun_diameter == 0 || !scene.effects.sun_size;
    return one_sun && samples > lookups * static_cast<double>(rings.profile.radius.size());
}

}  // namespace

void LookupRange::add(const Matter& matter, const Geometry& geometry, Side side) {
    widen(mu_in, geometry.mu_in);
    widen(mu_out, geometry.mu_out);
    widen(azimuth, std::abs(std::remainder(geometry.azimuth, 2 * pi)) * 180 / pi);
    MatterSpan::add(matter, matter.optical_depth);
    (side == Side::reflection ? reflection : transmission) = true;
}

LayerLight::LayerLight(const Scene& scene, const LayerTables* tables, int threads,
                       LightDetail detail)
    : scene_(scene), tables_(tables), opposition_(scene_opposition(scene)) {
    if (std::optional<Scene> planet = planet_scene(scene)) {
        planet_scene_ = std::make_shared<const Scene>(std::move(*planet));
        planet_ = std::make_shared<const LayerLight>(
            *planet_scene_, tables ? tables->planet.get() : nullptr, threads, detail);
    }
    const bool needed = !needed_paths(scene).empty();
    require(!needed || tables != nullptr, "LayerLight", "tables", "there for orders n >= 2",
            "none");
    if (!needed) tables_ = nullptr;
    const LayerTable *const sunlight = table(LightPath::sunlight), *const through =
                                                                       table(LightPath::fluxes);
    if (through && seen_light(scene).fluxes)
        for (const Table& header : through->headers)
            require(!header.diffuse_transmittance.empty() ||
                        std::isinf(header.optical_depth.values[0]) ||
                        !(through->packed.has_transmission() || header.is_stack()),
                    "LayerLight", "table",
                    "one of all mu_in, whose fluxes light what lies behind the layer",
                    "one without diffuse_transmittance");
    if (!scene.layer.channels.empty()) {
        channel_scenes_ = channel_scenes(scene);
        for (std::size_t c = 0; c < channel_scenes_.size(); ++c) {
            const LayerTables* const own = tables_ ? tables_->channels[c].get() : nullptr;
            const bool as_before =
                c > 0 && channels_[c - 1]->tables_ == own &&
                are_alike(channel_scenes_[c - 1].layer, channel_scenes_[c].layer);
            channels_.push_back(as_before ? channels_[c - 1]
                                          : std::make_shared<const LayerLight>(
                                                channel_scenes_[c], own, threads, detail));
        }
        return;
    }
    background_scatters_ =
        scene.effects.background && scene.effects.transmission && scene.background.is_one_colour();
    if (background_scatters_ && (!tables_ || !scene.effects.single))
        for (const PhaseFunction& component : scene.layer.components)
            scattered_once_.emplace_back(component);
    if (through)
        fluxes_ = std::make_shared<const LayerFluxes>(through->headers, scene.layer.albedo);
    const std::optional<TableView> view =
        sunlight ? std::optional(sunlight->packed.view()) : std::nullopt;
    bind(view ? &*view : nullptr, detail);
    shine(threads, detail);
}

LayerLight::LayerLight(const Scene& scene, const TableView& table)
    : scene_(scene), tables_(nullptr), opposition_(scene_opposition(scene)) {
    bind(&table, LightDetail::fine);
}

void LayerLight::shine(int threads, LightDetail detail) {
    const Rings* const rings = scene_.subject_as<Rings>();
    if (!rings) return;
    if (table(LightPath::sunlight) && tabulates_orders(scene_, *rings)) {
        const auto orders =
            std::make_shared<const RingOrders>(scene_, *rings, *this, threads, detail);
        if (!orders->empty()) ring_orders_ = orders;
    }
    if (scene_.effects.ringshine)
        ring_shine_ = std::make_shared<const RingShine>(scene_, *rings, *this, threads, detail);
    if (scene_.effects.planetshine && !rings->has_black_planet())
        planet_shine_ = std::make_shared<const PlanetShine>(scene_, *rings, *this, threads, detail);
}

Rgb3 LayerLight::ringshine(const Vector3& point) const {
    Rgb3 sum{};
    if (ring_shine_)
        for (const LightSource& source : ring_shine_->sources(point)) sum += source.irradiance;
    return sum;
}

void LayerLight::bind(const TableView* table, LightDetail detail) {
    std::optional<Matter> matter = uniform_matter(scene_);
    // A stack's light is that of its slices alone.
    if (detail == LightDetail::sketch && !is_stack()) matter.reset();
    if (!matter) opposition_table_ = OppositionTable(opposition_);
    if (!matter || matter->optical_depth == 0) return;
    const auto depth = [&](std::size_t c) { return channel_depth(*matter, c); };
    Effects effects;
    effects.single =
        scene_.effects.single && seen_shell(scene_) == 0;  // else by planet_and_slab.cpp
    effects.multiple = table && scene_.effects.multiple;
    effects.reflection = scene_.effects.reflection;
    effects.transmission = scene_.effects.transmission;
    effects.background = is_stack() && background_scatters_;  // else LayerLight::background
    effects.opposition = opposition_;
    const auto bound = [&]<int channels>(const Medium<channels>& medium) {
        return table        ? SliceOf<channels>(*table, medium, effects)
               : is_stack() ? SliceOf<channels>(scene_.layer.stacks[0], effects)
                            : SliceOf<channels>(scene_.layer.components[0], medium, effects);
    };
    const auto& albedo = matter->albedo;
    const bool grey = depth(0) == depth(1) && depth(1) == depth(2) && albedo[0] == albedo[1] &&
                      albedo[1] == albedo[2];
    if (grey)
        slice_ = bound(Medium<1>{{depth(0)}, {albedo[0]}});
    else
        slice_ =
            bound(Medium<3>{{depth(0), depth(1), depth(2)}, {albedo[0], albedo[1], albedo[2]}});
}

double LayerLight::channel_depth(const Matter& matter, std::size_t c) const {
    return seen_depth(scene_, matter.optical_depth) * scene_.layer.extinction[c];
}

template <class Function>
Rgb3 LayerLight::each_depth(const Matter& matter, const Function& value) const {
    const auto& extinction = scene_.layer.extinction;
    Rgb3 all;
    for (std::size_t c = 0; c < all.size(); ++c)
        all[c] = c > 0 && extinction[c] == extinction[c - 1] ? all[c - 1]
                                                             : value(channel_depth(matter, c));
    return all;
}

Scattering LayerLight::scattering(Side side, const Geometry& geometry) const {
    const double cosine = cos_scattering_angle(side, geometry);
    Scattering made{side, geometry, cosine, {}};
    const auto& components = scene_.layer.components;
    if (scene_.effects.single && is_wanted(side))
        for (std::size_t k = 0; k < components.size(); ++k) made.phase[k] = components[k](cosine);
    return made;
}

double LayerLight::single(double mixture, double optical_depth,
                          const Scattering& scattering) const {
    const auto& [side, geometry, cosine, phases] = scattering;
    double phase = phases[0];
    if (scene_.layer.components.size() > 1) phase = mixture * phase + (1 - mixture) * phases[1];
    if (phase == 0) return 0;
    const double light =
        single_scattering(side, phase, 1, optical_depth, geometry.mu_in, geometry.mu_out);
    if (side == Side::transmission || !opposition_.is_present()) return light;
    return light * opposition_table_.factor(cosine, optical_depth, geometry.mu_in, geometry.mu_out);
}

Rgb3 LayerLight::multiple(const Matter& matter, const Scattering& scattering,
                          LightPath path) const {
    const LayerTable* const own = table(path);
    if (!own || !is_wanted(scattering.side) || matter.optical_depth == 0) return {};
    PackedLayers layers;
    for (std::size_t c = 0; c < 3; ++c) {
        layers.albedo[c] = matter.albedo[c];
        layers.optical_depth[c] = channel_depth(matter, c);
    }
    double value[3] = {};
    own->packed.multiple(scattering.side, layers, scattering.geometry, matter.mixture, value);
    return {value[0], value[1], value[2]};
}

Rgb3 LayerLight::once(const Matter& matter, const Scattering& scattering) const {
    if (!scene_.effects.single || !is_wanted(scattering.side) || seen_shell(scene_) > 0) return {};
    return matter.albedo * each_depth(matter, [&](double depth) {
               return depth == 0 ? 0 : single(matter.mixture, depth, scattering);
           });
}

Rgb3 LayerLight::light(const Matter& matter, const Scattering& scattering) const {
    if (!is_wanted(scattering.side) || matter.optical_depth == 0) return {};
    if (recorded_) recorded_->add(matter, scattering.geometry, scattering.side);
    return once(matter, scattering) + multiple(matter, scattering);
}

Rgb3 LayerLight::light(const Matter& matter, const Geometry& geometry, Side side) const {
    if (!is_wanted(side) || matter.optical_depth == 0) return {};
    if (recorded_) recorded_->add(matter, geometry, side);
    if (!channels_.empty()) {
        Rgb3 all;
        for (std::size_t c = 0; c < all.size(); ++c) {
            Matter own = matter;  // grey in the channel's albedo, of its depth
            own.albedo.fill(matter.albedo[c]);
            own.optical_depth *= scene_.layer.extinction[c];
            all[c] = channels_[c]->light(own, geometry, side)[c];
        }
        return all;
    }
    const auto mu_in = static_cast<float>(geometry.mu_in),
               mu_out = static_cast<float>(geometry.mu_out),
               azimuth = static_cast<float>(geometry.azimuth);
    if (const Slice* const grey = std::get_if<Slice>(&slice_)) {
        const double light = double{grey->scattering(side, mu_in, mu_out, azimuth)};
        return {light, light, light};
    }
    if (const RgbSlice* const coloured = std::get_if<RgbSlice>(&slice_))
        return widened(coloured->scattering(side, mu_in, mu_out, azimuth));
    const Scattering ready = scattering(side, geometry);
    return once(matter, ready) + multiple(matter, ready);
}

bool LayerLight::has_sums() const {
    if (recorded_) return false;
    if (channels_.empty()) return !std::holds_alternative<std::monostate>(slice_);
    return std::ranges::all_of(channels_, [](const auto& each) { return each->has_sums(); });
}

void LightSum::add(Side side, const Geometry& geometry, const Rgb3& share) {
    Batch& all = batches_[side];
    const std::size_t k = all.count++;
    all.mu_in[k] = static_cast<float>(geometry.mu_in);
    all.mu_out[k] = static_cast<float>(geometry.mu_out);
    all.azimuth[k] = static_cast<float>(geometry.azimuth);
    all.share[k] = share;
    all.sum[k] = sum_;
    if (all.count == most) look_up(side);
}

void LightSum::look_up(Side side) {
    Batch& all = batches_[side];
    if (all.count == 0) return;
    // Values of a layer's slice, into channels [begin, end) of the sums.
    const auto add_values = [&]<int channels>(const SliceOf<channels>& slice, std::size_t begin,
                                              std::size_t end) {
        std::array<float, channels * most> value;  // channel after channel
        slice.scattering(side, all.count, all.mu_in.data(), all.mu_out.data(), all.azimuth.data(),
                         value.data());
        for (std::size_t c = begin; c < end; ++c)
            for (std::size_t k = 0; k < all.count; ++k)
                (*all.sum[k])[c] +=
                    all.share[k][c] * double{value[(channels == 1 ? 0 : c * all.count) + k]};
    };
    const auto add_light = [&](const LayerLight& light, std::size_t begin, std::size_t end) {
        if (const Slice* const grey = std::get_if<Slice>(&light.slice_))
            add_values(*grey, begin, end);
        else
            add_values(std::get<RgbSlice>(light.slice_), begin, end);
    };
    if (light_.channels_.empty()) add_light(light_, 0, 3);
    const auto& channels = light_.channels_;
    for (std::size_t c = 0, end = 1; c < channels.size(); c = end++) {
        while (end < channels.size() && channels[end] == channels[c]) ++end;
        add_light(*channels[c], c, end);
    }
    all.count = 0;
}

void LightSum::finish() {
    for (const Side side : both_sides) look_up(side);
}

Rgb3 LayerLight::beam(const Matter& matter, double mu) const {
    return each_depth(matter, [&](double depth) { return direct_transmittance(depth, mu); });
}

/// Where channels find their fluxes at a cosine, one after another: what they share is found once.
class LayerLight::FluxLookup {
  public:
    const LayerFluxes::Place& place(const Channel& channel) {
        const LayerFluxes* const fluxes = channel.light.fluxes_.get();
        const bool other = fluxes != fluxes_, deeper = channel.optical_depth != optical_depth_;
        if (!other && !deeper && channel.index == index_) return place_;
        const Axis& mixtures = channel.light.table(LightPath::fluxes)->mixture;
        if (other && !mixtures.values.empty())
            place_.table = mixtures.view().stencil(channel.mixture);
        if (other) fluxes->set_cosine(place_, channel.mu);
        if (other || deeper) fluxes->set_optical_depth(place_, channel.optical_depth);
        fluxes->set_albedo(place_, channel.index, channel.albedo);
        fluxes_ = fluxes;
        optical_depth_ = channel.optical_depth;
        index_ = channel.index;
        return place_;
    }

  private:
    const LayerFluxes* fluxes_ = nullptr;  // of the last channel
    double optical_depth_ = 0;
    std::size_t index_ = 0;
    LayerFluxes::Place place_;
};

template <class Function>
auto LayerLight::each_channel(const Matter& matter, double mu, const Function& value) const {
    const auto& extinction = scene_.layer.extinction;
    std::array<std::invoke_result_t<Function, const LayerLight&, const Channel&>, 3> all{};
    FluxLookup fluxes;
    for (std::size_t c = 0; c < all.size(); ++c) {
        const LayerLight& own = channels_.empty() ? *this : *channels_[c];
        const bool as_before = channels_.empty() && c > 0 &&
                               matter.albedo[c] == matter.albedo[c - 1] &&
                               extinction[c] == extinction[c - 1];
        all[c] = as_before ? all[c - 1]
                           : std::invoke(value, own,
                                         Channel{own, c, matter.albedo[c], channel_depth(matter, c),
                                                 matter.mixture, mu, fluxes});
    }
    return all;
}

double LayerLight::transmittance(const Channel& channel) const {
    if (channel.optical_depth == 0) return 1;
    const double beam = direct_transmittance(channel.optical_depth, channel.mu);
    if (!fluxes_ || !scene_.effects.transmission) return beam;
    return beam + fluxes_->at(channel.fluxes.place(channel), LayerFluxes::diffuse_transmittance);
}

double LayerLight::spherical_albedo(const Channel& channel) const {
    if (!fluxes_ || channel.optical_depth == 0) return 0;
    if (is_stack()) return table(LightPath::fluxes)->headers[0].spherical_albedo_below;
    return fluxes_->at(channel.fluxes.place(channel), LayerFluxes::spherical_albedo);
}

double LayerLight::diffuse_transmittance(const Channel& channel) const {
    double once = 0;
    if (!scattered_once_.empty()) {
        once = scattered_once_[0](channel.optical_depth, channel.mu);
        if (scattered_once_.size() > 1)
            once = channel.mixture * once +
                   (1 - channel.mixture) * scattered_once_[1](channel.optical_depth, channel.mu);
        once *= channel.albedo;
    }
    if (!fluxes_) return scene_.effects.single ? once : 0;
    const double all =
        fluxes_->at(channel.fluxes.place(channel), LayerFluxes::diffuse_transmittance);
    return scene_.effects.single ? all : std::max(0.0, all - once);
}

double LayerLight::reflected_share(const Channel& channel) const {
    if (!fluxes_ || !scene_.effects.reflection || channel.optical_depth == 0) return 0;
    return fluxes_->at(channel.fluxes.place(channel), LayerFluxes::plane_albedo);
}

double LayerLight::passing_share(const Channel& channel) const {
    const double depth = channel.optical_depth, direct = direct_transmittance(depth, channel.mu);
    if (!background_scatters_ || depth == 0) return direct;
    const Slice* const slice = std::get_if<Slice>(&slice_);
    if (is_stack() && slice) return double{slice->background(static_cast<float>(channel.mu))};
    return depth < infinity ? std::min(1.0, direct + diffuse_transmittance(channel)) : direct;
}

Rgb3 LayerLight::background(const Matter& matter, double mu) const {
    return each_channel(matter, mu, &LayerLight::passing_share);
}

Rgb3 LayerLight::ground(const Matter& lit, double mu_in, const Rgb& ground_albedo) const {
    if (!scene_.effects.background) return {};
    struct Passed {
        double transmitted, returned;
    };
    const auto passed =
        each_channel(lit, mu_in, [](const LayerLight& light, const Channel& channel) {
            return Passed{light.transmittance(channel), light.spherical_albedo(channel)};
        });
    const Rgb3 ground = widened(ground_albedo);
    Rgb3 value{};
    for (std::size_t c = 0; c < 3; ++c)
        value[c] = ground[c] * passed[c].transmitted / (1 - ground[c] * passed[c].returned);
    return value;
}

Rgb3 LayerLight::total_transmittance(const Matter& matter, double mu) const {
    return each_channel(matter, mu, &LayerLight::transmittance);
}

Rgb3 LayerLight::plane_albedo(const Matter& matter, double mu) const {
    return each_channel(matter, mu, &LayerLight::reflected_share);
}

}  // namespace stratus
