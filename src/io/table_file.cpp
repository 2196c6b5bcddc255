#include <stratus/io/table_file.h>

#include <stratus/io/atomic_file.h>
#include <stratus/io/exr_table.h>
#include <stratus/io/hdf5_table.h>
#include <stratus/runtime/argument.h>

#include "file_bytes.h"
#include "table_content.h"

namespace stratus {
namespace {

struct Format {
    std::string_view magic;
    const char* kind;
    io::Bytes (*encode)(const Table&, const io::Metadata&);
    Table (*decode)(const io::Bytes&, const ReadOptions&);
};

constexpr Format hdf5{io::hdf5_magic, "an HDF5", io::encode_hdf5, io::decode_hdf5};
constexpr Format exr{io::exr_magic, "an OpenEXR", io::encode_exr, io::decode_exr};

const Format& format_of(const std::filesystem::path& path, const char* function) {
    const std::string extension = path.extension().string();
    require(extension == ".h5" || extension == ".exr", function, "path",
            "a name ending in .h5 or .exr", path.string());
    return extension == ".h5" ? hdf5 : exr;
}

io::Bytes encode(const Table& table, const std::filesystem::path& path, const Format& format) {
    io::check_table(table);
    return io::naming(path, [&] { return format.encode(table, io::metadata_of(table)); });
}

void write_directly(const Table& table, const std::filesystem::path& path, const Format& format) {
    const io::Bytes bytes = encode(table, path, format);
    io::naming(path, [&] { io::write_bytes(path, bytes); });
}

/// Reads a table, and names the path in errors and notes.
Table read(const std::filesystem::path& path, const ReadOptions& options, const Format& format) {
    std::vector<std::string> notes;
    ReadOptions noting = options;
    noting.notes = &notes;
    Table table = io::naming(path, [&] {
        io::MemoryLimit limit(options.max_memory);
        const io::Bytes bytes = io::read_bytes(path, format.magic, format.kind, limit);
        try {
            return format.decode(bytes, noting);
        } catch (const io::NotAsSealed& error) {
            throw std::runtime_error(std::string(error.what()) + "; if on purpose, `stratus seal " +
                                     path.string() + "`");
        }
    });
    if (options.notes)
        for (const std::string& note : notes) options.notes->push_back(path.string() + ": " + note);
    return table;
}

}  // namespace

Table read_hdf5_table(const std::filesystem::path& path, const ReadOptions& options) {
    return read(path, options, hdf5);
}

Table read_exr_table(const std::filesystem::path& path, const ReadOptions& options) {
    return read(path, options, exr);
}

void write_hdf5_table(const Table& table, const std::filesystem::path& path) {
    write_directly(table, path, hdf5);
}

void write_exr_table(const Table& table, const std::filesystem::path& path) {
    write_directly(table, path, exr);
}

Table read_table(const std::filesystem::path& path, const ReadOptions& options) {
    return read(path, options, format_of(path, "read_table"));
}

void write_table(const Table& table, const std::filesystem::path& path) {
    const Format& format = format_of(path, "write_table");
    const io::Bytes bytes = encode(table, path, format);
    write_atomically(path, [&](const auto& temporary) { io::write_bytes(temporary, bytes); });
}

}  // namespace stratus
