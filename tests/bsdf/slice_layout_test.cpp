// What docs/runtime.md says of the samples of a slice, read from them.
#include <stratus/layer/single_scattering.h>
#include <stratus/table/lookup.h>

#include "bsdf/slice_parts.h"
#include "small_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace stratus {
namespace {

/// The coordinate of cosines, and its inverse by bisection.
double v_of(double mu) { return std::sqrt(1 - mu) * (1 - std::pow(mu, 0.25) / 2); }

double mu_of(double v) {
    double low = 0, high = 1;
    for (int i = 0; i < 100; ++i) {
        const double middle = (low + high) / 2;
        (v_of(middle) > v ? low : high) = middle;
    }
    return (low + high) / 2;
}

TEST(SliceLayout, IsAsDocumented) {
    constexpr double albedo = 0.9, depth = 1.3;
    const Table table = smooth_table(true);
    const TableView view = table.view();
    const RefinedSamples slice =
        refine(view, {{layer_blend(view, Side::reflection, albedo, depth), {}}},
               [](int, double, double, double) { return 0.1; });
    ASSERT_TRUE(slice.symmetric);
    ASSERT_GE(slice.columns, 17);
    ASSERT_LE(slice.columns, 177);
    ASSERT_GE(slice.azimuths, 7);
    ASSERT_LE(slice.azimuths, 131);
    const int last = slice.columns - 1, last_azimuth = slice.azimuths - 3;
    const double first_v = v_of(view.mu_in.highest), last_v = v_of(view.mu_in.lowest);
    std::size_t row = 0;  // where it starts
    for (int i = 0; i <= last; ++i) {
        const double mu = mu_of(first_v + (last_v - first_v) * i / last);
        for (int j = 0; j <= i; j += std::max(1, i / 3)) {
            const double other = mu_of(first_v + (last_v - first_v) * j / last);
            for (int k = -1; k <= last_azimuth; ++k) {  // -1: before azimuth 0, as after it
                const double azimuth =
                    2 * std::asin(std::min(1.0, static_cast<double>(std::abs(k)) / last_azimuth));
                const std::size_t at =
                    (row + static_cast<std::size_t>(j)) * static_cast<std::size_t>(slice.azimuths) +
                    static_cast<std::size_t>(k + 1);
                const double R = static_cast<double>(slice.sample.at(at)) *
                                 intercepted_share(depth, mu) * intercepted_share(depth, other);
                const double expected =
                    reflection(view, albedo, depth, {mu, other, azimuth}).multiple;
                EXPECT_NEAR(R, expected, 2e-5 * expected) << mu << ' ' << other << ' ' << azimuth;
            }
        }
        row += static_cast<std::size_t>(i + 2);  // columns 0 to i + 1
    }
}

}  // namespace
}  // namespace stratus
