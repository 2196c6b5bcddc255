// The orders n >= 2 of a layer that a slice is bound to, from a table's samples or a packed table.
#pragma once

#include "slice_refinement.h"

namespace stratus {

/// Finds the orders n >= 2 of one side; beyond the deepest sample they are extrapolated by diffusion
/// (lookup.h).
ChannelOrders find_orders(const TableView& table, Side which, double albedo, double optical_depth);

}  // namespace stratus
