// What a table file holds, whatever its format: the datasets, the metadata around them, their
// checksums and limits.
//
// Datasets run over the first axes of the table in order: reflection and transmission over all
// five, plane albedo and diffuse transmittance over three, spherical albedo over two, the diffusion
// exponent over one; where the table has a mixture axis, all of them over that one first. Metadata
// is text by name; the kind of each of the format's own entries says which texts are numbers.
// Numbers become the shortest text that reads back as the same bits, so one checksum of names and
// texts serves both formats.
#pragma once

#include <stratus/runtime/table.h>

#include "file_bytes.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace stratus::io {

struct AxisField {
    const char* name;
    const char* units;
    const char* long_name;
    Axis Table::*axis;
};

struct SampleField {
    const char* name;
    const char* long_name;
    std::size_t rank;  // without the mixture
    std::vector<float> Table::*samples;
};

inline constexpr std::array<AxisField, 5> axis_fields{{
    {"albedo", "1", "single-scattering albedo", &Table::albedo},
    {"optical_depth", "1", "optical depth of the layer", &Table::optical_depth},
    {"mu_in", "1", "cosine of the incident direction to the normal", &Table::mu_in},
    {"mu_out", "1", "cosine of the outgoing direction to the normal", &Table::mu_out},
    {"azimuth", "radian", "azimuth between the two directions of propagation", &Table::azimuth},
}};

inline constexpr AxisField mixture_field{
    "mixture", "1", "share of phase_function in all that is scattered", &Table::mixture};

inline constexpr std::array<SampleField, 5> sample_fields{{
    {"reflection_multiple", "reflection, orders of scattering from 2", 5,
     &Table::reflection_multiple},
    {"transmission_multiple", "diffuse transmission, orders of scattering from 2", 5,
     &Table::transmission_multiple},
    {"plane_albedo", "plane albedo, all orders", 3, &Table::plane_albedo},
    {"diffuse_transmittance", "diffuse transmittance, all orders", 3,
     &Table::diffuse_transmittance},
    {"spherical_albedo", "spherical albedo, all orders", 2, &Table::spherical_albedo},
}};

inline constexpr const char* diffusion_exponent_name = "diffusion_exponent";
inline constexpr const char* diffusion_exponent_long_name =
    "decay of the light field with optical depth, deep inside the layer";

/// Name of every checksum, beside what it covers.
inline constexpr const char* checksum_name = "checksum";

/// Attributes of a file by name, as text; the checksum over them is not one of them.
using Metadata = std::map<std::string, std::string>;

/// Text from a file as a message may show it: short, and free of what disturbs a terminal.
std::string shown(std::string_view text);

enum class Kind { text, integer, number, numbers };

/// How an entry is typed where the format has types; every name that is not the format's own is
/// text.
Kind kind_of(const std::string& name);

/// Everything that the table holds besides its datasets, and what the format adds: name, version,
/// list of datasets.
Metadata metadata_of(const Table& table);

/// Checks that metadata is of this format and of a version that this program reads; looks at
/// nothing else.
void check_format(const Metadata& metadata);

/// Adds a note, without the file's name, where metadata is of a newer minor version than this
/// program writes.
void note_version(const Metadata& metadata, std::vector<std::string>* notes);

/// Fills all that `metadata_of` told.
void take_metadata(const Metadata& metadata, Table& table);

/// The sample datasets that a file says it holds.
std::vector<SampleField> listed_samples(const Metadata& metadata);

/// Counts the samples of a table whose axes have been read towards the limit, all of them before
/// the first is read. Each dataset's own size is checked as in `checked_count`, for a file of so
/// many bytes.
void take_memory(const Table& table, const std::vector<SampleField>& listed,
                 std::uintmax_t file_size, MemoryLimit& limit);

/// "crc32:xxxxxxxx" of bytes, and of the values' little-endian bytes.
std::string checksum(std::span<const char> bytes);
std::string checksum(std::span<const float> values);
std::string checksum(std::span<const double> values);

/// The same of names and texts in the order of their names, each ended by a zero byte.
std::string checksum(const Metadata& metadata);

/// Refuses `what` when its checksum is not the one that was stored with it.
void check_checksum(const std::string& what, const std::string& stored,
                    const std::string& computed);

/// Takes the checksum out of metadata as it was read, refusing it when it is not that of the other
/// entries.
void take_checksum(Metadata& metadata);

/// Refuses an axis whose scale, by its name in a file, is not the one that the axis has in memory.
void check_scale(const std::string& name, const Axis& axis, const std::string& stored);

/// The axes of a table, and those that a file must have by its metadata; the mixture first.
std::vector<AxisField> axis_fields_of(const Table& table);
std::vector<AxisField> axis_fields_of(const Metadata& metadata);

/// Sizes of the first `rank` axes, and of the mixture before them where there is one.
std::vector<std::size_t> extents(const Table& table, std::size_t rank);

/// Product of the extents, checked before memory is taken: it neither overflows nor goes beyond 8
/// GiB of elements, nor beyond what `stored` bytes can be inflated to.
std::size_t checked_count(const std::string& dataset, std::span<const std::size_t> extents,
                          std::size_t element_size, std::uintmax_t stored);

/// The shortest texts that read back as the same bits, separated by spaces.
std::string to_text(std::span<const double> values);

/// From text; std::runtime_error naming `what`.
double to_number(const std::string& what, std::string_view text);
int to_integer(const std::string& what, std::string_view text);
std::vector<double> to_numbers(const std::string& what, std::string_view text);

/// The entry `name`; std::runtime_error when there is none.
const std::string& entry(const Metadata& metadata, const std::string& name);

/// Refuses, with std::invalid_argument, a table that no reader would accept back.
void check_table(const Table& table);

// The formats themselves, file <-> memory. Errors: std::exception without the file's name, which
// `naming` adds.
inline constexpr std::string_view hdf5_magic{"\x89HDF\r\n\x1a\n", 8};
inline constexpr std::string_view exr_magic{"\x76\x2f\x31\x01", 4};
Bytes encode_hdf5(const Table& table, const Metadata& metadata);
Table decode_hdf5(const Bytes& bytes, MemoryLimit limit = MemoryLimit(),
                  std::vector<std::string>* notes = nullptr);
Bytes encode_exr(const Table& table, const Metadata& metadata);
Table decode_exr(const Bytes& bytes, MemoryLimit limit = MemoryLimit(),
                 std::vector<std::string>* notes = nullptr);

}  // namespace stratus::io
