// One variable over named axes, as a file that readers of netCDF-4 open: HDF5 with dimension scales.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace stratus {

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
