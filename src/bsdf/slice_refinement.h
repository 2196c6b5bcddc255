// The samples of a slice: a table's cosines refined until straight lines between them meet its
// tolerance, and as many azimuths as cubics need.
#pragma once

#include <stratus/table/table.h>

#include "kernels/slice_side.h"
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

/// Orders n >= 2 over (mu_in, mu_out, azimuth, channel) as a slice reads them, mu_in >= mu_out
/// where the table is symmetric; cosines evenly spaced over sqrt(1 - mu) (1 - mu^(1/4) / 2).
struct RefinedSamples {
    std::vector<float> sample;
    bool symmetric;
    int columns, azimuths;
    SlicePlaces places;
};

/// All channels are refined alike.
RefinedSamples refine(const TableView& table, const std::vector<ChannelOrders>& channels,
                      const SingleScattering& single);

}  // namespace stratus
