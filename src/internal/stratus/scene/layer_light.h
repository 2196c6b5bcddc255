// The light of a scene's layer at any of its points, with the scene's effects: by a slice where the
// layer is uniform, by packed tables where it varies; single scattering in closed form.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/bsdf/slice.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/scene/layer_tables.h>

namespace stratus {

/// The lookups of a picture in its layer: directions, matter and sides.
struct LookupRange : MatterSpan {
    Range mu_in{1, 0}, mu_out{1, 0}, azimuth{180, 0};  // degrees
    bool reflection = false, transmission = false;

    void add(const Matter& matter, const Geometry& geometry, Side side);
};

/// Directions of one scattering in a layer that varies, with all that does not depend on its matter.
struct Scattering {
    Side side = Side::reflection;
    Geometry geometry{};
    double cosine = 0;              // of the scattering angle
    std::array<double, 2> phase{};  // of each component; 0 where single scattering is left out
};

/// How a layer's light is prepared: for pictures, or, without slices and with coarse grids, for the few
/// rays of a plan.
enum class LightDetail { fine, sketch };

/// About how many times as long the former takes where rings and their planet light one another.
constexpr double fine_over_sketch = 16;

/// A part of what lights a surface.
struct LightSource {
    Vector3 direction{0, 0, 0};  // towards it, of any length: a sum, weighted by brightness
    Rgb3 irradiance{};           // over the sun's on a surface that faces it

    friend LightSource operator+(const LightSource& a, const LightSource& b) {
        return {a.direction + b.direction, a.irradiance + b.irradiance};
    }
    friend LightSource& operator+=(LightSource& sum, const LightSource& source) {
        return sum = sum + source;
    }
    friend LightSource operator*(double factor, const LightSource& source) {
        return {factor * source.direction, factor * source.irradiance};
    }
};

class LayerFluxes;
class RingOrders;
class RingShine;
class PlanetShine;

class LayerLight {
  public:
    /// `tables` is null where none is needed. Both must outlive this.
    ///
    /// Cost     of rings and a planet that light one another: up to a second, and as a sketch a sixteenth of it.
    /// Threads  that many; 0: all.
    /// Errors   std::invalid_argument for orders n >= 2 without a table.
    LayerLight(const Scene& scene, const LayerTables* tables, int threads = 0,
               LightDetail detail = LightDetail::fine);

    /// A uniform layer with the table's phase function and lower boundary, in a scene without
    /// ground.
    LayerLight(const Scene& scene, const TableView& table);

    /// R or diffuse T. `matter` is the scene's, without the effect of density.
    Rgb3 light(const Matter& matter, const Geometry& geometry, Side side) const;
    Rgb3 reflection(const Matter& matter, const Geometry& geometry) const {
        return light(matter, geometry, Side::reflection);
    }
    Rgb3 transmission(const Matter& matter, const Geometry& geometry) const {
        return light(matter, geometry, Side::transmission);
    }

    // Counterparts for a layer that varies, whose colours share their phase functions.

    Scattering scattering(Side side, const Geometry& geometry) const;
    Rgb3 light(const Matter& matter, const Scattering& scattering) const;
    /// Scattered once by matter of albedo 1 and a depth as seen.
    double single(double mixture, double optical_depth, const Scattering& scattering) const;
    Rgb3 once(const Matter& matter, const Scattering& scattering) const;
    /// Orders n >= 2, of the table for a light path.
    Rgb3 multiple(const Matter& matter, const Scattering& scattering,
                  LightPath path = LightPath::sunlight) const;

    /// Whether the scene has light of that side.
    bool is_wanted(Side side) const {
        return side == Side::reflection ? scene_.effects.reflection : scene_.effects.transmission;
    }

    /// The depth that one channel sees.
    double channel_depth(const Matter& matter, std::size_t c) const;

    /// Whether a LightSum finds this layer's light: that of a uniform layer.
    bool has_sums() const;

    /// exp(-tau / mu).
    Rgb3 beam(const Matter& matter, double mu) const;

    /// Share of the scene's background that is seen through the layer: the beam, and of a background
    /// of one colour the diffuse transmittance. What patterns and images give scattered is left out.
    Rgb3 background(const Matter& matter, double mu) const;

    // A Lambert surface below the layer, interreflections included. It is lit through `lit`: exact
    // where the layer is the same all over. Without orders n >= 2 the beam alone is transmitted, and
    // nothing is reflected back to the ground.

    /// pi I / F0 of the ground over mu_in: A t(mu_in) / (1 - A s), t the direct and diffuse
    /// transmittance, s the layer's spherical albedo.
    Rgb3 ground(const Matter& lit, double mu_in, const Rgb& ground_albedo) const;

    /// Share of the ground's radiance that is seen from above through the layer: direct and diffuse
    /// transmittance.
    Rgb3 total_transmittance(const Matter& matter, double mu) const;

    /// Share of the ground's radiance that the layer's underside reflects down along `mu`.
    Rgb3 plane_albedo(const Matter& matter, double mu) const;

    /// Irradiance of a point of the globe by its rings, over the sun's on a surface that faces it.
    Rgb3 ringshine(const Vector3& point) const;

    /// Null where the globe is not lit by its rings.
    const RingShine* ring_shine() const { return ring_shine_.get(); }

    /// Light of the layer of the rings' planet; null where that is bare.
    const LayerLight* planet() const { return planet_.get(); }

    const Scene& scene() const { return scene_; }

    /// Null where rings' orders n >= 2 are not tabulated for the camera.
    const RingOrders* ring_orders() const { return recorded_ ? nullptr : ring_orders_.get(); }

    /// Null where a planet does not light its rings.
    const PlanetShine* planetshine() const { return planet_shine_.get(); }

    /// Records later lookups in `range`, which one thread at a time may do.
    void record(LookupRange* range) { recorded_ = range; }

  private:
    friend class LightSum;

    class FluxLookup;
    /// One channel of the layer where it is looked up, at a cosine.
    struct Channel {
        const LayerLight& light;  // with its tables
        std::size_t index;
        double albedo, optical_depth, mixture;  // as seen
        double mu;
        FluxLookup& fluxes;
    };
    /// `value(light, channel)` of each, evaluated once where neighbours are alike.
    template <class Function>
    auto each_channel(const Matter& matter, double mu, const Function& value) const;
    /// `value(depth)` of each channel, evaluated once where neighbours are as deep.
    template <class Function>
    Rgb3 each_depth(const Matter& matter, const Function& value) const;
    bool is_stack() const { return !scene_.layer.stacks.empty(); }
    const LayerTable* table(LightPath path) const { return tables_ ? tables_->at(path) : nullptr; }
    void shine(int threads, LightDetail detail);
    void bind(const TableView* table, LightDetail detail);
    double transmittance(const Channel& channel) const;
    double spherical_albedo(const Channel& channel) const;
    double reflected_share(const Channel& channel) const;
    double diffuse_transmittance(const Channel& channel) const;
    double passing_share(const Channel& channel) const;

    const Scene& scene_;
    const LayerTables* tables_;
    Scenes channel_scenes_;  // these two are empty where channels share all
    std::vector<std::shared_ptr<const LayerLight>> channels_;  // those alike share one
    std::variant<std::monostate, Slice, RgbSlice> slice_;  // of a uniform layer; grey or coloured
    std::shared_ptr<const LayerFluxes> fluxes_;            // null without tables
    Opposition opposition_;                                // as it is seen
    OppositionTable opposition_table_;                     // where the layer varies
    std::vector<SingleDiffuseTransmittance> scattered_once_;  // of each component, where needed
    bool background_scatters_ = false;
    std::shared_ptr<const Scene> planet_scene_;
    std::shared_ptr<const LayerLight> planet_;
    std::shared_ptr<const RingOrders> ring_orders_;
    std::shared_ptr<const RingShine> ring_shine_;
    std::shared_ptr<const PlanetShine> planet_shine_;
    LookupRange* recorded_ = nullptr;
};

/// Sums of R or diffuse T of a uniform layer, each times a share: looked up together, which is
/// faster than one by one, and the same to rounding.
class LightSum {
  public:
    /// `light` must outlive this, and have sums.
    explicit LightSum(const LayerLight& light) : light_(light) {}

    /// Directs later additions to `sum`, which must stay until `finish`.
    void into(Rgb3& sum) { sum_ = &sum; }
    void add(Side side, const Geometry& geometry, const Rgb3& share);
    /// Until then, sums are incomplete.
    void finish();

  private:
    static constexpr std::size_t most = 64;
    struct Batch {
        std::size_t count = 0;
        std::array<float, most> mu_in, mu_out, azimuth;
        std::array<Rgb3, most> share;
        std::array<Rgb3*, most> sum;
    };
    void look_up(Side side);

    const LayerLight& light_;
    PerSide<Batch> batches_;
    Rgb3* sum_ = nullptr;
};

}  // namespace stratus
