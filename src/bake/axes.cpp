#include <stratus/bake/axes.h>

#include <stratus/base/constants.h>
#include <stratus/base/gauss_legendre.h>
#include <stratus/layer/diffusion.h>
#include <stratus/phase/path_law.h>
#include <stratus/transfer/solve.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace stratus {

namespace {

/// A part of an axis: samples no further apart.
Axis axis_part(const AxisView& all, double min, double max) {
    if (min == max) return make_axis(all.scale, min, min, 1);
    if (min == all.lowest && max == all.highest) return make_axis(all.scale, min, max, all.count);
    const double intervals = std::ceil(all.index(max) - all.index(min) - 1e-9);
    return make_axis(all.scale, min, max, std::max(stencil_size, static_cast<int>(intervals) + 1));
}

/// Returns an axis over a range; or just its values.
FamilyAxis family_axis(const FamilyRange& range, int samples) {
    if (range.values.empty()) return ranging_axis(range, samples);
    return {range.parameter, {parameter_scale(range.parameter), range.values}, true};
}

/// The length over whiter ground is that at this absorptance: the light lost in the ground is then
/// below the tolerances of tables.
constexpr double min_absorptance = 1e-3;

}  // namespace

SolverOptions solver_options(const Recipe& recipe) {
    SolverOptions solver;
    solver.nodes = recipe.discretisation.nodes;
    solver.modes = recipe.discretisation.modes;
    solver.scheme = recipe.discretisation.scheme;
    solver.orders = recipe.orders;
    solver.mode_tolerance = 1e-3 * recipe.tolerance;
    solver.exact_fluxes = recipe.exact_fluxes;
    return solver;
}

bool leaves_path_law(const Recipe& recipe) {
    if (mixture_range(recipe) != nullptr || recipe.lower_boundary.is_present() ||
        !recipe.layers.empty())
        return false;
    if (recipe.leaves_path_law) return *recipe.leaves_path_law;
    FamilyAxes ends;
    for (const FamilyRange& range : recipe.family) ends.push_back(family_axis(range, 2));
    for (std::size_t m = 0; m < member_count(ends); ++m) {
        const PhaseFunction member =
            phase_function_at(recipe.phase_function, {}, ends, member_at(ends, m));
        if (!has_narrow_peak(member) || significant_moments(member).empty()) return false;
    }
    return true;
}

Recipe with_path_law_decided(Recipe recipe) {
    if (!recipe.family.empty()) recipe.leaves_path_law = leaves_path_law(recipe);
    return recipe;
}

std::shared_ptr<const PathOrders> recipe_path_law(const Recipe& recipe) {
    if (!leaves_path_law(recipe)) return {};
    return PathOrders::of_any(recipe.phase_function);
}

Axis mu_axis(Range range, int samples) {
    const Axis all = make_axis(AxisScale::arcsine_of_fourth_root, min_mu, 1, samples);
    return axis_part(all.view(), std::max(min_mu, range.min), range.max);
}

Axis azimuth_axis(Range range, AxisScale scale, int samples) {
    if (samples == 1) return make_axis(AxisScale::linear, 0, 0, 1);
    const auto end = [](double degrees) { return degrees == 180 ? pi : radians(degrees); };
    const Axis all = make_axis(scale, 0, pi, samples);
    return axis_part(all.view(), end(range.min), end(range.max));
}

DirectionAxes direction_axes(const Recipe& resolved) {
    const Discretisation& d = resolved.discretisation;
    return {mu_axis(resolved.mu_in, d.mu_samples), mu_axis(resolved.mu_out, d.mu_samples),
            azimuth_axis(resolved.azimuth, d.azimuth_scale.value_or(AxisScale::linear),
                         d.azimuth_samples)};
}

Axis albedo_axis(Range range, int samples, std::optional<AxisScale> scale) {
    return make_axis(scale.value_or(AxisScale::square_root_of_complement), range.min, range.max,
                     range.min == range.max ? 1 : std::max(2, samples));
}

FamilyAxis ranging_axis(const FamilyRange& range, int samples) {
    return {range.parameter,
            make_axis(parameter_scale(range.parameter), range.range.min, range.range.max, samples),
            false};
}

std::vector<FamilyPoint> corners_by_peak(const Recipe& recipe) {
    FamilyAxes ends;
    for (const FamilyRange& range : recipe.family) ends.push_back(ranging_axis(range, 2));
    std::vector<std::pair<double, FamilyPoint>> peaks;
    for (const FamilyPoint& corner : family_corners(ends))
        peaks.emplace_back(std::abs(at_member(recipe, corner).phase_function.asymmetry()), corner);
    std::ranges::stable_sort(peaks, std::ranges::greater{}, &std::pair<double, FamilyPoint>::first);
    std::vector<FamilyPoint> corners;
    for (const auto& [peak, corner] : peaks) corners.push_back(corner);
    return corners;
}

FamilyAxes family_axes(const Recipe& resolved) {
    FamilyAxes axes;
    for (std::size_t k = 0; k < resolved.family.size(); ++k)
        axes.push_back(family_axis(resolved.family[k], resolved.discretisation.family_samples[k]));
    return axes;
}

Axis optical_depth_axis(Range range, int samples_per_octave, double deepest) {
    if (std::isinf(range.min)) return make_axis(AxisScale::logarithmic, 1, 1, 0, true);
    const bool ends_at_infinity = std::isinf(range.max);
    const double max = ends_at_infinity ? deepest : range.max;
    if (range.min == max && !ends_at_infinity)
        return make_axis(AxisScale::logarithmic, max, max, 1);
    samples_per_octave = std::max(1, samples_per_octave);
    const double steps = samples_per_octave * std::log2(max / range.min);
    // Choices measure the error of a cubic, which needs four samples however narrow the range is.
    const int intervals = std::max(stencil_size - 1, static_cast<int>(std::ceil(steps - 1e-9)));
    const double min = max * std::exp2(-static_cast<double>(intervals) / samples_per_octave);
    return make_axis(AxisScale::logarithmic, min, max, intervals + 1, ends_at_infinity);
}

namespace {

/// Puts in place of the exponents of dark layers a polynomial through diffusion's at some albedos, the first of
/// which it begins below. Diffusion bends to 1 near albedo 0, for peaked phase functions within less than samples
/// of the albedo are apart, while T of layers thin enough to be seen goes on evenly: it would miss by up to ten
/// times as much. What a path law leaves of T grows the least: there a lower value at albedo 0 was found to serve
/// best.
void continue_to_black(const PhaseFunction& phase_function, const std::vector<double>& albedos,
                       std::vector<double>& exponents) {
    const bool has_path_law = has_narrow_peak(phase_function);
    std::vector<double> known =
        has_path_law ? std::vector{0.4, 0.3} : std::vector{0.2, 0.3, 0.4, 0.5};
    const auto is_dark = [&](double albedo) { return albedo < known[0]; };
    if (std::ranges::none_of(albedos, is_dark)) return;
    std::vector<double> of_known = compute_diffusion_exponents(phase_function, known);
    if (has_path_law) {
        known.push_back(0);
        of_known.push_back(0.96);
    }
    for (std::size_t k = 0; k < albedos.size(); ++k) {
        if (!is_dark(albedos[k])) continue;
        const std::vector<double> weight = lagrange_weights(known, albedos[k]);
        exponents[k] = std::inner_product(weight.begin(), weight.end(), of_known.begin(), 0.0);
    }
}

}  // namespace

std::vector<double> decay_exponents(const Recipe& recipe, const std::vector<double>& albedos) {
    if (!recipe.layers.empty()) return std::vector<double>(albedos.size(), 0.0);
    if (recipe.orders > 0) return std::vector<double>(albedos.size(), 1.0);
    std::vector<double> exponents = compute_diffusion_exponents(recipe.phase_function, albedos);
    continue_to_black(recipe.phase_function, albedos, exponents);
    return exponents;
}

double extrapolation_length(const PhaseFunction& phase_function, const LowerBoundary& boundary) {
    // A ground of albedo A is equivalent to a black one (4/3) A / (1 - A) deeper: a conservative
    // layer of reduced depth x transmits t = (4/3) / (x + q) [vdH80], of which the ground absorbs
    // (1 - A) t / (1 - A (1 - t)).
    double albedo = boundary.albedo;
    if (boundary.is_layer()) {
        SolverOptions flux_only;
        flux_only.modes = 1;
        albedo =
            solve_layer(boundary.phase_function, albedo, infinity, {}, flux_only).spherical_albedo;
    }
    const double further =
        boundary.is_present() ? 4.0 / 3 * albedo / std::max(min_absorptance, 1 - albedo) : 0;
    return (reduced_extrapolation_length + further) /
           std::max(1e-4, 1 - phase_function.asymmetry());
}

}  // namespace stratus
