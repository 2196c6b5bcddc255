// Grounds by their texts; any table's layer may be one.
#pragma once

#include <stratus/layer/lower_boundary.h>

#include <string>

namespace stratus {

/// Reads an albedo, that of a Lambert surface; a law (lower_boundary.h); or
/// `table:file=T.stratus,optical_depth=D,albedo=W`, the reflection of a table's layer, or of that
/// and its own lower boundary. What the table holds one of may be left out. Reciprocal: of tables
/// that are not, the mean of both ways is taken.
///
/// Range    a packed table without a family that knows the reflection of this layer in all
///          directions; `directory`: where its file is looked for.
/// Errors   std::invalid_argument naming what is wrong; std::runtime_error for files.
LowerBoundary read_ground(const std::string& text, const std::string& directory = "");

/// The forms of a ground's text, for `--help`.
std::string ground_help();

}  // namespace stratus
