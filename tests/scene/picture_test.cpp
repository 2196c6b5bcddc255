// Pictures by the plan and its tables against those with all effects and tables that are ten times
// finer; many more under bench/picture_bench.cpp.
#include <stratus/scene/plan.h>
#include <stratus/scene/render.h>

#include "random_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace stratus {
namespace {

class RandomPicture : public testing::TestWithParam<unsigned> {};

void expect_tolerance_kept(const Scene& scene) {
    Scene planned = scene;
    planned.effects = plan_scene(scene).effects;
    const Image found = render(planned, BakedLight(planned)),
                expected = render(scene, BakedLight(scene, bake_finer(scene, 10)[0]));
    const PictureDifference difference = difference_between(expected, found, scene.tolerance);
    EXPECT_LE(difference.most, scene.tolerance)
        << "at (" << difference.x << ", " << difference.y << "), " << difference.exceeding << " of "
        << difference.lit << " lit pixels";
    for (const float light : found.rgb) EXPECT_TRUE(std::isfinite(light));
}

TEST_P(RandomPicture, KeepsTheTolerance) { expect_tolerance_kept(RandomScene(GetParam()).scene()); }

INSTANTIATE_TEST_SUITE_P(Seeds, RandomPicture, testing::Range(1001u, 1021u),
                         [](const auto& seed) { return std::to_string(seed.param); });

class PictureOfAnyKind : public testing::TestWithParam<unsigned> {};

TEST_P(PictureOfAnyKind, KeepsTheTolerance) {
    expect_tolerance_kept(RandomScene(GetParam()).of_any_kind());
}

// Three colours over an ocean, a stack, a stack and then colours within rings, a stack of a planet under
// a large sun, a shell over an ocean.
INSTANTIATE_TEST_SUITE_P(Seeds, PictureOfAnyKind,
                         testing::Values(2002u, 2006u, 2009u, 2011u, 2018u, 2026u),
                         [](const auto& seed) { return std::to_string(seed.param); });

}  // namespace
}  // namespace stratus
