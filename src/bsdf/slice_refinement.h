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

/// Orders n >= 2 over (mu_in, mu_out, azimuth, channel) as a slice reads them, mu_in >= mu_out
/// where the table is symmetric; cosines evenly spaced over the coordinate of mu_places.h.
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
