// Fluxes of a scene's layer by its tables, cubic in albedo, optical depth and cosine. Those over
// cosines are divided by the share of light that is intercepted, and smooth then at grazing cosines and
// in thin layers. A picture asks at every sample, nearly always for the layer's own albedo: its fluxes
// in each channel are found beforehand.
#pragma once

#include <stratus/table/table.h>

#include <array>

namespace stratus {

class LayerFluxes {
    using Values = std::array<std::vector<double>, 3>;  // by Flux

  public:
    enum Flux : std::size_t { diffuse_transmittance, plane_albedo, spherical_albedo };

    /// A layer and a cosine among the samples of the tables.
    struct Place {
        Stencil mu{}, albedo{}, optical_depth{};
        double cosine = 1;
        double intercepted = 1;                       // share, of light along the cosine
        double thinness = 1;                          // of layers thinner than the tables', below 1
        const std::vector<Values>* values = nullptr;  // of all albedos, or of the layer's
    };

    /// `tables` differ in their mixtures alone; `albedo` of the layer in each channel.
    LayerFluxes(const std::vector<Table>& tables, const std::array<double, 3>& albedo);

    void set_albedo(Place& place, std::size_t channel, double albedo) const;
    void set_cosine(Place& place, double mu) const;
    /// After the cosine.
    void set_optical_depth(Place& place, double optical_depth) const;

    /// By one of the tables, at a place whose parts are all set; 0 where it has no such flux.
    double at(const Place& place, Flux flux, std::size_t table = 0) const;

  private:
    AxisView albedo_, optical_depth_, mu_;
    std::array<double, 3> own_albedo_;
    std::vector<Values> all_;                 // over (albedo, optical_depth, mu)
    std::array<std::vector<Values>, 3> own_;  // of each channel, over (optical_depth, mu)
};

}  // namespace stratus
