// The phase function of a cloud of water droplets of 10 um: 7,000 straight on, and a rainbow.
#pragma once

#include <stratus/phase/phase_function.h>

#include "csv_rows.h"

#include <vector>

namespace stratus {

inline PhaseFunction water_cloud() {
    std::vector<double> chi;
    for (const CsvRow& row : csv_rows("water_cloud_10um_moments.csv"))
        chi.push_back(row.numbers.at(1));
    return PhaseFunction::from_moments(chi);
}

}  // namespace stratus
