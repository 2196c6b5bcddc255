// Plans: which effects a scene needs for a tolerance, what each contributes to its picture and what
// each costs.
//
// Contributions are measured: a sparse set of the scene's pixels is rendered with all effects and
// without one. A pixel's change is relative to its brightest channel, or to 1 % of the brightest
// pixel if that is more. Orders n >= 2 are looked up in tables of tolerance 1e-2, which are quick
// to bake.
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
    double mean = 0;  // summed change of all pixels without it, over their summed light
    double max = 0;   // relative change of a pixel
    bool needed = true;
};

/// What a scene costs with some of its effects.
struct SceneCost {
    double bake_seconds = 0;  // all threads; extrapolated from a bake of one albedo
    double bytes = 0;         // of tables
    double ray_ns = 0;        // a ray, on one thread
};

struct PlanCosts {
    SceneCost all, planned;
    std::vector<SceneCost> without;  // one effect of the plan's `shares` each
};

struct Plan {
    double tolerance = 0;             // the scene's
    SceneEffects effects;             // needed
    std::vector<EffectShare> shares;  // of the effects that are on in the scene
    double max_change = 0;            // of a pixel, with no effect that is not needed
    int pixels = 0;                   // measured
    std::optional<PlanCosts> costs;
};

struct PlanOptions {
    BakeOptions bake;
    bool costs = false;  // measure them as well
};

/// A plan for each of several scenes, measured in tables that they share where possible. An effect
/// is left out when no pixel then changes by more than half the scene's tolerance (the size of the
/// sun: a quarter); the other half is for pixels between the measured ones. The most expensive
/// effects are tried first.
std::vector<Plan> plan_scenes(const std::vector<Scene>& scenes, const PlanOptions& options = {});

/// What the sparse set of a scene's pixels looks up of its layer.
LookupRange measure_range(const Scene& scene);

}  // namespace stratus
