#include <stratus/io/netcdf.h>

#include <stratus/base/argument.h>

#include "hdf5_parts.h"

#include <hdf5.h>
#include <hdf5_hl.h>

#include <cstddef>
#include <span>

namespace stratus {
namespace {

using namespace io::hdf5;

Handle write_dataset(hid_t file, const std::string& name, hid_t stored, hid_t memory,
                     std::span<const std::size_t> extents, const void* values) {
    Handle dataset = new_dataset(file, name, stored, extents);
    checked(H5Dwrite(dataset, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values),
            "write dataset " + name);
    return dataset;
}

void fill(hid_t file, const NetcdfGrid& grid, std::span<const std::size_t> extents) {
    std::vector<Handle> axes;
    for (const NetcdfDimension& axis : grid.dimensions) {
        const std::size_t size = axis.values.size();
        axes.push_back(write_dataset(file, axis.name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {&size, 1},
                                     axis.values.data()));
        checked(H5DSset_scale(axes.back(), axis.name.c_str()), "make a scale of " + axis.name);
        write_text(axes.back(), "units", axis.units);
        write_text(axes.back(), "long_name", axis.long_name);
    }
    const Handle variable = write_dataset(file, grid.name, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT,
                                          extents, grid.values.data());
    write_text(variable, "units", grid.units);
    write_text(variable, "long_name", grid.long_name);
    for (std::size_t d = 0; d < axes.size(); ++d)
        checked(H5DSattach_scale(variable, axes[d], static_cast<unsigned>(d)),
                "attach axis " + grid.dimensions[d].name);
    for (const auto& [name, text] : grid.attributes) write_text(file, name, text);
}

}  // namespace

void write_netcdf(const NetcdfGrid& grid, const std::filesystem::path& path) {
    std::vector<std::size_t> extents;
    std::size_t count = 1;
    for (const NetcdfDimension& axis : grid.dimensions) {
        extents.push_back(axis.values.size());
        count *= axis.values.size();
    }
    require(count == grid.values.size(), "write_netcdf", "values", std::to_string(count),
            grid.values.size());
    const QuietErrors quiet;
    write_file(path, [&](hid_t file) { fill(file, grid, extents); });
}

}  // namespace stratus
