// The light of a scene's layer at any of its points, with the scene's effects: slices where its
// matter is the same everywhere, textured tables where it varies; single scattering in closed form.
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

/// What a picture asks of its layer: directions, matter and sides.
struct AskedRange {
    Range mu_in{1, 0}, mu_out{1, 0}, azimuth{180, 0};  // degrees
    Range optical_depth{infinity, 0}, albedo{1, 0};
    bool lit_side = false, far_side = false;

    void add(const Matter& matter, const Geometry& geometry, bool reflected) noexcept;
};

class LayerLight {
  public:
    /// `tables` null: none is needed. Both must outlive this.
    ///
    /// Errors   std::invalid_argument where orders n >= 2 are asked for and there is no table.
    LayerLight(const Scene& scene, const LayerTables* tables);

    /// A uniform layer on the table's own lower boundary: a scene without ground. The phase function
    /// is the table's too.
    LayerLight(const Scene& scene, const TableView& table);

    /// R and diffuse T of light from above; matter as in the scene, before the effect of density.
    Rgb3 reflection(const Matter& matter, const Geometry& geometry) const noexcept {
        return side(matter, geometry, true);
    }
    Rgb3 transmission(const Matter& matter, const Geometry& geometry) const noexcept {
        return side(matter, geometry, false);
    }

    /// exp(-tau / mu).
    double beam(const Matter& matter, double mu) const noexcept;

    /// Share of the scene's background that is seen through the layer: the beam, and of a background
    /// of one colour the diffuse transmittance. What patterns and images give scattered is left out.
    Rgb3 background(const Matter& matter, double mu) const noexcept;

    /// What ground of Lambert's law beneath the layer adds to R, with all light between the two:
    /// A t(mu_in) t(mu_out) / (1 - A s), t the beam and what is transmitted diffusely, s the
    /// layer's spherical albedo. The ground is lit through `lit`, seen through `seen`; where both
    /// are the same this is exact.
    Rgb3 ground(const Matter& lit, double mu_in, const Matter& seen, double mu_out,
                const Rgb& ground_albedo) const noexcept;

    /// Keeps account in `asked` of what follows, for one thread.
    void watch(AskedRange* asked) noexcept { asked_ = asked; }

  private:
    void bind(const TableView* table, bool multiple);
    Rgb3 side(const Matter& matter, const Geometry& geometry, bool reflected) const noexcept;
    Rgb3 textured_side(const Matter& matter, const Geometry& geometry,
                       bool reflected) const noexcept;
    double transmittance(double albedo, double optical_depth, double mu) const noexcept;
    double spherical_albedo(double albedo, double optical_depth) const noexcept;
    double diffuse_transmittance(const Matter& matter, double albedo, double optical_depth,
                                 double mu) const noexcept;
    /// A flux of a table; `flux` over (albedo, optical_depth) times `mus`.
    double flux(const Table& table, const std::vector<float>& flux, double albedo,
                double optical_depth, const Stencil* mu) const noexcept;

    const Scene& scene_;
    const LayerTables* tables_;
    std::optional<RgbSlice> slice_;
    Opposition opposition_;
    std::vector<SingleDiffuseTransmittance> scattered_once_;  // of each component, where needed
    bool background_scatters_ = false;
    AskedRange* asked_ = nullptr;
};

}  // namespace stratus
