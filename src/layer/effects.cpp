#include <stratus/layer/effects.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>

#include <cmath>

namespace stratus {

double volume_fraction(double number_density, double radius) {
    constexpr const char* caller = "volume_fraction";
    require(number_density >= 0 && std::isfinite(number_density), caller, "number_density",
            "in [0, inf)", number_density);
    require(radius > 0 && std::isfinite(radius), caller, "radius", "in (0, inf)", radius);
    const double density = number_density * (4 * pi / 3) * radius * radius * radius;
    require(density < 1, caller, "number_density * (4/3) pi radius^3", "in [0, 1)", density);
    return density;
}

double effective_optical_depth(double optical_depth, double density) noexcept {
    return optical_depth / (1 - density);
}

void check_effects(const Effects& effects) {
    require(effects.density >= 0 && effects.density < 1, "Effects", "density", "in [0, 1)",
            effects.density);
    if (effects.opposition.law == Opposition::Law::none) return;
    check_opposition(effects.opposition, effects.density, "Effects");
    require(effects.single, "Effects", "opposition", "none without single scattering", "a law");
}

}  // namespace stratus
