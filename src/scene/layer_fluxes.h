// Fluxes of a scene's layer by its tables, cubic in albedo, optical depth and cosine once they are divided
// by what scales them: the albedo, the share of light that is intercepted along the cosine, and the laws
// of diffusion (diffusion.h). A picture asks at every sample, nearly always for the layer's own albedo:
// its fluxes in each channel are found beforehand.
#pragma once

#include <stratus/table/table.h>

#include <array>

namespace stratus {

class LayerFluxes {
    /// By Flux, and then the diffusion exponents, over albedo alone.
    using Values = std::array<std::vector<double>, 4>;

    struct Scales {
        double transmission, deficit;
        double reflection() const { return 1 / (1 + deficit + deficit * deficit); }
    };

    /// The laws of one diffusion exponent, as diffusion.h has them but with one exponential for each depth.
    class Decay {
      public:
        Decay(double exponent, double extrapolation_length);
        Scales scales(double optical_depth) const;

      private:
        double exponent_, length_;
        double rest_;  // 1 - exp(-2 k q)
    };

  public:
    enum Flux : std::size_t { diffuse_transmittance, plane_albedo, spherical_albedo };

    /// A layer and a cosine among the samples of the tables.
    struct Place {
        Stencil mu{}, albedo{};
        Stencil transmitted{}, reflected{};  // of optical depth, of which the limit 0 is the first
        Stencil table{0, {1, 0, 0, 0}};      // among the mixtures
        double cosine = 1;
        double depth = 0;                             // optical, not thinner than the tables'
        double factor = 1;                            // the albedo, within the tables'
        double transmission = 1, reflection = 1;      // scales of diffusion
        double intercepted = 1;                       // share, of light along the cosine
        double thinness = 1;                          // of layers thinner than the tables', below 1
        const std::vector<Values>* values = nullptr;  // of all albedos, or of the layer's
    };

    /// `tables` differ in their mixtures alone; `albedo` of the layer in each channel.
    LayerFluxes(const std::vector<Table>& tables, const std::array<double, 3>& albedo);

    void set_cosine(Place& place, double mu) const;
    /// After the cosine.
    void set_optical_depth(Place& place, double optical_depth) const;
    /// After all else.
    void set_albedo(Place& place, std::size_t channel, double albedo) const;

    /// At a place whose parts are all set; 0 where the tables have no such flux.
    double at(const Place& place, Flux flux) const;

  private:
    Decay decay_at(const Place& place) const;
    /// Interpolates what is stored of a flux, by these weights of the depths.
    double interpolated(const std::vector<double>& values, const Place& place,
                        const Stencil& depths, Flux flux) const;

    AxisView albedo_, optical_depth_, mu_;
    std::array<double, 3> own_albedo_;
    std::vector<double> extrapolation_length_;  // of each table
    std::vector<Values> all_;                   // over (albedo, optical_depth, mu), depth 0 first
    std::array<std::vector<Values>, 3> own_;    // of each channel, over (optical_depth, mu)
    std::array<std::vector<Decay>, 3> own_decay_;
};

}  // namespace stratus
