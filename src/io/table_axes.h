// The axes of a table as its files name and scale them.
#pragma once

#include <stratus/table/table.h>

#include "table_content.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace stratus::io {

struct AxisField {
    const char* name;
    const char* units;
    const char* long_name;
    Axis Table::*axis;       // null: of the family
    std::size_t family = 0;  // there its place
};

inline const Axis& axis_of(const Table& table, const AxisField& field) {
    return field.axis != nullptr ? table.*field.axis : table.family[field.family].axis;
}
inline Axis& axis_of(Table& table, const AxisField& field) {
    return field.axis != nullptr ? table.*field.axis : table.family[field.family].axis;
}

inline constexpr std::array<AxisField, 5> axis_fields{{
    {"albedo", "1", "single-scattering albedo", &Table::albedo},
    {"optical_depth", "1", "optical depth of the layer", &Table::optical_depth},
    {"mu_in", "1", "cosine of the incident direction to the normal", &Table::mu_in},
    {"mu_out", "1", "cosine of the outgoing direction to the normal", &Table::mu_out},
    {"azimuth", "radian", "azimuth between the two directions of propagation", &Table::azimuth},
}};

/// Name of an axis's scale in a file.
const char* stored_scale_name(const AxisField& field, const Table& table);

/// Checks that the scale of an axis, by its name in a file, is the one that the axis has in memory;
/// the azimuth takes over either of its two, the axis of a family whether it is discrete. A linear
/// scale goes by either of its names.
void read_scale(const AxisField& field, Table& table, const std::string& stored);

/// The axes of a table, those of the family first.
std::vector<AxisField> axis_fields_of(const Table& table);

/// Sizes of the first `rank` axes, preceded by those of the family.
std::vector<std::size_t> extents(const Table& table, std::size_t rank);

}  // namespace stratus::io
