// Tables on disk: TABLE.h5 (HDF5, netCDF-4 rules) and TABLE.exr (OpenEXR, multi-part), lossless
// into one another.
//
// A reader trusts nothing: format name, version, every extent, type, finiteness and checksum are
// checked before a sample is used; a truncated, corrupted or foreign file is refused with its
// reason. Newer minor versions are read, newer major ones refused by name. Writing is atomic
// (atomic_file.h).
#pragma once

#include <stratus/runtime/table.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace stratus {

constexpr const char* table_format_name = "stratus-table";
constexpr int table_format_major = 1;
constexpr int table_format_minor = 0;
constexpr int table_format_minor_of_mixtures = 1;  // of files that hold a mixture axis

struct ReadOptions {
    /// Bytes that the file, its samples and what they are inflated in may take; 0: half of the
    /// machine's memory.
    std::uintmax_t max_memory = 0;
    /// Where notes for the user go, each naming the file: that it is of a newer minor version, of
    /// which what is new is not used.
    std::vector<std::string>* notes = nullptr;
};

/// Reads a table by its file name's ending, .h5 or .exr.
///
/// Errors   std::invalid_argument for another ending; std::runtime_error "PATH: reason" for a file
///          that is missing, unreadable, damaged, of another kind, or would take more memory than
///          allowed, which is known before it is taken.
Table read_table(const std::filesystem::path& path, const ReadOptions& options = {});

/// Writes a table by its file name's ending, .h5 or .exr; an existing file is replaced only by a
/// complete one.
///
/// Range    names of `attributes` are 1 to 200 bytes long and none of the format's own (`format`,
///          `moments`, `checksum`, ...); names and texts have no zero bytes, texts any length.
/// Errors   std::invalid_argument for another ending, or a table that no reader would accept;
///          std::runtime_error "PATH: reason" for what the system refuses.
void write_table(const Table& table, const std::filesystem::path& path);

}  // namespace stratus
