// The parts of a slice, each in a file of its name: the orders n >= 2 and the background that a table gives a
// layer (slice_orders.cpp); the samples of a slice, a table's cosines refined until straight lines between them, or
// cubics where these would be too many, meet its tolerance, and as many azimuths as cubics need (slice_refinement.cpp).
#pragma once

#include <stratus/layer/single_scattering.h>
#include <stratus/layer/stack_layers.h>
#include <stratus/table/table.h>

#include "kernels/kernels.h"
#include "table/layer_blend.h"

#include <functional>
#include <vector>

namespace stratus {

/// Single scattering of a channel at (channel, mu_in, mu_out, azimuth): errors are relative to R or
/// T of all orders.
using SingleScattering = std::function<double(int, double, double, double)>;

/// Orders n >= 2 of a channel: a blend of a table's samples, or what a packed table gives at its
/// axes, before the blend's directional factor.
struct ChannelOrders {
    LayerBlend blend{};
    std::vector<float> sheet;
};

/// Finds the orders n >= 2 of one side, from a table's samples or a packed table; beyond the deepest
/// sample they are extrapolated by diffusion (lookup.h).
ChannelOrders find_orders(const TableView& table, Side which, double albedo, double optical_depth);

/// Orders n >= 2 over (mu_in, mu_out, azimuth, channel) as a slice reads them (kernels.h); cosines evenly
/// spaced over sqrt(1 - mu) (1 - mu^(1/4) / 2).
struct RefinedSamples : SampleShape {
    std::vector<float> sample;
};

/// All channels are refined alike.
RefinedSamples refine(const TableView& table, const std::vector<ChannelOrders>& channels,
                      const SingleScattering& single);

/// Diffuse transmittance of a layer over cosines, divided by the share of light intercepted: with the beam, the
/// share of a uniform background that is seen through it.
class SliceBackground {
  public:
    /// Takes all orders of a table that has them or, without a table, order 1 alone: that of the layer
    /// or, given `layers`, of a stack's. All outlive this.
    SliceBackground(const TableView* table, bool with_order_1, const PhaseFunction& phase_function,
                    const StackLayers* layers);

    const AxisView& cosines() const noexcept { return cosines_; }

    /// Over cosines(); empty where nothing is transmitted diffusely.
    std::vector<float> curve(double albedo, double optical_depth);

  private:
    double order_1(double albedo, double optical_depth, double mu);

    /// t of the orders that the table holds, over cosines(); deeper than its deepest sample it follows
    /// diffusion. Interpolated after division by the albedo, which leaves order 1 at albedo 0.
    std::vector<double> diffuse_transmittance(double albedo, double optical_depth);

    const TableView* table_;
    const PhaseFunction& phase_function_;
    const StackLayers* layers_;
    AxisView cosines_;
    int times_order_1_;  // to be added: 1 without a table; 0, or -1, to those of one
    std::vector<SingleDiffuseTransmittance> order_1_;  // of each layer; empty until asked for
};

}  // namespace stratus
