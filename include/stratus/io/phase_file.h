// Phase functions whose text names files: `tabulated:file=moon.csv`, `moments:file=haze.csv`,
// `mie:distribution=drops.csv,index=acid.csv`.
#pragma once

#include <stratus/phase/phase_function.h>

#include <string>
#include <vector>

namespace stratus {

/// Reads the grammar of `parse_phase_function`, and the files that it names: CSV with the columns
/// phase_angle_deg and value, or l and chi; of mie wavelength_um, n and k, or radius_um and number.
///
/// Relative paths start from `directory`. What a user should be told (weights that did not sum to
/// 1, values or moments that were scaled, tables that were continued) is appended to `notes` when given.
///
/// Errors   std::invalid_argument naming the part or the file and line that is wrong, and what is
///          allowed; std::runtime_error for a file that cannot be opened.
PhaseFunction read_phase_function(const std::string& text, const std::string& directory = "",
                                  std::vector<std::string>* notes = nullptr);

}  // namespace stratus
