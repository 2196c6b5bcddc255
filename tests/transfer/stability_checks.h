// Checks that hold for every layer that the solver accepts.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/transfer/solve.h>

#include "stability_matrix.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

namespace stratus::test {

constexpr double rounding = 1e-15;

inline std::string at(const LayerSolution& layer) {
    std::ostringstream text;
    text << "albedo 1 - " << 1 - layer.albedo << ", depth " << layer.optical_depth;
    return text.str();
}

/// R (side 0) or T (side 1) between two cosines of a layer.
struct LayerValue {
    int side;
    SolvedValue value;
    double single;  // scattering of a phase function of value 1
    int i, j;
};

/// All R and T at some azimuths.
inline std::vector<LayerValue> values_of(const LayerSolution& layer) {
    const std::vector<double> azimuths{0.0, 1.0, pi / 2, 2.2, pi};
    std::vector<LayerValue> values;
    for (int i = 0; i < layer.mu.size(); ++i)
        for (int j = 0; j < layer.mu.size(); ++j) {
            const double R1 = single_reflection(1, layer.albedo, layer.optical_depth, layer.mu(i),
                                                layer.mu(j)),
                         T1 = single_transmission(1, layer.albedo, layer.optical_depth, layer.mu(i),
                                                  layer.mu(j));
            for (const SolvedValue& R : layer.values(Side::reflection, i, j, azimuths))
                values.push_back({0, R, R1, i, j});
            for (const SolvedValue& T : layer.values(Side::transmission, i, j, azimuths))
                values.push_back({1, T, T1, i, j});
        }
    return values;
}

inline void expect_finite(const LayerSolution& layer, const std::vector<LayerValue>& values) {
    for (const auto* modes : {&layer.modes.reflection, &layer.modes.transmission})
        for (const AzimuthalMode& mode : *modes) ASSERT_TRUE(mode.values.allFinite()) << at(layer);
    for (const LayerValue& of : values) EXPECT_TRUE(std::isfinite(of.value.total)) << at(layer);
}

/// R or T is negative only where the phase series is: the most negative.
inline double expect_negative_only_with_its_series(const LayerSolution& layer) {
    const double lowest = most_negative(layer);
    if (lowest_of_series(layer.truncation.moments) >= -1e-9) {
        EXPECT_GE(lowest, -1e-9) << at(layer);
    }
    return lowest;
}

}  // namespace stratus::test
