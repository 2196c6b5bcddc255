// Peaked phase functions: truncation of the forward peak and the single scattering that goes with
// it.
//
// Where a phase function has more moments than the quadrature resolves, a share f of the light is
// treated as unscattered [W77]:
//
//     tau* = (1 - w f) tau      w* = w (1 - f)/(1 - w f)
//     chi*_l = (chi_l - f p_l)/(1 - f),   l < L
//
// delta-M ends the series abruptly, f = chi_L and p_l = 1, and leaves a phase function that ripples
// at all angles. Where f exceeds 1e-4, p_l falls off smoothly over the last moments instead, so
// that a narrow peak is removed: with g = 0.99 and 48 nodes the errors are 100 times smaller
// (docs/accuracy.md).
//
// A backward peak cannot pass for unscattered light. Where |chi_L| exceeds 1e-7, the series of a
// narrow one ends smoothly, chi*_l = chi_l p_l and f = 0; what that changes is known in closed form
// (backward_path.h).
//
// [NT88], TMS: single scattering is then added in closed form with the true phase function, albedo
// w*/(1 - f) and tau*. Multiple scattering in a narrow peak: truncated_path.h.
#pragma once

#include <stratus/phase/phase_function.h>

#include <vector>

namespace stratus {

/// The truncated problem for L moments; f = 0 changes nothing.
struct Truncation {
    double fraction = 0;          // f
    std::vector<double> moments;  // chi*_l, l < L
    bool narrow = false;          // p_l falls off smoothly
    bool backward = false;        // the series of a backward peak, which ends smoothly

    double optical_depth(double tau, double albedo) const;  // tau*
    double albedo(double albedo) const;                     // w*
    double co_albedo(double albedo) const;                  // 1 - w*, exactly 0 at w = 1
    double single_scattering_albedo(double albedo) const;   // w*/(1 - f)
};

/// Truncates to L = `moment_count` moments where the peak is a forward one (chi_L above rounding
/// and chi_{L+1} positive), or ends the series of a narrow backward one smoothly;
/// else f = 0. At least the moments below 0.4 L stay exact, f + (1 - f) chi*_l = chi_l. `delta_m`:
/// of forward peaks, delta-M whatever the share.
Truncation truncate_peak(const PhaseFunction& phase_function, int moment_count,
                         bool delta_m = false);

/// The first `moment_count` moments as they are, f = 0.
Truncation no_truncation(const PhaseFunction& phase_function, int moment_count);

}  // namespace stratus
