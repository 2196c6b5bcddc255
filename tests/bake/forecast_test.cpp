#include <stratus/bake/forecast.h>

#include "refusal.h"
#include "small_recipe.h"

#include <gtest/gtest.h>

#include <string>

namespace stratus {
namespace {

using test::explicit_recipe;

/// A tolerance that no axis of mu reaches, cheap to measure.
Recipe out_of_reach() {
    return parse_recipe(
        "phase_function = 'isotropic'\n"
        "tolerance = 1e-6\n"
        "optical_depth = { min = inf, max = inf }\n"
        "albedo = { min = 0.8999, max = 0.9 }\n"
        "sides = ['reflection']\n"
        "[discretisation]\n"
        "nodes = 16\n"
        "albedo_samples = 2\n");
}

TEST(Forecast, HasTheSizeOfTheTable) {
    for (const bool over_ground : {false, true}) {
        Recipe recipe = explicit_recipe();
        if (over_ground) {
            recipe.lower_boundary = LowerBoundary::surface(0.3);
            recipe.transmission = false;
        }
        const Forecast ahead = forecast(recipe);
        const Table table = solve_table(ahead.resolved);
        EXPECT_EQ(ahead.samples_a_side, static_cast<double>(table.sample_count()));
        std::size_t numbers = 0;
        for (const std::vector<float>* samples :
             {&table.reflection_multiple, &table.transmission_multiple, &table.plane_albedo,
              &table.diffuse_transmittance, &table.spherical_albedo})
            numbers += samples->size();
        EXPECT_EQ(ahead.bytes, static_cast<double>(numbers * sizeof(float)));
        EXPECT_GT(ahead.bake_seconds, 0);
        EXPECT_GT(ahead.check_seconds, 0);
        EXPECT_TRUE(ahead.shortfalls.empty());
        EXPECT_FALSE(ahead.misses(recipe.tolerance));
    }
}

TEST(Forecast, TimesMembersOfAFamilyApart) {
    const Forecast ahead =
        forecast(parse_recipe("phase_function = 'henyey_greenstein:g=0.5'\n"
                              "tolerance = 1e-2\n"
                              "optical_depth = { min = 1.0, max = 4.0 }\n"
                              "albedo = { min = 0.9, max = 0.9 }\n"
                              "[family]\n"
                              "g = [0.0, 0.9]\n"
                              "[discretisation]\n"
                              "nodes = 24\n"
                              "modes = 48\n"
                              "mu_samples = 20\n"
                              "azimuth_samples = 17\n"
                              "optical_depth_samples_per_octave = 2\n"
                              "albedo_samples = 1\n"
                              "g_samples = 5\n"));
    const std::vector<double>& seconds = ahead.unit_seconds;
    ASSERT_EQ(seconds.size(), 10u);
    EXPECT_GT(seconds.back(), 2 * seconds.front());  // one mode against 48
}

TEST(Forecast, NamesAnAxisAtItsCapAndWhatWouldDo) {
    const Forecast ahead = forecast(out_of_reach());
    ASSERT_EQ(ahead.shortfalls.size(), 1u);
    const Shortfall& axis = ahead.shortfalls[0];
    EXPECT_EQ(axis.name, "mu_samples");
    EXPECT_EQ(axis.value, ahead.resolved.discretisation.mu_samples);
    EXPECT_GT(axis.error, axis.allowed);
    EXPECT_GT(axis.needed, axis.value);
    EXPECT_GT(axis.needed_bytes, ahead.bytes);
    const std::string sentence = describe(axis);
    for (const char* part : {"mu_samples", "at its cap of 56", "would do", "share"})
        expect_holds(sentence, part);
}

TEST(Forecast, MissesWhereAnAxisAloneDoes) {
    Forecast ahead;
    ahead.shortfalls = {{{"mu_samples", 56, 2e-3, 80}, 5e-4, 1e6, 1}};
    EXPECT_TRUE(ahead.misses(1e-3));
    EXPECT_FALSE(ahead.misses(2e-3));
}

TEST(Bake, WarnsOfAnAxisAtItsCapBeforeItSolves) {
    std::vector<std::string> told;
    BakeOptions options;
    options.note = [&](const std::string& line) { told.push_back(line); };
    options.progress = [&](double, const std::string& stage) {
        if (told.empty() || told.back() != stage) told.push_back(stage);
    };
    bake(out_of_reach(), options);
    const auto place = [&](const std::string& begin) {
        std::size_t n = 0;
        while (n < told.size() && !told[n].starts_with(begin)) ++n;
        return n;
    };
    EXPECT_LT(place("warning: mu_samples is at its cap"), place("baking"));
    EXPECT_LT(place("baking"), told.size());
}

}  // namespace
}  // namespace stratus
