// A packed table's file (docs/packed.md): the names of its tensors and strings, and how it is read, as the
// table without its samples and both sides for each member of a family.
#pragma once

#include <stratus/base/argument.h>
#include <stratus/base/tensor_file.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/phase/path_law.h>
#include <stratus/table/kernels/packed.h>
#include <stratus/table/table.h>

#include "base/mapped_tensors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace stratus {

// ---- names

constexpr const char* packed_format = "stratus-packed";
constexpr const char* packed_format_version = "6";

// Strings.
constexpr const char* format_name = "format";
constexpr const char* format_version_name = "format_version";
constexpr const char* path_offset_name = "path_offset";
constexpr const char* path_deepest_name = "path_deepest";
constexpr const char* scale_suffix = "_scale";  // of an axis' name

// Numbers.
constexpr const char* path_orders_name = "path_orders";
constexpr const char* path_sheet_name = "path_sheet";
constexpr const char* phase_name = "phase";  // samples of a phase curve, where it needs any
constexpr const char* functions_name = "functions";
constexpr const char* functions_of_name = "functions_of";  // the member whose functions serve
constexpr const char* coefficients_name = "coefficients";
constexpr const char* blocks_name = "blocks";
constexpr const char* block_of_cell_name = "block_of_cell";

inline std::string member_prefix(const Table& table, std::size_t member) {
    if (!table.has_family()) return "";
    return "member_" + std::to_string(member) + "/";
}
inline std::string side_prefix(const Table& table, std::size_t member, Side side) {
    return member_prefix(table, member) +
           (side == Side::reflection ? "reflection/" : "transmission/");
}

/// Numbers of a block, a row of `blocks`.
struct BlockFields {
    std::int32_t first_albedo;  // sample of the table that its coefficients begin at
    std::int32_t albedos;       // of the coefficients
    std::int32_t first_depth;
    std::int32_t depths;            // infinity included
    std::int32_t ends_at_infinity;  // 1: its last depth is that
    std::int32_t first_row;         // of `coefficients`
};
constexpr std::size_t block_field_count = sizeof(BlockFields) / sizeof(std::int32_t);

/// Names of strings that a table's own attributes must not have.
bool is_reserved(const std::string& name);

constexpr std::size_t most_summed_orders = 64;  // of files that hold no path sheet

// ---- reading

constexpr const char* packed_caller = "packed table";
constexpr std::size_t packed_alignment = 64;  // of rows, and so of the file

/// Steps of a path sheet over (w + w^2) / 2 from 0 to 1, even in w where it is small and closer near 1. R of many orders follows w more steeply: of a deep table of
/// Henyey-Greenstein 0.98 (303 orders) one lookup in a thousand is 3e-2 off with 11 steps, 4e-3 with 26.
inline int path_sheet_steps(const PathOrders& law) { return law.order_count() - 2 > 200 ? 26 : 11; }

/// The albedo of step i of a path sheet; in place of 0, where the law divided by w^2 has but a limit, a
/// small one.
inline double path_sheet_albedo(int i, int steps) {
    return std::max(1e-3, 0.5 * (std::sqrt(1 + 8.0 * i / steps) - 1));
}

/// The first step that lookups of a table read: a sheet holds those from there on.
inline int first_path_step(const PathOrders& law, const TableView& table) {
    constexpr double rounding = 1e-6;  // of lookups
    const int steps = path_sheet_steps(law);
    const double w = table.albedo.lowest, place = steps * 0.5 * (w + w * w) * (1 - rounding);
    return std::clamp(static_cast<int>(place) - 1, 0, steps - stencil_size + 1);
}

/// The path law divided by w^2, tabulated over the albedo from its `first` step on.
PathSheet squared_path_sheet(const PathOrders& law, int first, int highest_order);

/// One side, with the memory that its view points to.
struct SideMemory {
    PackedSide view{};
    const PackedKernel* kernel = nullptr;
    const PackedKernel* of_multiple = nullptr;  // where no phase function is asked for
    PhaseCurve phase;
    std::vector<LayerBlock> blocks;
    std::vector<float> block_of_cell;
    std::vector<float> diffusion_exponent, inverse_deficit, deepest_scale;
    std::vector<float> no_coefficients, no_functions;  // of a side that is not held
};

/// All that is not a side.
///
/// Errors   std::invalid_argument: one sentence on what is wrong with the file.
Table packed_header(const TensorFile& file);

/// The sides of member m of the family, or of the only one, whose numbers stay in the file, as does the
/// sheet. Errors as above.
PerSide<SideMemory> packed_member(const TensorFile& file, const Table& header, std::size_t m,
                                  const PathSheetView& sheet);

/// The path law of a file: where that has none of it, `own` is worked out and referred to; nothing of
/// families whose members differ in it. Errors as above.
PathSheetView path_sheet(const TensorFile& file, const Table& header, PathSheet& own);

void require_aligned(const void* data, const std::string& name);

template <class Number>
void require_shape(const TensorOf<Number>& numbers, const std::string& name,
                   const TensorShape& shape) {
    require(numbers.shape == shape, packed_caller, "shape of " + name, list_text(shape),
            list_text(numbers.shape));
}

}  // namespace stratus
