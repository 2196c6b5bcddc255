// Which layers a table knows: those between its samples, and by law some beyond them (slice.h).
#pragma once

#include <stratus/layer/single_scattering.h>
#include <stratus/table/table.h>

#include <string>

namespace stratus {

/// True where a table knows a value on one of its axes, to the rounding of a float.
bool holds(const AxisView& axis, double value);

/// True where the orders n >= 2 are 0: nothing in the layer scatters, and a surface alone does so
/// once.
bool is_scattered_once(const TableView& table, double albedo, double optical_depth);

/// Between the samples of optical depth, below them by the law of thin layers, beyond them by that
/// of diffusion.
bool is_depth_known(const TableView& table, Side side, double albedo, double optical_depth);

// Ranges covered by the table and by the laws that extend it, for messages.
std::string allowed_albedo(const TableView& table);
std::string allowed_depth(const TableView& table);

}  // namespace stratus
