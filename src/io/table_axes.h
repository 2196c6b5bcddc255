// The axes of a table as its files name and scale them.
#pragma once

#include <stratus/table/table.h>

#include "table_content.h"

#include <cstddef>
#include <string>
#include <vector>

namespace stratus::io {

inline const Axis& table_axis(const Table& table, const AxisField& field) {
    return field.axis != nullptr ? table.*field.axis : table.family[field.family].axis;
}
inline Axis& table_axis(Table& table, const AxisField& field) {
    return field.axis != nullptr ? table.*field.axis : table.family[field.family].axis;
}

/// Name of an axis's scale in a file.
const char* stored_scale_name(const AxisField& field, const Table& table);

/// Checks that the scale of an axis, by its name in a file, is the one that the axis has in memory;
/// the azimuth takes over either of its two, the axis of a family whether it is discrete. A linear
/// scale goes by either of its names.
void read_scale(const AxisField& field, Table& table, const std::string& stored);

/// The axes of a table, those of the family first.
std::vector<AxisField> all_axis_fields(const Table& table);

/// Sizes of the first `rank` axes, preceded by those of the family.
std::vector<std::size_t> extents(const Table& table, std::size_t rank);

}  // namespace stratus::io
