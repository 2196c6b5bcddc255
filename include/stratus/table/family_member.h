// One member of a family of phase functions (phase_family.h) as a table of its own, wherever it lies
// between the samples: for what reads no axes of a family, as shaders do.
#pragma once

#include <stratus/phase/phase_family.h>
#include <stratus/phase/phase_function.h>
#include <stratus/table/table.h>

#include <optional>

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

}  // namespace stratus
