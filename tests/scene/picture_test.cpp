// Pictures by the plan and its tables against those with all effects and tables that are ten times
// finer; many more under bench/picture_bench.cpp.
#include <stratus/scene/plan.h>
#include <stratus/scene/render.h>

#include "random_scene.h"

#include <gtest/gtest.h>

#include <string>

namespace stratus {
namespace {

class RandomPicture : public testing::TestWithParam<unsigned> {};

TEST_P(RandomPicture, KeepsTheTolerance) {
    const Scene scene = RandomScene(GetParam()).scene();
    Scene planned = scene;
    planned.effects = plan_scene(scene).effects;
    const auto tables = bake_for({planned}), finer = bake_finer(scene, 10);
    const Image found = render(planned, LayerLight(planned, tables[0].get())),
                expected = render(scene, LayerLight(scene, finer[0].get()));
    const PictureDifference difference = difference_between(expected, found, scene.tolerance);
    EXPECT_LE(difference.most, scene.tolerance)
        << "at (" << difference.x << ", " << difference.y << "), " << difference.exceeding << " of "
        << difference.lit << " lit pixels";
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomPicture, testing::Range(1001u, 1021u),
                         [](const auto& seed) { return std::to_string(seed.param); });

}  // namespace
}  // namespace stratus
