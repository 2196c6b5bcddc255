// Plans: which effects a scene needs for a tolerance, what each contributes to its picture and what
// each costs.
//
// What an effect contributes is measured: a sparse set of the scene's own pixels is rendered with
// everything and without it. A pixel's change is relative to its brightest channel with everything,
// but not to less than 1 % of the brightest pixel. Orders n >= 2 are looked up in tables that are
// good to 1e-2, which are baked in a moment.
#pragma once

#include <stratus/bake/bake.h>
#include <stratus/scene/layer_light.h>
#include <stratus/scene/scene.h>

#include <optional>
#include <string>
#include <vector>

namespace stratus {

/// One effect of a scene.
struct EffectShare {
    std::string name;
    bool SceneEffects::*effect = nullptr;
    double mean = 0;     // change of all pixels' light without it, relative to that light
    double largest = 0;  // relative change of one pixel
    bool needed = true;
};

/// What a scene costs with some of its effects.
struct SceneCost {
    double bake_seconds = 0;  // all threads; worked out from a bake of one albedo
    double bytes = 0;         // of tables
    double ray_ns = 0;        // of one ray, one thread
};

struct PlanCosts {
    SceneCost all, planned;
    std::vector<SceneCost> without;  // each effect of the plan's `shares` alone
};

struct Plan {
    double tolerance = 0;             // the scene's
    SceneEffects effects;             // that are needed
    std::vector<EffectShare> shares;  // of those that the scene has switched on
    double change = 0;  // largest change of a pixel with all left out that is not needed
    int pixels = 0;     // looked at
    std::optional<PlanCosts> costs;
};

struct PlanOptions {
    BakeOptions bake;
    bool costs = false;  // measure them too
};

/// A plan for each of several scenes, measured in tables that they share where they can. An effect
/// is left out when no pixel then changes by more than half the scene's tolerance, the size of the
/// sun by a quarter; the rest is kept for pixels between those looked at. What saves most is tried
/// first.
std::vector<Plan> plan_scenes(const std::vector<Scene>& scenes, const PlanOptions& options = {});

/// What the sparse set of a scene's pixels asks of its layer.
AskedRange measure_range(const Scene& scene);

}  // namespace stratus
