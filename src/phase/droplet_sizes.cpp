#include "mie_scattering.h"

#include <stratus/base/constants.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

using Distribution = Droplets::Distribution;

/// Logarithm of the gamma function: Stirling's series, argument raised to 16 at least, 1e-14. The
/// library's own writes a global sign.
double log_gamma_by_series(double z) {
    double product = 1;
    for (; z < 16; ++z) product *= z;
    const double square = 1 / (z * z);
    const double series =
        (1.0 / 12 - square * (1.0 / 360 - square * (1.0 / 1260 - square / 1680))) / z;
    return (z - 0.5) * std::log(z) - z + 0.5 * std::log(2 * pi) + series - std::log(product);
}

/// The effective size of a modified gamma distribution, whose integral of r^p n(r) is proportional
/// to Gamma((alpha + p + 1) / gamma) b^(-(p + 1) / gamma).
EffectiveSize size_of_modified_gamma(const Droplets& droplets) {
    const double alpha = droplets.alpha, gamma = droplets.gamma;
    const auto log_moment = [&](int p) { return log_gamma_by_series((alpha + p + 1) / gamma); };
    const double second = log_moment(2), third = log_moment(3), fourth = log_moment(4);
    const double radius =
        droplets.mode_radius * std::exp(third - second - std::log(alpha / gamma) / gamma);
    return {radius, std::expm1(fourth + second - 2 * third)};
}

/// n between two rows.
double number_between(const Droplets& droplets, std::size_t row, double r) {
    const std::vector<double>&radius = droplets.radius, &number = droplets.number;
    const double t = (r - radius[row]) / (radius[row + 1] - radius[row]);
    return (1 - t) * number[row] + t * number[row + 1];
}

/// The integral of (r / unit - shift)^power r^2 n(r), power up to 2, exact.
double moment_of_rows(const Droplets& droplets, int power, double unit, double shift) {
    constexpr double node[] = {-0.77459666924148338, 0, 0.77459666924148338};  // Gauss, degree 5
    constexpr double weight[] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
    double sum = 0;
    for (std::size_t i = 0; i + 1 < droplets.radius.size(); ++i) {
        const double half = (droplets.radius[i + 1] - droplets.radius[i]) / 2;
        for (int k = 0; k < 3; ++k) {
            const double r = droplets.radius[i] + half * (1 + node[k]);
            sum += half * weight[k] * r * r * number_between(droplets, i, r) *
                   std::pow(r / unit - shift, power);
        }
    }
    return sum;
}

EffectiveSize size_of_rows(const Droplets& droplets) {
    const double area = moment_of_rows(droplets, 0, 1, 0);
    const double radius = moment_of_rows(droplets, 1, 1, 0) / area;
    return {radius, moment_of_rows(droplets, 2, radius, 1) / area};
}

/// A distribution as a curve; r in effective radii.
struct Curve {
    const Droplets& droplets;
    double modes = 1;  // effective radius over mode radius, of modified_gamma
};

Curve size_curve(const Droplets& droplets) {
    if (droplets.distribution != Distribution::modified_gamma) return {droplets};
    return {droplets, effective_size(droplets).radius / droplets.mode_radius};
}

/// Logarithm of n(r), not normalised.
double log_number(const Curve& curve, double r) {
    const Droplets& droplets = curve.droplets;
    if (droplets.distribution == Distribution::modified_gamma)
        return droplets.alpha *
               (std::log(r) - std::pow(r * curve.modes, droplets.gamma) / droplets.gamma);
    const double v = droplets.effective_variance;
    if (droplets.distribution == Distribution::gamma) return (1 - 3 * v) / v * std::log(r) - r / v;
    const double sigma2 = std::log1p(v);
    const double from_median = std::log(r) + 2.5 * sigma2;
    return -from_median * from_median / (2 * sigma2) - std::log(r);
}

/// Logarithm of r^power n(r) r: the sum of r^power over droplets, per interval of ln r.
double log_share(const Curve& curve, int power, double r) {
    return (power + 1) * std::log(r) + log_number(curve, r);
}

/// Where log_share is largest.
double radius_of_largest_share(const Curve& curve, int power) {
    const Droplets& droplets = curve.droplets;
    if (droplets.distribution == Distribution::modified_gamma)
        return std::pow(1 + (power + 1) / droplets.alpha, 1 / droplets.gamma) / curve.modes;
    const double v = droplets.effective_variance;
    return droplets.distribution == Distribution::gamma ? 1 + (power - 2) * v
                                                        : std::pow(1 + v, power - 2.5);
}

/// Where log_share has fallen to 1e-7, between its largest value and `end`, by bisection.
double radius_of_small_share(const Curve& curve, int power, double end) {
    double inside = radius_of_largest_share(curve, power), outside = end;
    const double limit = log_share(curve, power, inside) + std::log(1e-7);
    for (int step = 0; step < 60; ++step) {
        const double middle = std::sqrt(inside * outside);
        (log_share(curve, power, middle) > limit ? inside : outside) = middle;
    }
    return outside;
}

/// Sizes at which a tabulated distribution is integrated: each interval between rows is cut into
/// cells of equal width in the square root of the radius, with two Gauss points a cell.
std::vector<SphereSize> sizes_of_rows(const Droplets& droplets, double x_of_um, int count) {
    const std::vector<double>& radius = droplets.radius;
    const double largest = *std::max_element(droplets.number.begin(), droplets.number.end());
    const double whole = std::sqrt(radius.back()) - std::sqrt(radius.front());
    std::vector<SphereSize> sizes;
    for (std::size_t i = 0; i + 1 < radius.size(); ++i) {
        const double begin = std::sqrt(radius[i]), width = std::sqrt(radius[i + 1]) - begin;
        const int cells = std::max(2, static_cast<int>(std::ceil(0.5 * count * width / whole)));
        const double half = width / cells / 2;
        for (int cell = 0; cell < cells; ++cell)
            for (const double side : {-1.0, 1.0}) {
                const double root = begin + half * (2 * cell + 1 + side / std::sqrt(3.0));
                const double r = root * root;
                const double number = number_between(droplets, i, r) / largest;
                if (number > 0) sizes.push_back({x_of_um * r, number * root * half});
            }
    }
    return sizes;
}

}  // namespace

EffectiveSize effective_size(const Droplets& droplets) {
    switch (droplets.distribution) {
        case Distribution::modified_gamma: return size_of_modified_gamma(droplets);
        case Distribution::rows: return size_of_rows(droplets);
        default: return {droplets.effective_radius, droplets.effective_variance};
    }
}

bool have_same_sizes(const Droplets& a, const Droplets& b) noexcept {
    if (a.distribution != b.distribution) return false;
    switch (a.distribution) {
        case Distribution::modified_gamma:
            return a.mode_radius == b.mode_radius && a.alpha == b.alpha && a.gamma == b.gamma;
        case Distribution::rows: return a.radius == b.radius && a.number == b.number;
        default:
            return a.effective_radius == b.effective_radius &&
                   a.effective_variance == b.effective_variance;
    }
}

RadiusRange radius_range(const Droplets& droplets) {
    if (droplets.distribution == Distribution::rows) {
        const double unit = effective_size(droplets).radius;
        return {droplets.radius.front() / unit, droplets.radius.back() / unit};
    }
    if (droplets.has_effective_parameters() && droplets.effective_variance == 0) return {1, 1};
    const Curve curve = size_curve(droplets);
    // Cross-sections go as r^2; the intensity straight on, the most sensitive to large droplets, as
    // r^4.
    return {radius_of_small_share(curve, 2, 1e-9), radius_of_small_share(curve, 4, 1e4)};
}

std::vector<SphereSize> sphere_sizes(const Droplets& droplets, int count) {
    const double x = 2 * pi * effective_size(droplets).radius / droplets.wavelength;
    if (droplets.distribution == Distribution::rows)
        return sizes_of_rows(droplets, 2 * pi / droplets.wavelength, count);
    if (droplets.has_effective_parameters() && droplets.effective_variance == 0) return {{x, 1}};
    const Curve curve = size_curve(droplets);
    const RadiusRange range = radius_range(droplets);
    // Even in the square root of x, on multiples of a power of two: resonances, narrower than any step,
    // count alike for droplets of nearly the same radius or wavelength.
    const double begin = std::sqrt(range.min * x), end = std::sqrt(range.max * x),
                 step = std::exp2(std::floor(std::log2((end - begin) / count)));
    const double reference = log_number(curve, 1);
    std::vector<SphereSize> sizes;
    for (double n = std::ceil(begin / step); n * step <= end; ++n) {
        const double root = n * step;
        sizes.push_back(
            {root * root, root * std::exp(log_number(curve, root * root / x) - reference)});
    }
    return sizes;
}

}  // namespace stratus
