#include <stratus/layer/diffusion.h>

#include <algorithm>

namespace stratus {

namespace {

/// exp(-passes k tau) (1 - exp(-2 k q)) / (1 - exp(-2 k (tau + q))): with one pass the scale of
/// transmission, with two the deficit of reflection, whose light goes down and up again.
double fall(int passes, double tau, double k, double q) noexcept {
    if (std::isinf(tau)) return 0;
    const double decay = std::exp(-passes * k * tau);
    if (decay == 0) return 0;
    return q / (tau + q) * decay * mean_of_exponential(2 * k * q) /
           mean_of_exponential(2 * k * (tau + q));
}

}  // namespace

double transmission_scale(double optical_depth, double diffusion_exponent,
                          double extrapolation_length) noexcept {
    return fall(1, optical_depth, diffusion_exponent, extrapolation_length);
}

double reflection_deficit(double optical_depth, double diffusion_exponent,
                          double extrapolation_length) noexcept {
    return fall(2, optical_depth, diffusion_exponent, extrapolation_length);
}

double reflection_scale(double optical_depth, double diffusion_exponent,
                        double extrapolation_length) noexcept {
    const double d = reflection_deficit(optical_depth, diffusion_exponent, extrapolation_length);
    return 1 / (1 + d + d * d);
}

double diffusion_scale(Side side, double optical_depth, double diffusion_exponent,
                       double extrapolation_length) noexcept {
    const auto scale = side == Side::reflection ? reflection_scale : transmission_scale;
    return scale(optical_depth, diffusion_exponent, extrapolation_length);
}

double transmission_shape_error(double optical_depth, double albedo, double diffusion_exponent,
                                double extrapolation_length) noexcept {
    const double g = std::max(0.0, 1 - reduced_extrapolation_length / extrapolation_length);
    const double next = std::sqrt((1 - albedo * g * g) * (1 - albedo * g * g * g));
    return 7 * std::exp((diffusion_exponent - next) * optical_depth);
}

double share_beyond_deepest(Side side, double optical_depth, double deepest,
                            double diffusion_exponent, double extrapolation_length) noexcept {
    const auto at = [&](double depth) {
        return diffusion_scale(side, depth, diffusion_exponent, extrapolation_length);
    };
    const double of_deepest = at(deepest);
    return of_deepest > 0 ? at(optical_depth) / of_deepest : 0;
}

double thin_growth(double optical_depth) noexcept {
    constexpr double numerator = 2.51629;  // exp(3/2 - gamma)
    return std::log1p(numerator / std::max(optical_depth, 1e-30));
}

double thin_growth_of_samples(double optical_depth) noexcept {
    return thin_growth(std::min(optical_depth, 4.0));
}

}  // namespace stratus
