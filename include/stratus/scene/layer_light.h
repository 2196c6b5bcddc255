// The light of a scene's layer at any of its points, with the scene's effects: by a slice where the
// layer is uniform, by textured tables where it varies; single scattering in closed form.
#pragma once

#include <stratus/runtime/constants.h>
#include <stratus/runtime/diffuse_transmittance.h>
#include <stratus/runtime/slice.h>
#include <stratus/scene/layer_tables.h>
#include <stratus/scene/scene.h>

#include <array>
#include <optional>
#include <vector>

namespace stratus {

using Rgb3 = std::array<double, 3>;

/// What a picture looks up of its layer: directions, matter and sides.
struct LookupRange {
    Range mu_in{1, 0}, mu_out{1, 0}, azimuth{180, 0};  // degrees
    Range optical_depth{infinity, 0}, albedo{1, 0};
    bool reflection = false, transmission = false;

    void add(const Matter& matter, const Geometry& geometry, Side side) noexcept;
};

class LayerLight {
  public:
    /// `tables` is null where none is needed. Both must outlive this.
    ///
    /// Errors   std::invalid_argument for orders n >= 2 without a table.
    LayerLight(const Scene& scene, const LayerTables* tables);

    /// A uniform layer with the table's phase function and lower boundary, in a scene without
    /// ground.
    LayerLight(const Scene& scene, const TableView& table);

    /// R and diffuse T. `matter` is the scene's, without the effect of density.
    Rgb3 reflection(const Matter& matter, const Geometry& geometry) const noexcept {
        return light(matter, geometry, Side::reflection);
    }
    Rgb3 transmission(const Matter& matter, const Geometry& geometry) const noexcept {
        return light(matter, geometry, Side::transmission);
    }

    /// exp(-tau / mu).
    double beam(const Matter& matter, double mu) const noexcept;

    /// Share of the scene's background that is seen through the layer: the beam, and of a background
    /// of one colour the diffuse transmittance. What patterns and images give scattered is left out.
    Rgb3 background(const Matter& matter, double mu) const noexcept;

    /// What a Lambert surface below the layer adds to R, interreflections included:
    /// A t(mu_in) t(mu_out) / (1 - A s), t the direct and diffuse transmittance, s the layer's
    /// spherical albedo. The surface is lit through `lit` and seen through `seen`; exact where both
    /// are the same.
    Rgb3 ground(const Matter& lit, double mu_in, const Matter& seen, double mu_out,
                const Rgb& ground_albedo) const noexcept;

    /// Records later lookups in `range`, which one thread at a time may do.
    void record(LookupRange* range) noexcept { recorded_ = range; }

  private:
    /// `of(light, c)` of each channel's own light.
    template <class Function>
    Rgb3 of_channels(const Function& of) const noexcept;
    /// `matter` in one channel: grey in its albedo, of its depth.
    Matter channel_matter(const Matter& matter, std::size_t c) const noexcept;
    void bind(const TableView* table, bool multiple);
    Rgb3 light(const Matter& matter, const Geometry& geometry, Side side) const noexcept;
    Rgb3 textured_light(const Matter& matter, const Geometry& geometry, Side side) const noexcept;
    double transmittance(double albedo, double optical_depth, double mu) const noexcept;
    double spherical_albedo(double albedo, double optical_depth) const noexcept;
    double diffuse_transmittance(const Matter& matter, double albedo, double optical_depth,
                                 double mu) const noexcept;
    /// `flux` of a table, over (albedo, optical_depth) or, where `mu` is not null, over
    /// (albedo, optical_depth, mu).
    double flux(const Table& table, const std::vector<float>& flux, double albedo,
                double optical_depth, const Stencil* mu) const noexcept;

    const Scene& scene_;
    const LayerTables* tables_;
    std::vector<Scene> channel_scenes_;  // these two are empty where channels share all
    std::vector<LayerLight> channels_;
    std::optional<RgbSlice> slice_;
    Opposition opposition_;                                   // as it is seen
    OppositionTable opposition_table_;                        // where the layer varies
    std::vector<SingleDiffuseTransmittance> scattered_once_;  // of each component, where needed
    bool background_scatters_ = false;
    LookupRange* recorded_ = nullptr;
};

}  // namespace stratus
