// The share of a uniform background that is seen through a bound layer: the beam, and what the layer
// transmits of all other directions.
#pragma once

#include <stratus/layer/diffuse_transmittance.h>
#include <stratus/layer/stack_layers.h>
#include <stratus/table/table.h>

#include "table/layer_blend.h"

#include <vector>

namespace stratus {

/// Diffuse transmittance of a layer over cosines, divided by the share of light intercepted.
class SliceBackground {
  public:
    /// Takes all orders of a table that has them or, without a table, order 1 alone: that of the layer
    /// or, given `layers`, of a stack's. Keeps pointers to both.
    SliceBackground(const TableView* table, bool with_order_1, const PhaseFunction& phase_function,
                    const std::vector<StackLayer>* layers);

    const AxisView& cosines() const noexcept { return cosines_; }

    /// Over cosines(); empty where nothing is transmitted diffusely.
    std::vector<float> curve(double albedo, double optical_depth) const;

  private:
    double order_1(double albedo, double optical_depth, double mu) const;

    const TableView* table_;
    const std::vector<StackLayer>* layers_;
    AxisView cosines_;
    // Order 1 of the layer, or of each of the stack's: added, or taken out of the table's.
    std::vector<SingleDiffuseTransmittance> order_1_;
};

/// The beam and the diffuse transmittance of a curve, at most 1.
float background_share(const AxisView& cosines, const std::vector<float>& curve,
                       double optical_depth, double mu) noexcept;

}  // namespace stratus
