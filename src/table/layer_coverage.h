// Which layers a table knows: those between its samples, and by law some beyond them (slice.h); and how
// closely faster lookups follow it.
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

/// Errors count relative to R or T, but not to less than this share of the largest of a layer.
constexpr double darkest_share = 0.01;

/// The tolerance that a table was baked for; the usual one of a table that does not say.
inline double kept_tolerance(const TableView& table) {
    constexpr double usual = 1e-3;
    return table.tolerance > 0 ? table.tolerance : usual;
}

}  // namespace stratus
