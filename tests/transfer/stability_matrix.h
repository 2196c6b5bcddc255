// Hard cases: every kind of phase function, thin to infinite, black to white, few nodes to many.
// For the stability tests and the benchmark that compares textbook doubling on them.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/phase/phase_function.h>
#include <stratus/transfer/solve.h>
#include <stratus/transfer/truncation.h>

#include "../base/indices.h"

#include <algorithm>
#include <string>
#include <vector>

namespace stratus::test {

struct NamedPhaseFunction {
    std::string name;
    PhaseFunction phase_function;
};

inline std::vector<NamedPhaseFunction> stability_phase_functions() {
    return {{"isotropic", PhaseFunction::isotropic()},
            {"rayleigh", PhaseFunction::rayleigh()},
            {"lambert_sphere", PhaseFunction::lambert_sphere()},
            {"saturn", parse_phase_function("0.596*henyey_greenstein:g=-0.5 + "
                                            "0.404*henyey_greenstein:g=0.5")},
            {"backward090", PhaseFunction::henyey_greenstein(-0.9)},
            {"forward075", PhaseFunction::henyey_greenstein(0.75)},
            {"forward090", PhaseFunction::henyey_greenstein(0.9)},
            {"forward099", PhaseFunction::henyey_greenstein(0.99)},
            {"forward09999", PhaseFunction::henyey_greenstein(0.9999)}};
}

inline const std::vector<double> stability_albedos{0, 1e-12, 0.3, 0.99, 1 - 1e-9, 1 - 1e-15, 1};
inline const std::vector<double> stability_depths{0,  1e-300, 1e-12, 1e-6,    1,
                                                  64, 1e6,    1e12,  infinity};
inline const std::vector<double> stability_cosines{1e-6, 0.01, 0.3, 1};

/// Smallest value of the phase series that the solver used, as a share of its largest one.
inline double lowest_of_series(const std::vector<double>& moments) {
    std::vector<double> coefficients = moments;
    for (const auto l : indices(moments)) coefficients[l] *= 2 * static_cast<double>(l) + 1;
    double lowest = 0, highest = 0;
    for (int k = -1000; k <= 1000; ++k) {
        const double sum = sum_legendre(coefficients, k / 1000.0);
        lowest = std::min(lowest, sum);
        highest = std::max(highest, sum);
    }
    return lowest / highest;
}

/// The most negative R or T between any cosines of a layer, as a share of the largest value (both
/// times mu + mu0, which cancels their growth at grazing angles); 0 when none is negative.
inline double most_negative(const LayerSolution& layer) {
    constexpr double rounding = 1e-15;
    std::vector<double> azimuths;
    for (int k = 0; k <= 64; ++k) azimuths.push_back(k * pi / 64);
    double share = 0;
    for (const Side side : both_sides) {
        double lowest = 0, highest = 0;
        for (int i = 0; i < layer.mu.size(); ++i)
            for (int j = 0; j <= i; ++j)
                for (const SolvedValue& value : layer.values(side, i, j, azimuths)) {
                    const double scaled = (layer.mu(i) + layer.mu(j)) * value.total;
                    if (value.total < -rounding) lowest = std::min(lowest, scaled);
                    highest = std::max(highest, scaled);
                }
        if (lowest < 0) share = std::min(share, lowest / std::max(highest, -lowest));
    }
    return share;
}

}  // namespace stratus::test
