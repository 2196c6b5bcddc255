#include <stratus/runtime/diffusion.h>

#include <cmath>

namespace stratus {
namespace {

/// (1 - exp(-z)) / z for z >= 0, 1 at z = 0.
double mean_decay(double z) noexcept { return z == 0 ? 1 : -std::expm1(-z) / z; }

}  // namespace

double mixed_extrapolation_length(double first, double second, double mixture) noexcept {
    return 1 / (mixture / first + (1 - mixture) / second);
}

double transmission_scale(double optical_depth, double diffusion_exponent,
                          double extrapolation_length) noexcept {
    if (std::isinf(optical_depth)) return 0;
    const double depth = optical_depth + extrapolation_length;
    const double z = diffusion_exponent * depth;
    const double decay = std::exp(-z);
    if (decay == 0) return 0;
    return extrapolation_length / depth * decay / mean_decay(2 * z);  // z / sinh z
}

double reflection_deficit(double optical_depth, double diffusion_exponent,
                          double extrapolation_length) noexcept {
    if (std::isinf(optical_depth)) return 0;
    const double depth = optical_depth + extrapolation_length;
    const double decay = std::exp(-2 * diffusion_exponent * optical_depth);
    if (decay == 0) return 0;
    return extrapolation_length / depth * decay *
           mean_decay(2 * diffusion_exponent * extrapolation_length) /
           mean_decay(2 * diffusion_exponent * depth);
}

double reflection_scale(double optical_depth, double diffusion_exponent,
                        double extrapolation_length) noexcept {
    return 1 / (1 + reflection_deficit(optical_depth, diffusion_exponent, extrapolation_length));
}

}  // namespace stratus
