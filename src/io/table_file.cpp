#include <stratus/io/table_file.h>

#include <stratus/base/argument.h>
#include <stratus/io/csv.h>

#include "table_content.h"

#include <fcntl.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace stratus {
namespace {

struct Format {
    std::string_view magic;
    const char* kind;
    void (*write)(const Table&, const Metadata&, const fs::path&, const WriteOptions&);
    Table (*decode)(const io::Bytes&, const ReadOptions&);
};

constexpr Format hdf5{hdf5_magic, "an HDF5", io::write_hdf5, io::decode_hdf5};
constexpr Format exr{exr_magic, "an OpenEXR", io::write_exr, io::decode_exr};

const Format& find_format(const fs::path& path,
                          const std::string& allowed = "a name ending in .h5 or .exr") {
    const std::string extension = path.extension().string();
    require(extension == ".h5" || extension == ".exr", "table", "file", allowed, path.string());
    return extension == ".h5" ? hdf5 : exr;
}

/// Reads a table, and names the path in errors.
Table read(const fs::path& path, const ReadOptions& options, const Format& format) {
    return io::naming(path, [&] {
        io::MemoryLimit limit(options.max_memory);
        const io::Bytes bytes = io::read_bytes(path, format.magic, format.kind, limit);
        try {
            return format.decode(bytes, options);
        } catch (const io::NotAsSealed& error) {
            throw std::runtime_error(std::string(error.what()) + "; if on purpose, `stratus seal " +
                                     path.string() + "`");
        }
    });
}

}  // namespace

Table read_table(const fs::path& path, const ReadOptions& options) {
    return read(path, options, find_format(path));
}

AnyTable read_any_table(const fs::path& path, const ReadOptions& options) {
    if (path.extension() == packed_ending) return PackedTable(path.string());
    return read(path, options, find_format(path, "a name ending in .stratus, .h5 or .exr"));
}

void write_table(const Table& table, const fs::path& path, int threads) {
    write_table(table, path, WriteOptions{threads, {}, nullptr});
}

void write_table(const Table& table, const fs::path& path, const WriteOptions& options) {
    const Format& format = find_format(path);
    io::check_table(table, options.samples == nullptr);
    const auto write = [&](const fs::path& temporary) {
        io::naming(path,
                   [&] { format.write(table, io::make_metadata(table), temporary, options); });
    };
    write_atomically(path, write);
}

struct SampleFiles::File {
    /// Errors   std::system_error where the system refuses.
    File(const fs::path& folder, const PerSide<std::size_t>& of_sides)
        : descriptor(io::Descriptor::unnamed_in(folder)),
          size(std::max<std::size_t>(1, of_sides.reflection + of_sides.transmission) *
               sizeof(float)),
          first{0, of_sides.reflection},
          counts(of_sides) {
        const int number = descriptor.number();
        if (::fallocate(number, 0, 0, static_cast<off_t>(size)) == 0)
            mapped = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, number, 0);
        if (mapped == MAP_FAILED) throw std::system_error(errno, std::generic_category());
    }
    ~File() { ::munmap(mapped, size); }
    File(const File&) = delete;
    File& operator=(const File&) = delete;

    const io::Descriptor descriptor;
    const std::size_t size;                    // bytes
    const PerSide<std::size_t> first, counts;  // samples of each side
    void* mapped = MAP_FAILED;
};

SampleFiles::SampleFiles(fs::path folder) : folder_(std::move(folder)) {}
SampleFiles::~SampleFiles() = default;

bool SampleFiles::make_room(const PerSide<std::size_t>& counts) {
    file_.reset();
    try {
        file_ = std::make_unique<File>(folder_.empty() ? "." : folder_, counts);
    } catch (const std::system_error&) {
        return false;
    }
    return true;
}

void SampleFiles::write(Side side, std::size_t first, std::span<const float> samples) {
    const std::size_t at = file_->first[side] + first;
    file_->descriptor.write_at(
        at * sizeof(float), {reinterpret_cast<const char*>(samples.data()), samples.size_bytes()});
}

std::span<const float> SampleFiles::samples(Side side) const noexcept {
    return {static_cast<const float*>(file_->mapped) + file_->first[side], file_->counts[side]};
}

void SampleFiles::release() const noexcept { ::madvise(file_->mapped, file_->size, MADV_DONTNEED); }

namespace {

/// The column of a name, or of either of "one or other".
int find_column(const CsvTable& file, const std::string& wanted) {
    constexpr std::string_view between = " or ";
    const std::size_t gap = wanted.find(between);
    if (gap == wanted.npos) return file.column(wanted);
    const std::string one = wanted.substr(0, gap), other = wanted.substr(gap + between.size());
    if (file.has_column(one) && file.has_column(other))
        throw std::invalid_argument(file.name + ": columns must be " + wanted + ", got both");
    return file.column(file.has_column(other) ? other : one);
}

PhaseColumns find_columns(const CsvTable& file, const std::vector<std::string>& wanted) {
    PhaseColumns columns;
    columns.name = file.name;
    for (const std::string& column : wanted) {
        const std::size_t at = size(find_column(file, column));
        columns.names.push_back(file.columns[at]);
        std::vector<double>& values = columns.values.emplace_back();
        for (const std::vector<double>& row : file.rows) values.push_back(row[at]);
    }
    columns.row_name = [name = file.name, lines = file.lines](std::size_t row) {
        return " (" + name + ", line " + std::to_string(lines[row]) + ")";
    };
    return columns;
}

}  // namespace

PhaseFunction read_phase_function(const std::string& text, const std::string& directory,
                                  std::vector<std::string>* notes) {
    return parse_phase_function(
        text, notes, [&](const std::string& file, const std::vector<std::string>& columns) {
            return find_columns(read_csv((fs::path(directory) / file).string()), columns);
        });
}

}  // namespace stratus
