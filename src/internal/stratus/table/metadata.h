// Table files of all formats hold axes and other numbers, and in texts all else, under the names below
// (docs/tables.md, section 1). A number in a text is the shortest that reads back as the same bits.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/table/table.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace stratus {

/// How files of samples begin.
inline constexpr std::string_view hdf5_magic{"\x89HDF\r\n\x1a\n", 8};
inline constexpr std::string_view exr_magic{"\x76\x2f\x31\x01", 4};

// ---- Numbers

struct AxisField {
    const char* name;
    const char* units;
    const char* long_name;
    Axis Table::*axis;         // null: of the family
    std::size_t family = 0;    // there its place
    AxisScale scales[2] = {};  // that it may have
    const char* range = "";    // of its samples (NumberRange); outside families
};

inline constexpr std::array<AxisField, 5> axis_fields{{
    {"albedo",
     "1",
     "single-scattering albedo",
     &Table::albedo,
     0,
     {AxisScale::square_root_of_complement, AxisScale::fourth_root_of_complement},
     "[0, 1]"},
    {"optical_depth",
     "1",
     "optical depth of the layer",
     &Table::optical_depth,
     0,
     {AxisScale::logarithmic, AxisScale::logarithmic},
     "(0, inf]"},
    {"mu_in",
     "1",
     "cosine of the incident direction to the normal",
     &Table::mu_in,
     0,
     {AxisScale::arcsine_of_fourth_root, AxisScale::arcsine_of_fourth_root},
     "(0, 1]"},
    {"mu_out",
     "1",
     "cosine of the outgoing direction to the normal",
     &Table::mu_out,
     0,
     {AxisScale::arcsine_of_fourth_root, AxisScale::arcsine_of_fourth_root},
     "(0, 1]"},
    {"azimuth",
     "radian",
     "azimuth between the two directions of propagation",
     &Table::azimuth,
     0,
     {AxisScale::linear, AxisScale::square_root},
     "[0, 3.1415926535897931]"},
}};

/// The scales of an axis, for messages.
std::string allowed_scales(const AxisField& field);

/// The axes of a table, those of the family first.
std::vector<AxisField> all_axis_fields(const Table& table);

inline const Axis& table_axis(const Table& table, const AxisField& field) {
    return field.axis != nullptr ? table.*field.axis : table.family[field.family].axis;
}
inline Axis& table_axis(Table& table, const AxisField& field) {
    return field.axis != nullptr ? table.*field.axis : table.family[field.family].axis;
}

/// Sizes of the first `rank` axes, preceded by those of the family.
std::vector<std::size_t> extents(const Table& table, std::size_t rank);

/// In place of a scale, of an axis of which lookups take one value.
constexpr const char* discrete_scale_name = "discrete";

/// Name of an axis's scale in a file of samples.
const char* stored_scale_name(const AxisField& field, const Table& table);

/// Numbers over the first axes of a table.
struct SampleField {
    const char* name;
    const char* long_name;
    std::size_t rank;  // without the axes of a family
    std::vector<float> Table::*samples;

    bool is_flux() const { return rank < axis_fields.size(); }
};

inline constexpr std::array<SampleField, 5> sample_fields{{
    {"reflection_multiple", "reflection, orders of scattering from 2", 5,
     &Table::reflection_multiple},
    {"transmission_multiple", "diffuse transmission, orders of scattering from 2", 5,
     &Table::transmission_multiple},
    {"plane_albedo", "plane albedo", 3, &Table::plane_albedo},
    {"diffuse_transmittance", "diffuse transmittance", 3, &Table::diffuse_transmittance},
    {"spherical_albedo", "spherical albedo", 2, &Table::spherical_albedo},
}};

inline constexpr const char* diffusion_exponent_name = "diffusion_exponent";
inline constexpr const char* diffusion_exponent_long_name =
    "decay of the light field with optical depth, deep inside the layer";

// ---- Texts

using Metadata = std::map<std::string, std::string>;

/// A reader that does not know of one of these would look up wrong values.
constexpr const char* family_feature = "family";
constexpr const char* stack_feature = "stack";
constexpr const char* path_law_feature = "path_law";

/// An entry whose name has a meaning, and its type in formats that have types.
struct MetadataEntry {
    enum Type { text, integer, number, numbers };

    const char* name;
    Type type = text;
};

/// The entries of all formats.
inline constexpr std::array<MetadataEntry, 17> shared_entries{{
    {"features"},
    {"phase_function"},
    {"second_phase_function"},
    {"family"},
    {"extrapolation_lengths", MetadataEntry::numbers},
    {"below"},
    {"below_albedo", MetadataEntry::number},
    {"below_phase_function"},
    {"below_ground"},
    {"layer_phase_functions"},
    {"layer_albedos", MetadataEntry::numbers},
    {"layer_optical_depths", MetadataEntry::numbers},
    {"spherical_albedo_below", MetadataEntry::number},
    {"extrapolation_length", MetadataEntry::number},
    {"tolerance", MetadataEntry::number},
    {"measured_error", MetadataEntry::number},
    {"highest_order", MetadataEntry::integer},
}};

/// Returns the entry of this name out of a list; null where there is none.
template <std::size_t count>
const MetadataEntry* find_entry(const std::array<MetadataEntry, count>& entries,
                                std::string_view name) {
    const auto found = std::find_if(entries.begin(), entries.end(),
                                    [&](const MetadataEntry& one) { return one.name == name; });
    return found == entries.end() ? nullptr : &*found;
}

/// The entries of a table, its own attributes among them.
Metadata shared_metadata(const Table& table);

/// Refuses features that this program does not know.
///
/// Errors   std::invalid_argument, as below.
void check_features_known(const Metadata& metadata);

/// Whether the entries say that a table has a feature.
bool has_feature(const Metadata& metadata, const char* feature);

/// The table of these entries, still without axes, samples, fluxes, attributes and path law.
///
/// Errors   std::invalid_argument "attribute NAME must be ..., got ..."; those of parse_phase_function.
Table table_of_metadata(const Metadata& metadata);

/// Refuses a table that has not the features that its entries say, or others.
///
/// Errors   as above.
void check_features(const Metadata& metadata, const Table& table);

/// The entry `name`.
///
/// Errors   std::invalid_argument where it is missing.
const std::string& entry(const Metadata& metadata, const std::string& name);

/// Numbers separated by spaces.
std::string to_text(const std::vector<double>& values);

/// Errors   std::invalid_argument naming `what`.
double to_number(const std::string& what, std::string_view text);
int to_integer(const std::string& what, std::string_view text);
std::vector<double> to_numbers(const std::string& what, std::string_view text);

/// Text from a file in quotes, shortened and without control characters, for messages.
std::string shown_text(std::string_view text);

}  // namespace stratus
