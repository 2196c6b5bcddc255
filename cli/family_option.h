// The option --at of commands that take one member of a table's family: "radius=8,wavelength=0.55",
// by the names, and in the units, of a query's columns.
#pragma once

#include <stratus/phase/phase_family.h>
#include <stratus/table/packed_table.h>

#include "allowed.h"
#include "table_option.h"

#include <string>
#include <vector>

namespace stratus {

/// Its help. Where there are several, `more` says what they are for.
std::string at_help(const std::string& more = "");

/// The point that the option names, within the family; of a table without a family, none.
///
/// Errors   std::invalid_argument for what names no member of the family, for an option that is
///          missing, "", or given to a table without a family; `path`: the table's.
FamilyPoint point_of(const char* caller, const std::string& at,
                     const std::vector<FamilyAxis>& family, const std::string& path);

/// A number; of lengths um or nm may follow, um without it. Not-a-number where it is none.
double parameter_value(const std::string& text, PhaseParameter parameter);

/// A table ready for lookups, of one member where it has several.
PackedTable read_member(const char* caller, const std::string& path, const ReadOptions& options,
                        const std::string& at);

}  // namespace stratus
