// The scenes' profile of Saturn's rings is as bright as the rings that the Hubble Space Telescope
// saw. `saturn_profile_test --gtest_output=xml:/dev/stdout` prints I/F of both, in thousandths.
#include <stratus/base/constants.h>
#include <stratus/fit/fit.h>
#include <stratus/io/csv.h>

#include "indices.h"
#include "row_name.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace stratus {
namespace {

const std::string scenes = std::string(STRATUS_REFERENCE_FOLDER) + "/../../tables/scenes/";

struct Region {
    const char* ring;
    double inner, middle, outer;  // km, as in the headers of the observations
};
constexpr Region regions[] = {
    {"C", 78000, 80500, 83000}, {"B", 100000, 103500, 107000}, {"A", 127000, 128000, 129000}};

struct Colour {
    std::string name;
    double share;  // of the profile's albedos, as in saturn_lit.toml
};

/// Observations of one radius, beams left out.
std::vector<Observation> lit_rows(const CsvTable& rows, double radius) {
    const auto of = [&](const std::vector<double>& row, const char* column) {
        return row[static_cast<std::size_t>(rows.column(column))];
    };
    std::vector<Observation> lit;
    for (const std::vector<double>& row : rows.rows)
        if (of(row, "radius") == radius && of(row, "side") == 0)
            lit.push_back({{of(row, "mu_in"), of(row, "mu_out"), radians(of(row, "azimuth_deg"))},
                           Light::reflected,
                           of(row, "brightness"),
                           of(row, "sigma")});
    return lit;
}

/// I/F of the profile, the mean over a region.
std::vector<double> mean_brightness(const Region& region, double colour,
                                    const std::vector<Observation>& views) {
    static const CsvTable profile = read_csv(scenes + "saturn_profile.csv");
    const auto model =
        solver_model(PhaseFunction::lambert_sphere(), PhaseFunction::henyey_greenstein(0.5), 16);
    std::vector<double> sum(views.size(), 0);
    double width = 0;
    for (std::size_t r = 1; r < profile.rows.size(); ++r) {
        const std::vector<double>&a = profile.rows[r - 1], &b = profile.rows[r];
        const double step = std::min(b[0], region.outer) - std::max(a[0], region.inner);
        if (step <= 0) continue;
        const auto middle = [&](std::size_t c) { return (a[c] + b[c]) / 2; };
        const std::vector<double> at =
            model->brightness({middle(1), colour * middle(2), colour * middle(3), 0, 0.5}, views);
        for (const auto i : indices(sum)) sum[i] += step * at[i];
        width += step;
    }
    for (double& value : sum) value /= width;
    return sum;
}

class SaturnProfile : public testing::TestWithParam<Colour> {};

TEST_P(SaturnProfile, IsAsBrightAsObserved) {
    const auto& [colour, share] = GetParam();
    const CsvTable rows =
        read_csv(scenes + "saturn_observations_" + colour + ".csv", {{"side", {"lit", "beam"}}});
    for (const Region& region : regions) {
        const std::vector<Observation> observed = lit_rows(rows, region.middle);
        ASSERT_EQ(observed.size(), 6);
        const std::vector<double> ours = mean_brightness(region, share, observed);
        for (const auto i : indices(observed)) {
            // Two of the observations' standard deviations of 5 %, and as much for one colour that
            // stands for all rings.
            EXPECT_NEAR(ours[i], observed[i].brightness, 0.2 * observed[i].brightness)
                << region.ring << " ring, mu " << observed[i].geometry.mu_in;
            const auto thousandths = [](double value) { return std::lround(1000 * value); };
            const std::string key = region.ring + std::string("_") + std::to_string(i);
            RecordProperty(key + "_ours", static_cast<int>(thousandths(ours[i])));
            RecordProperty(key + "_observed",
                           static_cast<int>(thousandths(observed[i].brightness)));
        }
    }
}

INSTANTIATE_TEST_SUITE_P(In, SaturnProfile,
                         testing::Values(Colour{"red", 1.0}, Colour{"green", 0.97},
                                         Colour{"blue", 0.84}),
                         row_name);

}  // namespace
}  // namespace stratus
