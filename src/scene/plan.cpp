#include <stratus/scene/plan.h>

#include <algorithm>

namespace stratus {
namespace {

/// Joins the estimates of all channels of a scene; ends at the first that needs both.
OrderEstimates estimates_of(const Scene& scene, double enough) {
    OrderEstimates all;
    for (const Scene& channel : channel_scenes(scene)) {
        const OrderEstimates one = estimate_orders(channel, enough);
        join(all.multiple, one.multiple);
        join(all.azimuth, one.azimuth);
        if (all.multiple.change > enough && all.azimuth.change > enough) break;
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
    const OrderEstimates estimates = estimates_of(scene, enough);
    if (multiple && estimates.multiple.change <= enough) {
        plan.effects.multiple = false;
        plan.left_out.push_back({"multiple", estimates.multiple});
    } else if (azimuth && estimates.azimuth.change <= enough) {
        plan.effects.azimuth = false;
        plan.left_out.push_back({"azimuth", estimates.azimuth});
    }
    return plan;
}

}  // namespace stratus
