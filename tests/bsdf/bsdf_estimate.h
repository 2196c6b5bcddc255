// What a renderer does with a BSDF: directions, evenly spread random numbers, and the mean of eval
// * cos / pdf.
#pragma once

#include <stratus/bsdf/bsdf.h>

#include <cmath>
#include <vector>

namespace stratus {

inline Vector direction(double mu, double azimuth, bool up) {
    const double sine = std::sqrt((1 - mu) * (1 + mu));
    return {static_cast<float>(sine * std::cos(azimuth)),
            static_cast<float>(sine * std::sin(azimuth)), static_cast<float>(up ? mu : -mu)};
}

inline double length(const Vector& w) {
    return std::sqrt(double{w.x} * double{w.x} + double{w.y} * double{w.y} +
                     double{w.z} * double{w.z});
}

struct RandomNumbers {
    float u1, u2, u3;
};

/// Multiples of three irrational numbers without their whole parts.
inline std::vector<RandomNumbers> evenly_spread(int count) {
    constexpr double generator = 1.2207440846057596;  // x^4 = x + 1
    const auto part = [](double x) { return static_cast<float>((x - std::floor(x)) * (1 - 1e-7)); };
    std::vector<RandomNumbers> numbers;
    for (int n = 1; n <= count; ++n)
        numbers.push_back({part(n / generator), part(n / (generator * generator)),
                           part(n / (generator * generator * generator))});
    return numbers;
}

struct Estimate {
    double reflected = 0, transmitted = 0;
    double deviation = 0;  // of eval * cos / pdf, relative to its mean
};

inline Estimate estimated(const Bsdf& bsdf, const Vector& wi, int count) {
    Estimate estimate;
    double squares = 0;
    for (const RandomNumbers& u : evenly_spread(count)) {
        const Bsdf::Sample drawn = bsdf.sample(wi, u.u1, u.u2, u.u3);
        if (!(drawn.pdf > 0)) continue;
        const double share = double{drawn.value} * double{std::abs(drawn.wo.z)} / double{drawn.pdf};
        (drawn.wo.z * wi.z > 0 ? estimate.reflected : estimate.transmitted) += share / count;
        squares += share * share / count;
    }
    const double mean = estimate.reflected + estimate.transmitted;
    estimate.deviation = std::sqrt(std::max(squares - mean * mean, 0.0)) / mean;
    return estimate;
}

}  // namespace stratus
