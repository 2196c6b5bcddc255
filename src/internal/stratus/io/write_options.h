// How a table is written where its samples are on the disk, or others share the compressing.
#pragma once

#include <stratus/layer/single_scattering.h>
#include <stratus/table/table.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace stratus {

/// Samples of a table on the disk while it is baked, so that memory need not hold them.
///
/// Threads  `make_room` by one alone; all else by any.
class SampleFiles {
  public:
    explicit SampleFiles(std::filesystem::path folder);
    ~SampleFiles();
    SampleFiles(const SampleFiles&) = delete;
    SampleFiles& operator=(const SampleFiles&) = delete;

    /// Room for so many samples of reflection and of transmission, in a file without a name, which
    /// goes with the process; what it held before is lost. False where the folder has no such room.
    bool make_room(const PerSide<std::size_t>& counts);
    bool has_room() const noexcept { return file_ != nullptr; }

    /// Errors   std::system_error.
    void write(Side side, std::size_t first, std::span<const float> samples);

    /// Returns the samples as they lie in the file.
    std::span<const float> samples(Side side) const noexcept;

    /// Lets go of what `samples` has brought into memory.
    void release() const noexcept;

  private:
    struct File;
    const std::filesystem::path folder_;
    std::unique_ptr<File> file_;  // null: no room
};

/// The samples of a side while they are written: parts 0 .. count - 1, each to be deflated by
/// itself, with `deflate_part`, in this process or in another.
///
/// Threads  both functions are called by several at once.
struct PartsToDeflate {
    int count;
    std::function<std::vector<char>(int part)> give;
    /// Puts what `deflate_part` made of a part into the file, in their order: a part that comes
    /// before its time waits in memory.
    std::function<void(int part, std::span<const char> deflated)> take;
};

/// Bytes of samples of a part, at most.
constexpr std::size_t most_bytes_of_part = std::size_t{1} << 22;

/// Returns a part as it is stored in the file.
///
/// Errors   std::runtime_error for bytes that `give` did not give.
std::vector<char> deflate_part(std::span<const char> given);

struct WriteOptions {
    int threads = 0;  // that compress; 0: as many as the machine has
    /// For .h5: has all parts deflated and taken, each once, and returns then; empty: threads do it.
    std::function<void(const PartsToDeflate& parts)> share;
    /// For .h5: where both sides' samples are; null: in the table. A bake has checked them, and they
    /// are not checked again.
    const SampleFiles* samples = nullptr;
};

/// Writes the same bytes as write_table of table_file.h.
void write_table(const Table& table, const std::filesystem::path& path,
                 const WriteOptions& options);

// One variable over named axes, as a file that readers of netCDF-4 open: HDF5 with dimension scales.

struct NetcdfDimension {
    std::string name, units, long_name;
    std::vector<double> values;
};

struct NetcdfGrid {
    std::vector<NetcdfDimension> dimensions;
    std::string name, units, long_name;  // of the variable
    std::vector<float> values;           // over all dimensions, the last one contiguous
    std::map<std::string, std::string> attributes;
};

/// Writes to `path` directly; `write_atomically` makes it atomic.
///
/// Errors   std::invalid_argument when the extents do not multiply to the number of values;
///          std::runtime_error naming what HDF5 could not do.
/// Threads  one call at a time, unless the HDF5 library was built to be thread-safe.
void write_netcdf(const NetcdfGrid& grid, const std::filesystem::path& path);

}  // namespace stratus
