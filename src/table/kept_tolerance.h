// How far faster lookups may differ from those of the table itself.
#pragma once

#include <stratus/table/table.h>

namespace stratus {

/// Errors count relative to R or T, but not to less than this share of the largest of a layer.
constexpr double darkest_share = 0.01;

/// The tolerance that a table was baked for; the usual one of a table that does not say.
inline double kept_tolerance(const TableView& table) {
    constexpr double usual = 1e-3;
    return table.tolerance > 0 ? table.tolerance : usual;
}

}  // namespace stratus
