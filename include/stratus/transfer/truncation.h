// Peaked phase functions: delta-M truncation and the single scattering that goes with it.
//
// [W77]: of a phase function with more moments than the quadrature resolves, the share f = chi_L is
// taken as scattered straight on, that is, not at all:
//
//     tau* = (1 - w f) tau      w* = w (1 - f)/(1 - w f)      chi*_l = (chi_l - f)/(1 - f), l < L
//
// [NT88], TMS: single scattering is then added in closed form with the true phase function, albedo
// w*/(1 - f) and tau*.
#pragma once

#include <vector>

#include <stratus/runtime/phase_function.h>

namespace stratus {

/// The truncated problem for L moments; f = 0 leaves everything as it was.
struct Truncation {
    double fraction = 0;          // f
    std::vector<double> moments;  // chi*_l, l < L

    double optical_depth(double tau, double albedo) const;  // tau*
    double albedo(double albedo) const;                     // w*
    double co_albedo(double albedo) const;                  // 1 - w*, exactly 0 at w = 1
    double single_scattering_albedo(double albedo) const;   // w*/(1 - f)
};

/// Truncates at L = `moment_count`; f = chi_L where the peak is a forward one (chi_L above rounding
/// and chi_{L+1} positive), else 0.
Truncation delta_m(const PhaseFunction& phase_function, int moment_count);

/// The first `moment_count` moments as they are, f = 0.
Truncation no_truncation(const PhaseFunction& phase_function, int moment_count);

}  // namespace stratus
