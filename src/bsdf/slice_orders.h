// The orders n >= 2 of a layer that a slice is bound to, from a table's samples or a packed table.
#pragma once

#include "slice_refinement.h"

namespace stratus {

/// Of one side; beyond the deepest sample as the law of diffusion has it (lookup.h).
ChannelOrders orders_of(const TableView& table, Side which, double albedo, double optical_depth);

}  // namespace stratus
