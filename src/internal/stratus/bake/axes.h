// How a resolved recipe is solved, and where it puts its samples.
#pragma once

#include <stratus/bake/recipe.h>
#include <stratus/base/axis.h>
#include <stratus/phase/path_law.h>

#include <cstddef>
#include <memory>
#include <optional>

namespace stratus {

/// The solver that a recipe asks for, as far as it is resolved.
SolverOptions solver_options(const Recipe& recipe);

/// Returns the path law that tables of the recipe leave to lookups (path_law.h); null where the phase function has no
/// narrow peak, over a lower boundary, in mixtures and of stacks.
std::shared_ptr<const PathOrders> recipe_path_law(const Recipe& recipe);

/// Whether they leave it, of a family: no mixture, and a narrow peak at all ends of its axes.
bool leaves_path_law(const Recipe& recipe);

/// The recipe with that decided: of a family of droplets it takes long to find out.
Recipe with_path_law_decided(Recipe recipe);

// Directions that tables know unless recipes narrow them: cosines, and azimuths in degrees.
constexpr Range all_cosines{0, 1}, all_azimuths{0, 180};

/// First sample of all cosines: directions within 0.006 degrees of the surface are clamped.
constexpr double min_mu = 1e-4;

/// Degrees; at 0 alone an axis would look like one on which nothing depends.
constexpr double min_azimuth = 1e-3;

constexpr bool is_narrow(Range range, Range all) {
    return range.min > all.min || range.max < all.max;
}

/// Cosines of a range. `samples` are those of an axis of all cosines; a narrow one has the same
/// spacing or a little less, four at least, or one where min = max.
Axis mu_axis(Range range, int samples);

/// Returns an axis of azimuths, whose range is in degrees and whose samples are in radians; one sample
/// at 0, linear, where nothing depends on azimuth: `samples` = 1.
Axis azimuth_axis(Range range, AxisScale scale, int samples);

/// The directions of a resolved recipe's samples.
struct DirectionAxes {
    Axis mu_in, mu_out, azimuth;

    std::size_t count() const {
        return mu_in.values.size() * mu_out.values.size() * azimuth.values.size();
    }
};

DirectionAxes direction_axes(const Recipe& resolved);

/// Even in the scale over the range, square_root_of_complement where that is open; one sample where
/// min = max.
Axis albedo_axis(Range range, int samples, std::optional<AxisScale> scale);

/// Even in the scale of the parameter, from the first of its values to the last.
FamilyAxis ranging_axis(const FamilyRange& range, int samples);

/// Where all axes of a recipe's family end, the most peaked first; a point of no axes without one.
std::vector<FamilyPoint> corners_by_peak(const Recipe& recipe);

/// The axes of a resolved recipe's family; none without one.
FamilyAxes family_axes(const Recipe& resolved);

/// `samples_per_octave`, one at least, up to max, or up to `deepest` and infinity: one where min is max, else four or
/// more. It begins at min, or so far below it that max is a sample.
Axis optical_depth_axis(Range range, int samples_per_octave, double deepest);

/// Rates at which light decays deep inside, over the albedos, as diffusion.h asks for them: the
/// diffusion exponents, or 1 where the series stops: light scattered a few times penetrates no
/// deeper than the beam. Of a stack 0: it has one depth.
std::vector<double> decay_exponents(const Recipe& recipe, const std::vector<double>& albedos);

/// 1.42 / (1 - g), the scale that diffusion.h asks for, and more over a
/// reflecting ground.
double extrapolation_length(const PhaseFunction& phase_function, const LowerBoundary& boundary);

}  // namespace stratus
