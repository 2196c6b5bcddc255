// How a resolved recipe is solved, and where it puts its samples.
#pragma once

#include <stratus/bake/recipe.h>
#include <stratus/runtime/axis.h>
#include <stratus/runtime/path_law.h>

#include <memory>
#include <optional>

namespace stratus {

/// The solver that a recipe asks for, as far as it is resolved.
SolverOptions solver_options(const Recipe& recipe);

/// What tables of the recipe leave to lookups (path_law.h); null where the phase function has no
/// narrow peak, over a lower boundary and in mixtures.
std::shared_ptr<const PathOrders> path_law_of(const Recipe& recipe);

/// mu from 1e-4 to 1: directions within 0.006 degrees of the surface are clamped.
Axis mu_axis(int samples);

/// 0 to pi; one sample, linear, where nothing depends on azimuth.
Axis azimuth_axis(AxisScale scale, int samples);

/// Even in the scale over the range, square_root_of_complement where that is open; one sample where
/// min = max.
Axis albedo_axis(Range range, int samples, std::optional<AxisScale> scale = std::nullopt);

/// Even shares of the first phase function.
Axis mixture_axis(Range range, int samples);

/// `samples_per_octave` up to max, or up to `deepest` and infinity. It begins at min, or a little
/// below it so that max is a sample.
Axis optical_depth_axis(Range range, int samples_per_octave, double deepest);

/// Rates at which light decays deep inside, over the albedos, as diffusion.h asks for them: the
/// diffusion exponents, or 1 where the series stops: light scattered a few times penetrates no
/// deeper than the beam.
std::vector<double> decay_exponents(const Recipe& recipe, const std::vector<double>& albedos);

/// 1.42 / (1 - g), the scale that diffusion.h asks for, and more over a
/// reflecting ground.
double extrapolation_length(const PhaseFunction& phase_function, const LowerBoundary& boundary);

}  // namespace stratus
