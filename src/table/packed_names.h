// What a packed table's file holds, by name (docs/packed.md): strings, axes, fluxes, and for each
// side (and member of the family, if there is one) the blocks of functions.
#pragma once

#include <stratus/layer/single_scattering.h>
#include <stratus/phase/path_law.h>
#include <stratus/table/table.h>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace stratus {

constexpr const char* packed_format = "stratus-packed";
constexpr const char* packed_format_version = "5";

// Strings.
constexpr const char* format_name = "format";
constexpr const char* format_version_name = "format_version";
constexpr const char* phase_function_name = "phase_function";
constexpr const char* second_phase_function_name = "second_phase_function";
constexpr const char* below_name = "below";
constexpr const char* below_albedo_name = "below_albedo";
constexpr const char* below_phase_function_name = "below_phase_function";
constexpr const char* family_name = "family";                    // names of its axes
constexpr const char* family_path_law_name = "family_path_law";  // where lookups add that
constexpr const char* extrapolation_lengths_name = "extrapolation_lengths";  // of its members
constexpr const char* extrapolation_length_name = "extrapolation_length";
constexpr const char* tolerance_name = "tolerance";
constexpr const char* measured_error_name = "measured_error";
constexpr const char* highest_order_name = "highest_order";
constexpr const char* layer_phase_functions_name =
    "layer_phase_functions";  // of a stack, a line each
constexpr const char* spherical_albedo_below_name = "spherical_albedo_below";
constexpr const char* path_offset_name = "path_offset";
constexpr const char* path_deepest_name = "path_deepest";
constexpr const char* scale_suffix = "_scale";  // of an axis' name
constexpr const char* discrete_scale_name = "discrete";
constexpr const char* surface_name = "lambert surface";
constexpr const char* layer_name = "semi-infinite layer";

// Numbers.
constexpr const char* diffusion_exponent_name = "diffusion_exponent";
constexpr const char* layers_name = "layers";  // of a stack: albedo and optical depth of each
constexpr const char* path_orders_name = "path_orders";
constexpr const char* path_sheet_name = "path_sheet";
constexpr const char* phase_name = "phase";  // samples of a phase curve, where it needs any
constexpr const char* functions_name = "functions";
constexpr const char* functions_of_name = "functions_of";  // the member whose functions serve
constexpr const char* coefficients_name = "coefficients";
constexpr const char* blocks_name = "blocks";
constexpr const char* block_of_cell_name = "block_of_cell";

inline std::string side_name(Side side) {
    return side == Side::reflection ? "reflection/" : "transmission/";
}
inline std::string member_prefix(const Table& table, std::size_t member) {
    if (!table.has_family()) return "";
    return "member_" + std::to_string(member) + "/";
}

/// Numbers of a block in `blocks`.
namespace BlockField {
enum : int {
    first_albedo,  // samples of the table that its coefficients begin at
    albedos,       // of the coefficients
    first_depth,
    depths,            // infinity included
    ends_at_infinity,  // 1: its last depth is that
    first_row,         // of `coefficients`
    count
};
}

struct PackedAxisField {
    const char* name;
    Axis Table::*axis;
};
inline const std::array<PackedAxisField, 5>& packed_axis_fields() {
    static const std::array<PackedAxisField, 5> fields{{{"albedo", &Table::albedo},
                                                        {"optical_depth", &Table::optical_depth},
                                                        {"mu_in", &Table::mu_in},
                                                        {"mu_out", &Table::mu_out},
                                                        {"azimuth", &Table::azimuth}}};
    return fields;
}

struct PackedFluxField {
    const char* name;
    std::vector<float> Table::*flux;
    bool over_mu;
};
inline const std::array<PackedFluxField, 3>& packed_flux_fields() {
    static const std::array<PackedFluxField, 3> fields{
        {{"plane_albedo", &Table::plane_albedo, true},
         {"diffuse_transmittance", &Table::diffuse_transmittance, true},
         {"spherical_albedo", &Table::spherical_albedo, false}}};
    return fields;
}

/// Names of strings that a table's own attributes must not have.
bool is_reserved(const std::string& name);

constexpr std::size_t most_summed_orders = 64;  // of files that hold no path sheet

}  // namespace stratus
