// Parts of a table as something of their own: a member of its family as a table, a layer as a ground.
//
// One member of a family of phase functions (phase_family.h) as a table of its own, wherever it lies
// between the samples: for what reads no axes of a family, as shaders do.
#pragma once

#include <stratus/layer/lower_boundary.h>
#include <stratus/phase/phase_family.h>
#include <stratus/phase/phase_function.h>
#include <stratus/table/table.h>

#include <optional>
#include <string>

namespace stratus {

/// A table without a family, at one point of that of `table`: its phase function, single scattering
/// and path law are those of the very parameters, its samples what lookups give at this point. A
/// table without a family as it is, at no point.
///
/// Range    a value for each axis, in their order; in the range of its axis, or one of its values.
/// Errors   std::invalid_argument naming the axis, what is allowed and what was met.
Table table_at(const Table& table, const FamilyPoint& point);

/// The value of a parameter, in the only term that has it; none without such a term, with several,
/// and for `mixture`. The inverse of with_parameter.
std::optional<double> find_parameter(const PhaseFunction& phase_function, PhaseParameter parameter);

// Grounds by their texts; any table's layer may be one.

/// Reads an albedo, that of a Lambert surface; a law (ground_law.h); or
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
