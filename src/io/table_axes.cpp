#include "table_axes.h"

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/io/table_file.h>

#include <optional>
#include <span>
#include <stdexcept>

namespace stratus::io {

namespace {

/// In place of a scale, of an axis of which lookups take one value.
constexpr const char* discrete_name = "discrete";

}  // namespace

const char* stored_scale_name(const AxisField& field, const Table& table) {
    const AxisScale scale = table_axis(table, field).scale;
    if (field.axis != nullptr) return axis_scale_name(scale);
    if (table.family[field.family].is_discrete) return discrete_name;
    return scale == AxisScale::linear ? mixture_scale_name : axis_scale_name(scale);
}

void read_scale(const AxisField& field, Table& table, const std::string& stored) {
    Axis& axis = table_axis(table, field);
    if (field.axis == nullptr && stored == discrete_name &&
        table.extrapolation_lengths.size() > 0) {
        table.family[field.family].is_discrete = true;
        return;
    }
    std::optional<AxisScale> other;  // that the axis may have instead
    if (field.axis == &Table::azimuth) other = AxisScale::square_root;
    if (field.axis == &Table::albedo) other = AxisScale::fourth_root_of_complement;
    if (other && stored == axis_scale_name(*other)) {
        axis.scale = *other;
        return;
    }
    const bool matches = stored == axis_scale_name(axis.scale) ||
                         (axis.scale == AxisScale::linear && stored == mixture_scale_name);
    const auto or_other = [&] {
        return other ? std::string(" or ") + axis_scale_name(*other) : "";
    };
    if (!matches)
        throw std::runtime_error(std::string("scale of axis ") + field.name + " must be " +
                                 stored_scale_name(field, table) + or_other() + ", got " +
                                 shown_text(stored));
}

std::vector<AxisField> all_axis_fields(const Table& table) {
    std::vector<AxisField> fields;
    for (std::size_t k = 0; k < table.family.size(); ++k) {
        const PhaseParameter parameter = table.family[k].parameter;
        fields.push_back({parameter_name(parameter), parameter_unit(parameter),
                          parameter == PhaseParameter::mixture
                              ? "share of phase_function in all that is scattered"
                              : "parameter of phase_function",
                          nullptr, k});
    }
    fields.insert(fields.end(), axis_fields.begin(), axis_fields.end());
    return fields;
}

std::vector<std::size_t> extents(const Table& table, std::size_t rank) {
    std::vector<std::size_t> sizes;
    for (const FamilyAxis& axis : table.family) sizes.push_back(axis.axis.values.size());
    for (const AxisField& field : std::span(axis_fields).first(rank))
        sizes.push_back((table.*field.axis).values.size());
    return sizes;
}

}  // namespace stratus::io
