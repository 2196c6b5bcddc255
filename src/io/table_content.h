// The content of a table file, independent of its format: datasets, metadata, checksums and limits.
//
// Datasets run over the first axes of the table in order: reflection and transmission over all
// five, plane albedo and diffuse transmittance over three, spherical albedo over two, the diffusion
// exponent over one. The axes of a family precede these in all of them. Metadata is text by name, so
// that one checksum over names and texts serves both formats.
#pragma once

#include <stratus/base/size.h>
#include <stratus/io/file_bytes.h>
#include <stratus/io/table_file.h>
#include <stratus/io/write_options.h>
#include <stratus/table/metadata.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace stratus::io {

/// Name of the attribute that holds a checksum, of metadata and of each dataset.
inline constexpr const char* checksum_name = "checksum";

/// Name of the attribute that lists what the checksum of an HDF5 file's metadata covers, a name a
/// line: attributes that others add are their own business.
inline constexpr const char* checksum_covers = "checksum_covers";

/// Returns the type of an attribute in formats that have types.
MetadataEntry::Type entry_type(const std::string& name);

/// Whether the format gives an entry of this name a meaning.
bool is_of_the_format(const std::string& name);

/// The entries of a table, and what these formats add: name, version, list of datasets, moments.
Metadata make_metadata(const Table& table);

/// Checks the format's name, version and features and nothing else.
void check_format(const Metadata& metadata);

/// The table that `make_metadata` described, still without axes and samples.
Table table_without_samples(const Metadata& metadata);

/// The sample datasets that a file says it holds.
std::vector<SampleField> listed_samples(const Metadata& metadata);

/// Completes a table whose axes have been read: counts its samples towards the limit, the size of each
/// dataset checked as in `checked_count`, given the size of the file; then reads them, read(field).
void read_samples(Table& table, const Metadata& metadata, std::uintmax_t file_size,
                  MemoryLimit& limit,
                  const std::function<std::vector<float>(const SampleField& field)>& read);

/// "crc32:xxxxxxxx" of bytes that need not be in memory at once: calls read(), if given, after every few.
std::string checksum(std::span<const std::byte> bytes, const std::function<void()>& read = {});

/// Checksum of names and texts, each followed by a zero byte, in the order of the names.
std::string checksum(const Metadata& metadata);

/// Removes the entry `name` and returns its text; nothing if there is none.
std::optional<std::string> take(Metadata& metadata, const std::string& name);

/// Thrown for a table that is not as it was when its checksums were written.
class NotAsSealed : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Throws NotAsSealed unless `what` has a stored checksum, and it is the computed one.
void check_checksum(const std::string& what, const std::optional<std::string>& stored,
                    const std::string& computed);

/// How many samples there are along each dimension, the last one contiguous.
using Extents = std::span<const std::size_t>;

/// Product of extents, to be asked for before memory is allocated: throws std::runtime_error
/// where it is 0, beyond 8 GiB of elements, or more than `stored` bytes can be inflated to.
std::size_t checked_count(const std::string& dataset, Extents extents, std::size_t element_size,
                          std::uintmax_t stored);

/// Throws std::invalid_argument for a table that no reader would accept.
void check_table(const Table& table, bool with_samples = true);

// The formats themselves. Errors are std::exceptions without the file's name, which `naming` adds.
/// The file's bytes are never in memory at once.
void write_hdf5(const Table& table, const Metadata& metadata, const fs::path& path,
                const WriteOptions& options);
Table decode_hdf5(const Bytes& bytes, const ReadOptions& options);
void write_exr(const Table& table, const Metadata& metadata, const fs::path& path,
               const WriteOptions& options);
Table decode_exr(const Bytes& bytes, const ReadOptions& options);

/// Sets the scale of an axis from its name in a file, one of those that the axis may have; for an axis
/// of a family also that it is discrete. A linear scale goes by either of its names.
void read_scale(const AxisField& field, Table& table, const std::string& stored);

}  // namespace stratus::io
