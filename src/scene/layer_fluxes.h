// Fluxes of a scene's layer by its tables, cubic in albedo, optical depth and cosine. A picture asks
// at every sample, nearly always for the layer's own albedo: its fluxes in each channel are found
// beforehand.
#pragma once

#include <stratus/runtime/table.h>

#include <array>
#include <cstddef>
#include <vector>

namespace stratus {

class LayerFluxes {
    using Values = std::array<std::vector<float>, 3>;  // by Flux

  public:
    enum Flux : std::size_t { diffuse_transmittance, plane_albedo, spherical_albedo };

    /// A layer and a cosine among the samples of the tables.
    struct Place {
        Stencil mu{}, albedo{}, optical_depth{};
        double factor = 1;                            // of layers thinner than the tables
        const std::vector<Values>* values = nullptr;  // of all albedos, or of the layer's
    };

    /// `tables` differ in their mixtures alone; `albedo` of the layer in each channel.
    LayerFluxes(const std::vector<Table>& tables, const std::array<double, 3>& albedo);

    Stencil cosine(double mu) const noexcept { return mu_.stencil(mu); }
    void set_albedo(Place& place, std::size_t channel, double albedo) const noexcept;
    void set_optical_depth(Place& place, double optical_depth) const noexcept;

    /// By one of the tables, at a place whose parts are all set; 0 where it has no such flux.
    double at(const Place& place, Flux flux, std::size_t table = 0) const noexcept;

  private:
    AxisView albedo_, optical_depth_, mu_;
    std::array<double, 3> own_albedo_;
    std::vector<Values> all_;                 // over (albedo, optical_depth, mu)
    std::array<std::vector<Values>, 3> own_;  // of each channel, over (optical_depth, mu)
};

}  // namespace stratus
