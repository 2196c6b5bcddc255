#include <stratus/io/table_file.h>

#include <stratus/io/atomic_file.h>
#include <stratus/io/exr_table.h>
#include <stratus/io/hdf5_table.h>
#include <stratus/runtime/argument.h>

#include "file_bytes.h"
#include "table_content.h"

namespace stratus {
namespace {

enum class Format { hdf5, exr };

Format format_of(const std::filesystem::path& path, const char* function) {
    const std::string ending = path.extension().string();
    require(ending == ".h5" || ending == ".exr", function, "path", "a name ending in .h5 or .exr",
            path.string());
    return ending == ".h5" ? Format::hdf5 : Format::exr;
}

io::Bytes encode(const Table& table, Format format) {
    const io::Metadata metadata = io::metadata_of(table);
    return format == Format::hdf5 ? io::encode_hdf5(table, metadata)
                                  : io::encode_exr(table, metadata);
}

void write_directly(const Table& table, const std::filesystem::path& path, Format format) {
    io::check_table(table);
    io::naming(path, [&] { io::write_bytes(path, encode(table, format)); });
}

/// Calls `read`, and names the path in its errors and in the notes that it adds.
template <class Read>
Table naming_notes(const std::filesystem::path& path, std::vector<std::string>* notes,
                   const Read& read) {
    const std::size_t before = notes ? notes->size() : 0;
    Table table = io::naming(path, read);
    for (std::size_t n = before; notes && n < notes->size(); ++n)
        (*notes)[n] = path.string() + ": " + (*notes)[n];
    return table;
}

}  // namespace

Table read_hdf5_table(const std::filesystem::path& path, const ReadOptions& options) {
    return naming_notes(path, options.notes, [&] {
        io::MemoryLimit limit(options.max_memory);
        return io::decode_hdf5(io::read_bytes(path, io::hdf5_magic, "an HDF5", limit), limit,
                               options.notes);
    });
}

Table read_exr_table(const std::filesystem::path& path, const ReadOptions& options) {
    return naming_notes(path, options.notes, [&] {
        io::MemoryLimit limit(options.max_memory);
        return io::decode_exr(io::read_bytes(path, io::exr_magic, "an OpenEXR", limit), limit,
                              options.notes);
    });
}

void write_hdf5_table(const Table& table, const std::filesystem::path& path) {
    write_directly(table, path, Format::hdf5);
}

void write_exr_table(const Table& table, const std::filesystem::path& path) {
    write_directly(table, path, Format::exr);
}

Table read_table(const std::filesystem::path& path, const ReadOptions& options) {
    return format_of(path, "read_table") == Format::hdf5 ? read_hdf5_table(path, options)
                                                         : read_exr_table(path, options);
}

void write_table(const Table& table, const std::filesystem::path& path) {
    const Format format = format_of(path, "write_table");
    io::check_table(table);
    const io::Bytes bytes = io::naming(path, [&] { return encode(table, format); });
    write_atomically(path, [&](const auto& temporary) { io::write_bytes(temporary, bytes); });
}

}  // namespace stratus
