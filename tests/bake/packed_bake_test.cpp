// Bakes straight into packed tables, of which all samples are never formed.
#include "random_recipe.h"

#include "small_recipe.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

class RandomRecipe : public testing::TestWithParam<unsigned> {};

TEST_P(RandomRecipe, MeetsItsTolerance) {
    const std::string text = test::random_recipe(GetParam());
    const test::PackedBake baked(parse_recipe(text));
    EXPECT_TRUE(baked.meets()) << text << "largest error "
                               << baked.verification.samples.back().error;
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomRecipe, testing::Values(3u, 11u, 19u));

TEST(PackedBake, LooksUpWhatATableOfAllSamplesHolds) {
    const Recipe recipe = test::explicit_recipe();
    const test::PackedBake baked(recipe);
    const Table table = solve_table(resolve(recipe));
    const PackedTable direct(baked.file), packed(pack(table));
    const Table found = direct.unpacked();
    ASSERT_EQ(found.reflection_multiple.size(), table.reflection_multiple.size());
    // Both miss the solver by half of the tolerance at most.
    for (const double mu : {0.05, 0.3, 1.0})
        for (const double azimuth : {0.0, 1.0, 3.0})
            for (const double depth : {0.3, 1.0}) {
                const Geometry at{mu, 0.6, azimuth};
                const double expected = packed.reflection(0.8, depth, at).total();
                EXPECT_NEAR(direct.reflection(0.8, depth, at).total(), expected,
                            recipe.tolerance * expected);
            }
    EXPECT_EQ(baked.header.plane_albedo, table.plane_albedo);
    EXPECT_EQ(baked.header.spherical_albedo, table.spherical_albedo);
}

TEST(PackedBake, GivesTheSameBytesOnAnyNumberOfThreads) {
    const Recipe recipe = resolve(test::explicit_recipe());
    std::vector<char> files[2];
    for (int n = 0; n < 2; ++n) {
        BakeOptions options;
        options.threads = 1 + 2 * n;
        options.packed = &files[n];
        bake(recipe, options);
    }
    EXPECT_EQ(files[0], files[1]);
}

}  // namespace
}  // namespace stratus
