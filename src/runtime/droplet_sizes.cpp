#include "droplet_sizes.h"

#include <stratus/runtime/constants.h>

#include <cmath>

namespace stratus {
namespace {

/// Logarithm of n(r), not normalised; r in effective radii.
double log_number(const Droplets& droplets, double r) {
    const double v = droplets.effective_variance;
    if (droplets.distribution == Droplets::Distribution::gamma)
        return (1 - 3 * v) / v * std::log(r) - r / v;
    const double sigma2 = std::log1p(v);
    const double from_median = std::log(r) + 2.5 * sigma2;
    return -from_median * from_median / (2 * sigma2) - std::log(r);
}

/// Logarithm of r^power n(r) r: the sum of r^power over droplets, per interval of ln r.
double log_share(const Droplets& droplets, int power, double r) {
    return (power + 1) * std::log(r) + log_number(droplets, r);
}

/// Where log_share is largest.
double radius_of_largest_share(const Droplets& droplets, int power) {
    const double v = droplets.effective_variance;
    return droplets.distribution == Droplets::Distribution::gamma ? 1 + (power - 2) * v
                                                                  : std::pow(1 + v, power - 2.5);
}

/// Where log_share has fallen to 1e-7, between its largest value and `end`, by bisection.
double radius_of_small_share(const Droplets& droplets, int power, double end) {
    double inside = radius_of_largest_share(droplets, power), outside = end;
    const double limit = log_share(droplets, power, inside) + std::log(1e-7);
    for (int step = 0; step < 60; ++step) {
        const double middle = std::sqrt(inside * outside);
        (log_share(droplets, power, middle) > limit ? inside : outside) = middle;
    }
    return outside;
}

}  // namespace

RadiusRange radii_of(const Droplets& droplets) {
    if (droplets.effective_variance == 0) return {1, 1};
    // Cross-sections go as r^2; the intensity straight on, the most sensitive to large droplets, as
    // r^4.
    return {radius_of_small_share(droplets, 2, 1e-9), radius_of_small_share(droplets, 4, 1e4)};
}

std::vector<SphereSize> sizes_of(const Droplets& droplets, int count) {
    const double x = 2 * pi * droplets.effective_radius / droplets.wavelength;
    if (droplets.effective_variance == 0) return {{x, 1}};
    const RadiusRange range = radii_of(droplets);
    const double begin = std::sqrt(range.min), end = std::sqrt(range.max);
    const double reference = log_number(droplets, 1);
    std::vector<SphereSize> sizes;
    for (int i = 0; i < count; ++i) {
        const double root = begin + (i + 0.5) / count * (end - begin);
        const double r = root * root;
        sizes.push_back({x * r, root * std::exp(log_number(droplets, r) - reference)});
    }
    return sizes;
}

}  // namespace stratus
