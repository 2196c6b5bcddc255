// TABLE.exr: the same table as float images, for renderers and GPUs that already read OpenEXR.
//
// One part for each dataset, with the same name, one channel Y of 32-bit floats and a data window
// that begins at 0, 0:
//
//     reflection_multiple,     one row of tiles per albedo, one column of tiles per optical depth;
//     transmission_multiple    in a tile row = mu_in, column = mu_out * azimuth_count + azimuth
//     plane_albedo,            row = albedo * optical_depth_count + optical_depth, column = mu_in
//     diffuse_transmittance
//     spherical_albedo         row = albedo, column = optical_depth
//
// The rest is text in attributes of the first part: `stratus:NAME` is the attribute NAME of the
// root of TABLE.h5, `dataset:NAME` the numbers of an axis or of the diffusion exponent. Equal
// tables make equal files.
#pragma once

#include <stratus/io/table_file.h>
#include <stratus/table/table.h>

#include <filesystem>

namespace stratus {

/// Like `read_table` and `write_table` (table_file.h), for any name; `write_exr_table` writes to
/// `path` directly, not atomically.
///
/// Errors   std::runtime_error also for a picture of more than 2^24 rows or columns.
Table read_exr_table(const std::filesystem::path& path, const ReadOptions& options = {});
void write_exr_table(const Table& table, const std::filesystem::path& path);

}  // namespace stratus
