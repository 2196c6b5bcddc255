#include "table_axes.h"

#include <stratus/io/table_file.h>
#include <stratus/runtime/constants.h>
#include <stratus/runtime/number_text.h>

#include <optional>
#include <span>
#include <stdexcept>

namespace stratus::io {

namespace {

/// In place of a scale, of an axis of which lookups take one value.
constexpr const char* discrete_name = "discrete";

// The minor versions that brought azimuths which do not span 0 to pi.
constexpr int first_minor_of_some_azimuths = 4, first_minor_of_some_azimuths_with_path_law = 2;

}  // namespace

const char* stored_scale_name(const AxisField& field, const Table& table) {
    const AxisScale scale = axis_of(table, field).scale;
    if (field.axis != nullptr) return axis_scale_name(scale);
    if (table.family[field.family].is_discrete) return discrete_name;
    return scale == AxisScale::linear ? mixture_scale_name : axis_scale_name(scale);
}

void read_scale(const AxisField& field, Table& table, const std::string& stored) {
    Axis& axis = axis_of(table, field);
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
                                 shown(stored));
}

std::vector<AxisField> axis_fields_of(const Table& table) {
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

void check_azimuths(const Metadata& metadata, const Table& table) {
    const int major = to_integer("format_major", entry(metadata, "format_major"));
    const int minor = to_integer("format_minor", entry(metadata, "format_minor"));
    const int first = major == table_format_major_of_path_law
                          ? first_minor_of_some_azimuths_with_path_law
                          : first_minor_of_some_azimuths;
    const std::vector<double>& azimuths = table.azimuth.values;
    if (minor >= first || azimuths.empty()) return;
    if (azimuths.front() > 0 || (azimuths.size() > 1 && pi - azimuths.back() > 1e-9))
        throw std::runtime_error("azimuth must span 0 to pi before format " +
                                 std::to_string(major) + "." + std::to_string(first) + ", got " +
                                 shortest_text(azimuths.front()) + " to " +
                                 shortest_text(azimuths.back()) + " in format " +
                                 std::to_string(major) + "." + std::to_string(minor));
}

void check_mixture_axis(const Metadata& metadata, bool is_stored) {
    if (is_stored) entry(metadata, "second_phase_function");
}

}  // namespace stratus::io
