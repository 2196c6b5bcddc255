#include <stratus/scene/plan.h>

#include <algorithm>

namespace stratus {
namespace {

/// Of all channels of a scene; ends at the first that needs both.
OrderBounds bounds_of(const Scene& scene, double enough) {
    OrderBounds all;
    for (const Scene& channel : channel_scenes(scene)) {
        const OrderBounds one = bound_orders(channel, enough);
        join(all.multiple, one.multiple);
        join(all.azimuth, one.azimuth);
        if (all.multiple.bound > enough && all.azimuth.bound > enough) break;
    }
    return all;
}

}  // namespace

Plan plan_scene(const Scene& scene) {
    Plan plan{scene.tolerance, scene.effects, {}};
    const bool needs_table = std::ranges::any_of(
        channel_scenes(scene), [](const Scene& channel) { return !needed_paths(channel).empty(); });
    if (!needs_table) return plan;
    const auto may_go = [&](bool SceneEffects::*effect) {
        return scene.effects.*effect && std::ranges::find(scene.named, effect) == scene.named.end();
    };
    const bool multiple = may_go(&SceneEffects::multiple) && scene.effects.single,
               azimuth = may_go(&SceneEffects::azimuth);
    if (!multiple && !azimuth) return plan;
    const double enough = share_left_out * scene.tolerance;
    const OrderBounds bounds = bounds_of(scene, enough);
    if (multiple && bounds.multiple.bound <= enough) {
        plan.effects.multiple = false;
        plan.left_out.push_back({"multiple", bounds.multiple});
    } else if (azimuth && bounds.azimuth.bound <= enough) {
        plan.effects.azimuth = false;
        plan.left_out.push_back({"azimuth", bounds.azimuth});
    }
    return plan;
}

}  // namespace stratus
