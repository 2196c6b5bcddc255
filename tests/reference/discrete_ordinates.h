// The reference values of discrete_ordinates*.csv, layer by layer.
#pragma once

#include <stratus/phase/phase_function.h>

#include "../base/csv_rows.h"

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus::test {

/// What the phase column of the files means.
inline PhaseFunction reference_phase_function(const std::string& name) {
    static const std::map<std::string, std::string> texts{
        {"iso", "isotropic"},
        {"rayl", "rayleigh"},
        {"lin", "anisotropic:x=-0.5"},
        {"dhg", "0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5"},
        {"lambert", "lambert_sphere"},
        {"hg50", "henyey_greenstein:g=0.5"},
        {"hg75", "henyey_greenstein:g=0.75"},
        {"hg85", "henyey_greenstein:g=0.85"},
        {"hg95", "henyey_greenstein:g=0.95"},
    };
    return parse_phase_function(texts.at(name));
}

/// One layer of a file: `rows[r][c]` holds the columns after phase, w and tau.
struct ReferenceLayer {
    double albedo = 0, optical_depth = 0;
    std::vector<std::vector<double>> rows;
};

/// All layers of one phase function in a file of tests/reference.
///
/// Errors   std::runtime_error for a missing file, a line that is not numbers, a file without such
///          rows.
inline std::vector<ReferenceLayer> read_reference(const std::string& file_name,
                                                  const std::string& phase) {
    std::vector<ReferenceLayer> layers;
    for (const auto& [label, numbers] : csv_rows(file_name)) {
        if (label != phase) continue;
        const double albedo = numbers.at(0), depth = numbers.at(1);
        if (layers.empty() || albedo != layers.back().albedo ||
            depth != layers.back().optical_depth)
            layers.push_back({albedo, depth, {}});
        layers.back().rows.push_back({numbers.begin() + 2, numbers.end()});
    }
    if (layers.empty()) throw std::runtime_error(file_name + ": no rows for " + phase);
    return layers;
}

}  // namespace stratus::test
