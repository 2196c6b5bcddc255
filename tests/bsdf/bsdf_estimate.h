// What a renderer does with a BSDF: directions, evenly spread random numbers, and the mean of eval
// * cos / pdf.
#pragma once

#include <stratus/bsdf/bsdf.h>

#include "../base/indices.h"

#include <gtest/gtest.h>

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

/// Draws of a BSDF or an RgbBsdf by them.
template <class AnyBsdf>
std::vector<typename AnyBsdf::Sample> evenly_drawn(const AnyBsdf& bsdf, const Vector& wi,
                                                   int count) {
    std::vector<typename AnyBsdf::Sample> all;
    for (const RandomNumbers& u : evenly_spread(count))
        all.push_back(bsdf.sample(wi, u.u1, u.u2, u.u3));
    return all;
}

/// Expects a share of `draws` in each bin, by chi-square: four standard deviations, once in 30,000
/// times by chance, and the draws are always the same.
template <class Shares, class Counts>
void expect_drawn(const Shares& shares, const Counts& met, int draws, int least_freedom) {
    double chi_square = 0, rare_expected = 0, rare_met = 0;
    int degrees_of_freedom = -1;
    const auto count = [&](double expected, double found) {
        chi_square += (found - expected) * (found - expected) / expected;
        ++degrees_of_freedom;
    };
    for (const auto i : indices(shares)) {
        const double expected = draws * shares[i];
        if (expected < 20) {  // too few to be normally distributed: all in one bin
            rare_expected += expected;
            rare_met += met[i];
        } else {
            count(expected, met[i]);
        }
    }
    if (rare_expected > 20) count(rare_expected, rare_met);
    ASSERT_GT(degrees_of_freedom, least_freedom);
    EXPECT_LT(chi_square, degrees_of_freedom + 4 * std::sqrt(2.0 * degrees_of_freedom))
        << degrees_of_freedom << " degrees of freedom";
}

/// Expects of samples their value and density. Within a peak of a hundredth of a radian a float knows
/// its place to 1e-3.
inline void expect_samples_carry_their_value(const Bsdf& bsdf, const Vector& wi, double accuracy) {
    for (const Bsdf::Sample& drawn : evenly_drawn(bsdf, wi, 500)) {
        ASSERT_GT(drawn.pdf, 0);
        EXPECT_EQ(drawn.value, bsdf.eval(wi, drawn.wo));
        EXPECT_NEAR(bsdf.pdf(wi, drawn.wo) / drawn.pdf, 1, accuracy) << "mu_in " << wi.z;
        EXPECT_NEAR(length(drawn.wo), 1, 1e-6);
    }
}

struct Estimate {
    double reflected = 0, transmitted = 0;
    double deviation = 0;  // of eval * cos / pdf, relative to its mean
};

inline Estimate estimated(const Bsdf& bsdf, const Vector& wi, int count) {
    Estimate estimate;
    double squares = 0;
    for (const Bsdf::Sample& drawn : evenly_drawn(bsdf, wi, count)) {
        if (!(drawn.pdf > 0)) continue;
        const double share = double{drawn.value} * double{std::abs(drawn.wo.z)} / double{drawn.pdf};
        (drawn.wo.z * wi.z > 0 ? estimate.reflected : estimate.transmitted) += share / count;
        squares += share * share / count;
    }
    const double mean = estimate.reflected + estimate.transmitted;
    estimate.deviation = std::sqrt(std::max(squares - mean * mean, 0.0)) / mean;
    return estimate;
}

/// Expects the mean of samples to be the albedo: of 2^14 points of a tenth of deviation, evenly spread,
/// or more.
inline void expect_albedo_estimated(const Bsdf& bsdf, const Vector& wi, int count) {
    const Estimate estimate = estimated(bsdf, wi, count);
    const ScatteredShares<float> albedo = bsdf.albedo(wi);
    EXPECT_NEAR(estimate.reflected, albedo.reflected, 1e-3) << "mu_in " << wi.z;
    EXPECT_NEAR(estimate.transmitted, albedo.transmitted, 1e-3) << "mu_in " << wi.z;
}

}  // namespace stratus
