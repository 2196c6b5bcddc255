// Table files: TABLE.h5 (HDF5, netCDF-4 conventions) and TABLE.exr (multi-part OpenEXR). Converting
// between them loses nothing.
//
// Format name, version, every extent and checksum are checked, and samples must be finite. A
// truncated, damaged or foreign file is refused with a reason. HDF5 files, however, are decoded by
// the HDF5 library, which files made to harm can crash: read those of people whom you trust. Writing
// is atomic (file_bytes.h).
#pragma once

#include <stratus/phase/phase_function.h>
#include <stratus/table/packed_table.h>
#include <stratus/table/table.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace stratus {

constexpr const char* table_format_name = "stratus-table";
constexpr int table_format_version = 1;

struct ReadOptions {
    /// Limit in bytes for the file, its samples and, of OpenEXR files, the buffers to inflate them;
    /// 0: half of the machine's memory.
    std::uintmax_t max_memory = 0;
    /// Reads a table that was changed since its checksums were written; `write_table` writes new
    /// ones.
    bool ignore_checksums = false;
};

/// Reads a table by its file name's ending, .h5 or .exr.
///
/// Errors   std::invalid_argument for another ending; std::runtime_error "PATH: reason" for a file
///          that is missing, unreadable, damaged, of another kind, or needs more memory than
///          allowed, which is checked before it is allocated.
Table read_table(const std::filesystem::path& path, const ReadOptions& options = {});

/// A table of samples or a packed one, to be looked up.
class AnyTable {
  public:
    AnyTable(Table table) : own_(std::move(table)) {}
    AnyTable(PackedTable table) : own_(std::move(table)) {}
    AnyTable(AnyTable&&) = default;  // not copied: views point into it
    AnyTable& operator=(AnyTable&&) = default;

    /// Null where it is not packed.
    const PackedTable* packed() const { return std::get_if<PackedTable>(&own_); }

    /// Returns the table, of a packed one its header alone.
    const Table& table() const { return packed() ? packed()->header() : std::get<Table>(own_); }

    TableView view() const { return packed() ? packed()->view() : table().view(); }

  private:
    std::variant<Table, PackedTable> own_;
};

/// Reads a table by its file name's ending, .h5, .exr or .stratus.
///
/// Errors   those of read_table and PackedTable.
AnyTable read_any_table(const std::filesystem::path& path, const ReadOptions& options = {});

/// Writes a table by its file name's ending, .h5 or .exr. An existing file is replaced only by a
/// complete one.
///
/// Range    names of `attributes` are 1 to 200 bytes long, without line breaks, and not reserved by
///          the format (`format`, `moments`, `checksum`, ...); names and texts have no zero bytes,
///          texts any length. `threads` compress, 0: as many as the machine has; the file is the
///          same for any number of them.
/// Errors   std::invalid_argument for another ending, or a table that no reader would accept;
///          std::runtime_error "PATH: reason" for errors of the system.
void write_table(const Table& table, const std::filesystem::path& path, int threads = 0);

// Phase functions whose text names files: `tabulated:file=moon.csv`, `moments:file=haze.csv`,
// `mie:distribution=drops.csv,index=acid.csv`.

/// Reads the grammar of `parse_phase_function`, and the files that it names: CSV with the columns
/// phase_angle_deg and value, or l and chi; of mie wavelength_um, n and k, or radius_um and number.
///
/// Relative paths start from `directory`. What a user should be told (weights that did not sum to
/// 1, values or moments that were scaled, tables that were continued) is appended to `notes` when given.
///
/// Errors   std::invalid_argument naming the part or the file and line that is wrong, and what is
///          allowed; std::runtime_error for a file that cannot be opened.
PhaseFunction read_phase_function(const std::string& text, const std::string& directory = "",
                                  std::vector<std::string>* notes = nullptr);

}  // namespace stratus
