// The phase function of a cloud of water droplets of 10 um: 7,000 straight on, and a rainbow.
#pragma once

#include <stratus/phase/phase_function.h>

#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {

inline PhaseFunction water_cloud() {
    std::ifstream file(STRATUS_REFERENCE_FOLDER "/water_cloud_10um_moments.csv");
    std::vector<double> chi;
    std::string row;
    std::getline(file, row);  // l,chi
    while (std::getline(file, row)) chi.push_back(std::stod(row.substr(row.find(',') + 1)));
    if (chi.size() != 768) throw std::runtime_error("water_cloud_10um_moments.csv: not 768 rows");
    return PhaseFunction::from_moments(chi);
}

}  // namespace stratus
