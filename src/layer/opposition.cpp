#include <stratus/layer/opposition.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>

#include "shadow_overlap.h"

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

double hapke_bump(double width, double sine, double cosine) noexcept {
    return width * cosine / (width * cosine + sine);
}

double blinn_bump(double radius, double sine, double cosine, double optical_depth, double mu_in,
                  double mu_out) noexcept {
    const double sum = mu_in + mu_out;
    const double eta = std::min(1.0, 4 * (mu_in / sum) * (mu_out / sum));
    const double depth = optical_depth * (1 / mu_in + 1 / mu_out) / 2;
    if (depth == 0) return 0;
    const ShadowOverlap overlap(radius, sine, cosine);
    return overlap.brightening(eta, 0, depth) / -std::expm1(-2 * depth);
}

}  // namespace

Opposition Opposition::blinn(double density) {
    return {Law::blinn, radius_in_free_paths(density), 1};
}

Opposition Opposition::hapke(double amplitude, double width) {
    require(width > 0 && width < INFINITY, "Opposition", "width", "in (0, inf)", width);
    Opposition opposition = hapke(amplitude);
    opposition.width = width;
    return opposition;
}

Opposition Opposition::hapke(double amplitude) {
    require(amplitude >= 0 && amplitude <= 1, "Opposition", "amplitude", "in [0, 1]", amplitude);
    return {Law::hapke, 0, amplitude};
}

double Opposition::radius_in_free_paths(double density) {
    require(density > 0 && density < 1, "Opposition", "density", "in (0, 1)", density);
    return 0.75 * density;
}

double Opposition::width_of_density(double density) {
    require(density > 0 && density < 1, "Opposition", "density", "in (0, 1)", density);
    return -0.375 * std::log1p(-density);
}

Opposition seen_opposition(const Opposition& opposition, double density) {
    Opposition seen = opposition;
    if (seen.law == Opposition::Law::none) return seen;
    const bool of_blinn = seen.law == Opposition::Law::blinn;
    if (seen.width == 0)
        seen.width = of_blinn ? Opposition::radius_in_free_paths(density)
                              : Opposition::width_of_density(density);
    if (of_blinn) seen.width /= 1 - density;
    return seen;
}

void check_opposition(const Opposition& opposition, double density, const char* caller) {
    if (opposition.law == Opposition::Law::none) return;
    require(opposition.width >= 0 && opposition.width < INFINITY &&
                (opposition.width > 0 || density > 0),
            caller, "opposition.width", "in (0, inf), or 0 with a density above 0",
            opposition.width);
    require(opposition.amplitude >= 0 && opposition.amplitude <= 1, caller, "opposition.amplitude",
            "in [0, 1]", opposition.amplitude);
}

double opposition_factor(const Opposition& opposition, double cos_scattering_angle,
                         double optical_depth, double mu_in, double mu_out) noexcept {
    // Phase angle a = pi - Theta.
    const double sine = std::sqrt(std::clamp((1 + cos_scattering_angle) / 2, 0.0, 1.0));
    const double cosine = std::sqrt(std::clamp((1 - cos_scattering_angle) / 2, 0.0, 1.0));
    switch (opposition.law) {
        case Opposition::Law::none: return 1;
        case Opposition::Law::blinn:
            return 1 + blinn_bump(opposition.width, sine, cosine, optical_depth, mu_in, mu_out);
        case Opposition::Law::hapke:
            return 1 + opposition.amplitude * hapke_bump(opposition.width, sine, cosine);
    }
    return 1;
}

}  // namespace stratus
