#include <stratus/runtime/effects.h>

#include <stratus/runtime/argument.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

double blinn_bump(double width, double sine_square_of_half_phase_angle) noexcept {
    const double h2 = width * width;
    const double p = sine_square_of_half_phase_angle;
    const double falling = h2 / (p + h2 * (1 - p));
    return falling * falling;
}

double hapke_bump(double width, double sine_square_of_half_phase_angle) noexcept {
    const double sine = std::sqrt(sine_square_of_half_phase_angle);
    const double cosine = std::sqrt(1 - sine_square_of_half_phase_angle);
    return width * cosine / (width * cosine + sine);
}

}  // namespace

double Opposition::width_of_density(double density) {
    require(density > 0 && density < 1, "Opposition", "density", "in (0, 1)", density);
    return -0.375 * std::log1p(-density);
}

Opposition Opposition::blinn(double density) { return {Law::blinn, width_of_density(density), 1}; }

Opposition Opposition::hapke(double amplitude, double width) {
    require(amplitude >= 0 && amplitude <= 1, "Opposition", "amplitude", "in [0, 1]", amplitude);
    require(width > 0 && width < INFINITY, "Opposition", "width", "in (0, inf)", width);
    return {Law::hapke, width, amplitude};
}

double opposition_factor(const Opposition& opposition, double cos_scattering_angle,
                         double optical_depth, double mu_in, double mu_out) noexcept {
    // Phase angle a = pi - Theta.
    const double p = std::clamp((1 + cos_scattering_angle) / 2, 0.0, 1.0);
    switch (opposition.law) {
        case Opposition::Law::none: return 1;
        case Opposition::Law::blinn:
            // At mu = mu0, [Blinn82] 5.2: 2 (1 - e) / (1 - e^2) = 1 + (1 - e) / (1 + e), e =
            // exp(-tau / mu)
            return 1 + std::tanh(optical_depth * (1 / mu_in + 1 / mu_out) / 4) *
                           blinn_bump(opposition.width, p);
        case Opposition::Law::hapke:
            return 1 + opposition.amplitude * hapke_bump(opposition.width, p);
    }
    return 1;
}

double effective_optical_depth(double optical_depth, double density) noexcept {
    return optical_depth / (1 - density);
}

void check_effects(const Effects& effects) {
    require(effects.density >= 0 && effects.density < 1, "Effects", "density", "in [0, 1)",
            effects.density);
    const Opposition& opposition = effects.opposition;
    if (opposition.law == Opposition::Law::none) return;
    require(opposition.width > 0 && opposition.width < INFINITY, "Effects", "opposition.width",
            "in (0, inf)", opposition.width);
    require(opposition.amplitude >= 0 && opposition.amplitude <= 1, "Effects",
            "opposition.amplitude", "in [0, 1]", opposition.amplitude);
    require(effects.single, "Effects", "opposition", "none without single scattering", "a law");
}

}  // namespace stratus
