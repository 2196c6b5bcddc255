#include <stratus/runtime/below.h>

#include <limits>
#include <utility>

namespace stratus {

Below Below::surface(double albedo) { return {Kind::surface, albedo, {}}; }

Below Below::layer(PhaseFunction phase_function, double albedo) {
    return {Kind::layer, albedo, std::move(phase_function)};
}

double single_reflection_below(const Below& below, double optical_depth,
                               const Geometry& geometry) noexcept {
    if (!below.is_something()) return 0;
    const double beam = direct_transmittance(optical_depth, geometry.mu_in) *
                        direct_transmittance(optical_depth, geometry.mu_out);
    if (below.kind == Below::Kind::surface) return beam * below.albedo;
    return beam * single_reflection(below.phase_function(cos_scattering_angle_reflected(geometry)),
                                    below.albedo, std::numeric_limits<double>::infinity(),
                                    geometry.mu_in, geometry.mu_out);
}

}  // namespace stratus
