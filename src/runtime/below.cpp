#include <stratus/runtime/below.h>

#include <limits>
#include <utility>

namespace stratus {

Below Below::surface(double albedo) { return {Kind::surface, albedo, {}}; }

Below Below::layer(PhaseFunction phase_function, double albedo) {
    return {Kind::layer, albedo, std::move(phase_function)};
}

double phase_value_below(const Below& below, const Geometry& geometry) noexcept {
    return below.kind == Below::Kind::layer
               ? below.phase_function(cos_scattering_angle_reflected(geometry))
               : 1;
}

double single_reflection_below(const Below& below, double phase_value, double optical_depth,
                               double mu_in, double mu_out) noexcept {
    if (!below.is_something()) return 0;
    const double beam =
        direct_transmittance(optical_depth, mu_in) * direct_transmittance(optical_depth, mu_out);
    if (below.kind == Below::Kind::surface) return beam * below.albedo * phase_value;
    return beam * single_reflection(phase_value, below.albedo,
                                    std::numeric_limits<double>::infinity(), mu_in, mu_out);
}

double single_reflection_below(const Below& below, double optical_depth,
                               const Geometry& geometry) noexcept {
    return single_reflection_below(below, phase_value_below(below, geometry), optical_depth,
                                   geometry.mu_in, geometry.mu_out);
}

}  // namespace stratus
