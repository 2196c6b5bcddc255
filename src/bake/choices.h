// The choices of a discretisation, a function an axis: ascending candidates in, the cheapest whose
// error holds out. Every choice builds on those that the probes' recipe holds already; the order is
// that of the declarations.
#pragma once

#include "probes.h"

#include <functional>
#include <optional>
#include <vector>

namespace stratus {

struct Choice {
    double value = 0;
    double error_at_cap = 0;  // where even the last candidate misses; 0 elsewhere
    double needed = 0;        // there: what would do, extrapolated; 0 where errors do not fall
};

/// Samples of an axis, and what they lie evenly in.
struct ScaledChoice {
    AxisScale scale;
    Choice samples;
};

Choice choose_nodes(Probes& probes);
Choice choose_modes(Probes& probes);
Choice choose_mu_samples(Probes& probes);

/// On the scale that the recipe fixes, or on the one that takes fewer samples; linear where both
/// take as many.
ScaledChoice choose_azimuth_samples(Probes& probes);

/// First depth of the ladder beyond which the law of diffusion bridges the way to infinity; 0 where
/// the axis does not end there.
Choice choose_deepest_optical_depth(Probes& probes);

Choice choose_optical_depth_samples(Probes& probes);

/// On the scale that the recipe fixes, or on the fourth root where its samples are fewer.
ScaledChoice choose_albedo_samples(Probes& probes);

/// Samples along a range of the family, of a recipe of which all but those is resolved.
Choice choose_family_samples(const Recipe& recipe, std::size_t axis, double max_error,
                             const BakeOptions& options);

// ---- what they share ----------------------------------------------------------------------------

/// Tells what was chosen and the error that is left.
void note_choice(const Probes& probes, const std::string& what, double error,
                 const std::string& of);

/// Extrapolates the choice that brings an error down to `allowed`, by the power law through the errors of the last two
/// candidates; 0 where they fall more slowly than in proportion.
double extrapolated(double before, double error_before, double last, double error_last,
                    double allowed);

/// The error that a candidate leaves.
using CandidateError = std::function<double(int candidate)>;

/// First of the ascending candidates whose error is within the probes' limit, found as if errors
/// fell with the fourth power, a cubic's, or with that between the last two; the last if none is.
/// `at_least`, if given, takes less time and tells no more than the error: that is then worked out
/// for those candidates alone that it does not rule out and that may be the first.
Choice choose_cheapest(const Probes& probes, const char* name, const std::vector<int>& candidates,
                       const CandidateError& error, const CandidateError& at_least = {});

/// The scales that an axis may have, and what to call its samples on either.
struct Scales {
    AxisScale usual, other;
    const char *samples, *samples_on_other;
};

/// The cheapest on the scale that is fixed, or on the usual one, or on the other where fewer samples
/// do there; that is tried where the usual scale takes more than `few`.
ScaledChoice choose_scaled(const Probes& probes, const Scales& scales,
                           std::optional<AxisScale> fixed, std::vector<int> candidates, int few,
                           const std::function<double(AxisScale scale, int candidate)>& error);

}  // namespace stratus
