// Plans of the gallery's scenes, checked on pixels that they did not measure.
#include <stratus/scene/plan.h>
#include <stratus/scene/render.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace stratus {
namespace {

/// Maximum relative change of a pixel, as plan.h defines it.
double max_change(const Image& all, const Image& some) {
    const auto brightest = [](const float* pixel) {
        return std::max({pixel[0], pixel[1], pixel[2]});
    };
    float max_light = 0;
    for (std::size_t i = 0; i < all.rgb.size(); i += 3)
        max_light = std::max(max_light, brightest(&all.rgb[i]));
    double max = 0;
    for (std::size_t i = 0; i < all.rgb.size(); ++i) {
        const float here = brightest(&all.rgb[i - i % 3]);
        max = std::max(max, double{std::abs(all.rgb[i] - some.rgb[i])} /
                                double{std::max(here, 0.01f * max_light)});
    }
    return max;
}

/// At tolerances at which some effect is not needed.
class GalleryPlan : public testing::TestWithParam<const char*> {};

TEST_P(GalleryPlan, ChangesNoPixelByMoreThanTheTolerance) {
    SceneFile file = read_scene(std::filesystem::path(STRATUS_REFERENCE_FOLDER) /
                                "../../tables/scenes" / GetParam());
    ASSERT_FALSE(file.figure);
    std::vector<Scene> scenes;
    for (Scene& scene : file.panels) {
        scene.tolerance = 0.03;
        scene.width = std::max(1, scene.width / 3);
        scene.height = std::max(1, scene.height / 3);
        scene.samples = 1;
        scenes.push_back(scene);
    }
    const std::vector<Plan> plans = plan_scenes(scenes);
    std::vector<Scene> planned = scenes;
    bool less = false;
    for (std::size_t s = 0; s < scenes.size(); ++s) {
        planned[s].effects = plans[s].effects;
        for (const EffectShare& share : plans[s].shares) less = less || !share.needed;
        // Pixels that the plan did not measure.
        for (Scene* const scene : {&scenes[s], &planned[s]}) {
            scene->width = std::max(1, scene->width * 5 / 7);
            scene->height = std::max(1, scene->height * 5 / 7);
            scene->tolerance = 0.01;
        }
    }
    EXPECT_TRUE(less);
    std::vector<Scene> both = scenes;
    both.insert(both.end(), planned.begin(), planned.end());
    const auto tables = bake_for(both);
    for (std::size_t s = 0; s < scenes.size(); ++s) {
        const LayerLight all_light(scenes[s], tables[s].get()),
            some_light(planned[s], tables[scenes.size() + s].get());
        const Image all = render(scenes[s], all_light), some = render(planned[s], some_light);
        EXPECT_LE(max_change(all, some), plans[s].tolerance) << scenes[s].title;
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, GalleryPlan,
                         testing::Values("saturn_lit.toml", "saturn_unlit.toml", "full_moon.toml",
                                         "cloudy_planet.toml", "broken_clouds.toml", "fogbow.toml",
                                         "corona.toml"),
                         [](const auto& scene) {
                             const std::string name = scene.param;
                             return name.substr(0, name.find('.'));
                         });

}  // namespace
}  // namespace stratus
