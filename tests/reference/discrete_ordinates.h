// The reference values of discrete_ordinates*.csv, layer by layer.
#pragma once

#include <stratus/phase/phase_function.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
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

/// A number of the file; some are below the smallest normal ones, which std::stod refuses.
inline double read_reference_number(const std::string& field) {
    char* end = nullptr;
    const double number = std::strtod(field.c_str(), &end);
    if (field.empty() || *end) throw std::runtime_error("not a number: '" + field + "'");
    return number;
}

/// All layers of one phase function in a file of tests/reference.
///
/// Errors   std::runtime_error for a missing file, a line that is not numbers, a file without such
///          rows.
inline std::vector<ReferenceLayer> read_reference(const std::string& file_name,
                                                  const std::string& phase) {
    std::ifstream file(STRATUS_REFERENCE_FOLDER "/" + file_name);
    std::vector<ReferenceLayer> layers;
    std::string last, line;
    while (std::getline(file, line)) {
        if (line.rfind(phase + ",", 0) != 0) continue;
        std::istringstream fields(line);
        std::string albedo, depth, field;
        std::getline(fields, field, ',');
        std::getline(fields, albedo, ',');
        std::getline(fields, depth, ',');
        if (layers.empty() || albedo + "," + depth != last)
            layers.push_back({read_reference_number(albedo), read_reference_number(depth), {}});
        last = albedo + "," + depth;
        std::vector<double>& row = layers.back().rows.emplace_back();
        while (std::getline(fields, field, ',')) row.push_back(read_reference_number(field));
    }
    if (layers.empty()) throw std::runtime_error(file_name + ": no rows for " + phase);
    return layers;
}

}  // namespace stratus::test
