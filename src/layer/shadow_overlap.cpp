#include "shadow_overlap.h"

#include <stratus/base/constants.h>
#include <stratus/base/gauss_legendre.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

constexpr double longest_panel = 1;
constexpr double deepest = 40;  // n O <= v: exp(-40) is left out

/// G(q) / pi.
double shared_volume(double q) noexcept {
    if (q >= 1) return 4 / (3 * pi);
    if (q < 1e-3) return q * (1 - q * (2 - q * q / 6) / pi);  // Taylor
    const double w = std::sqrt((1 - q) * (1 + q));
    return (2 * q * std::acos(q) - 2 * w + (4 + 2 * w * w * w) / 3) / pi;
}

}  // namespace

ShadowOverlap::ShadowOverlap(double radius, double sine, double cosine) noexcept
    : far_(radius / (sine * cosine)), near_(radius * sine / cosine) {}

double ShadowOverlap::operator()(double u) const noexcept {
    const auto grown = [u](double scale) { return scale * shared_volume(u / scale); };
    if (std::isinf(near_)) return 0;  // a = pi
    const double all = std::isinf(far_) ? u : grown(far_);
    return near_ == 0 ? all : std::max(0.0, all - grown(near_));
}

double ShadowOverlap::brightening(double eta, double begin, double end) const noexcept {
    const double last = std::min(end, deepest);
    double sum = 0;
    // The overlap has two kinks, and is constant behind the second.
    const double kinks[] = {begin, std::clamp(near_ / eta, begin, std::max(begin, last)),
                            std::clamp(far_ / eta, begin, std::max(begin, last))};
    for (int part = 0; part < 2; ++part) {
        const double length = kinks[part + 1] - kinks[part];
        const int panels = static_cast<int>(std::ceil(length / longest_panel));
        const double half = length / panels / 2;
        for (int panel = 0; panel < panels; ++panel) {
            const double middle = kinks[part] + (2 * panel + 1) * half;
            for (int k = 0; k < 4; ++k)
                for (const double side : {-1.0, 1.0}) {
                    const double v = middle + side * half * gauss_8_node[k];
                    sum += half * gauss_8_weight[k] * 2 * std::exp(-2 * v) *
                           std::expm1((*this)(eta * v));
                }
        }
    }
    const double constant_from = kinks[2];
    if (constant_from < last)
        sum +=
            std::expm1((*this)(eta * last)) * (std::exp(-2 * constant_from) - std::exp(-2 * end));
    return sum;
}

}  // namespace stratus
