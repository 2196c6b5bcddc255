#include "layer_coverage.h"

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include "layer_blend.h"

#include <sstream>

namespace stratus {
namespace {

std::string range_text(double min, double max) {
    std::ostringstream text;
    text << "in [" << min << ", " << max << "] of the table";
    return text.str();
}

/// True over a boundary whose light in the samples stays as the layer vanishes.
bool keeps_light(const TableView& table) {
    return table.has_lower_boundary() && table.lower_boundary->kind != LowerBoundary::Kind::surface;
}

/// Layers deeper than the deepest sample of a table without one at infinity.
bool is_depth_known_by_diffusion(const TableView& table, Side side, double albedo,
                                 double optical_depth) {
    if (side == Side::transmission && optical_depth == infinity) return true;
    return deficit_of_deepest(table, albedo) <= kept_tolerance(table);
}

}  // namespace

bool holds(const AxisView& axis, double value) {
    constexpr double rounding = 1e-7;
    return value >= axis.lowest * (1 - rounding) && value <= axis.highest * (1 + rounding);
}

bool is_scattered_once(const TableView& table, double albedo, double optical_depth) {
    return !table.is_stack() && (albedo == 0 || optical_depth == 0) && !keeps_light(table);
}

bool is_depth_known(const TableView& table, Side side, double albedo, double optical_depth) {
    const AxisView& depth = table.optical_depth;
    if (depth.count == 0) return optical_depth == infinity;
    if (holds(depth, optical_depth) || table.is_stack()) return holds(depth, optical_depth);
    if (optical_depth < depth.lowest) return !keeps_light(table);
    return depth.ends_at_infinity ||
           is_depth_known_by_diffusion(table, side, albedo, optical_depth);
}

std::string allowed_albedo(const TableView& table) {
    if (table.is_stack()) return shortest_text(table.albedo.lowest) + ", that of the stack";
    const bool is_black_known = !keeps_light(table);
    const AxisView& albedo = table.albedo;
    return (is_black_known && albedo.lowest > 0 ? "0 or " : "") +
           range_text(albedo.lowest, albedo.highest);
}

std::string allowed_depth(const TableView& table) {
    const AxisView& depth = table.optical_depth;
    if (depth.count == 0) return "inf, all that the table holds";
    if (table.is_stack()) return shortest_text(depth.lowest) + ", that of the stack";
    const bool is_thin_known = !keeps_light(table);
    return range_text(is_thin_known ? 0 : depth.lowest, depth.highest) +
           (depth.ends_at_infinity ? " or inf" : "");
}

}  // namespace stratus
