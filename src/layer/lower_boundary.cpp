#include <stratus/layer/lower_boundary.h>

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include "reflected_curve.h"

#include <algorithm>
#include <string>
#include <utility>

namespace stratus {

LowerBoundary LowerBoundary::surface(double albedo) { return {Kind::surface, albedo, {}, {}}; }

LowerBoundary LowerBoundary::layer(PhaseFunction phase_function, double albedo) {
    return {Kind::layer, albedo, std::move(phase_function), {}};
}

LowerBoundary LowerBoundary::ground(std::shared_ptr<const GroundLaw> law) {
    // Tables of layers without absorption exceed 1 by their error.
    const double albedo = std::min(1.0, law->spherical_albedo());
    return {Kind::ground, albedo, {}, std::move(law)};
}

double boundary_phase_value(const LowerBoundary& boundary, const Geometry& geometry) noexcept {
    if (boundary.is_ground()) return (*boundary.law)(geometry);
    return boundary.is_layer() ? boundary.phase_function(cos_scattering_angle_reflected(geometry))
                               : 1;
}

double single_reflection_of_boundary(const LowerBoundary& boundary, double phase_value,
                                     double optical_depth, double mu_in, double mu_out) noexcept {
    if (!boundary.is_present()) return 0;
    const double beam =
        direct_transmittance(optical_depth, mu_in) * direct_transmittance(optical_depth, mu_out);
    if (boundary.is_ground()) return beam * phase_value;
    if (boundary.is_surface()) return beam * boundary.albedo * phase_value;
    return beam * single_reflection(phase_value, boundary.albedo, infinity, mu_in, mu_out);
}

double single_reflection_of_boundary(const LowerBoundary& boundary, double optical_depth,
                                     const Geometry& geometry) noexcept {
    return single_reflection_of_boundary(boundary, boundary_phase_value(boundary, geometry),
                                         optical_depth, geometry.mu_in, geometry.mu_out);
}

PhaseCurve reflected_curve(const PhaseFunction& phase_function, const Opposition& opposition,
                           const LowerBoundary* boundary) {
    const bool of_hapke = opposition.law == Opposition::Law::hapke;
    const bool of_blinn = opposition.law == Opposition::Law::blinn;
    const bool over_layer = boundary != nullptr && boundary->is_layer();
    const auto layer = [&](double c) {  // Hapke's law is one for all depths and cosines
        return phase_function(c) *
               (of_hapke ? opposition_factor(opposition, c, infinity, 1, 1) : 1);
    };
    if (!of_blinn && !of_hapke && !over_layer) return PhaseCurve(phase_function);
    const bool has_two = of_blinn || over_layer;
    const auto value = [&](double c, double* values) {
        values[0] = layer(c);
        if (has_two) values[1] = over_layer ? boundary->phase_function(c) : 0;
    };
    const PhaseForm form = of_blinn  ? PhaseForm::with_opposition_and_boundary
                           : has_two ? PhaseForm::with_boundary
                                     : PhaseForm::sampled;
    std::string text = phase_function.text() + (of_blinn ? " with blinn" : "");
    if (of_hapke)
        text += " with hapke " + shortest_text(opposition.amplitude) + " " +
                shortest_text(opposition.width);
    if (over_layer) text += " over " + boundary->phase_function.text();
    return PhaseCurve::kept(text,
                            [&] { return PhaseCurve::sampled(has_two ? 2 : 1, value, form); });
}

}  // namespace stratus
