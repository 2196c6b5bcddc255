// Names of the tensors and strings in a packed table's file (docs/packed.md): strings, axes, fluxes, and for each
// side (and member of the family, if there is one) the blocks of functions.
#pragma once

#include <stratus/layer/single_scattering.h>
#include <stratus/phase/path_law.h>
#include <stratus/table/table.h>

#include <cstddef>
#include <string>

namespace stratus {

constexpr const char* packed_format = "stratus-packed";
constexpr const char* packed_format_version = "6";

// Strings.
constexpr const char* format_name = "format";
constexpr const char* format_version_name = "format_version";
constexpr const char* path_offset_name = "path_offset";
constexpr const char* path_deepest_name = "path_deepest";
constexpr const char* scale_suffix = "_scale";  // of an axis' name
constexpr const char* discrete_scale_name = "discrete";

// Numbers.
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

/// Names of strings that a table's own attributes must not have.
bool is_reserved(const std::string& name);

constexpr std::size_t most_summed_orders = 64;  // of files that hold no path sheet

}  // namespace stratus
