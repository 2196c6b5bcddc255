#include <stratus/scene/plan.h>

#include <algorithm>

namespace stratus {
Plan plan_scene(const Scene& scene) {
    Plan plan{scene.tolerance, scene.effects, {}};
    const auto may_go = [&](EffectFlag effect) {
        return scene.effects.*effect && std::ranges::find(scene.named, effect) == scene.named.end();
    };
    double enough = share_left_out * scene.tolerance;
    if (seen_shell(scene) > 0 && may_go(&SceneEffects::shell)) {
        const ChangeEstimate shell = estimate_shell(scene, enough);
        if (shell.change <= enough) {
            plan.effects.shell = false;
            plan.left_out.push_back({"shell", shell});
            enough -= shell.change;  // what else is left out may change the rest
        }
    }
    const Scene rest = with_effects(scene, plan.effects);
    const bool needs_table = std::ranges::any_of(
        channel_scenes(rest), [](const Scene& channel) { return !needed_paths(channel).empty(); });
    if (!needs_table) return plan;
    const bool multiple = may_go(&SceneEffects::multiple) && scene.effects.single,
               azimuth = may_go(&SceneEffects::azimuth);
    if (!multiple && !azimuth) return plan;
    const OrderEstimates estimates = estimate_orders(rest, enough);
    if (multiple && estimates.multiple.change <= enough) {
        plan.effects.multiple = false;
        plan.left_out.push_back({"multiple", estimates.multiple});
    } else if (azimuth && estimates.azimuth.change <= enough) {
        plan.effects.azimuth = false;
        plan.left_out.push_back({"azimuth", estimates.azimuth});
    }
    return plan;
}

void leave_out(const Plan& plan, Scene& scene) {
    for (const LeftOut& effect : plan.left_out) scene.effects.*scene_effect(effect.name) = false;
}

Plan plan_frames(const std::vector<const Scene*>& frames) {
    Plan plan = plan_scene(*frames[0]);
    for (std::size_t k = 1; k < frames.size() && !plan.left_out.empty(); ++k) {
        const std::vector<LeftOut> other = plan_scene(*frames[k]).left_out;
        std::erase_if(plan.left_out, [&](LeftOut& effect) {
            const auto same = std::ranges::find(other, effect.name, &LeftOut::name);
            if (same != other.end()) join(effect.change, same->change);
            return same == other.end();
        });
    }
    Scene first = *frames[0];
    leave_out(plan, first);
    plan.effects = first.effects;
    return plan;
}

std::vector<Plan> follow_plans(Film& film) {
    std::vector<Plan> plans;
    for (std::size_t k = 0; k < film[0].panels.size(); ++k) {
        std::vector<const Scene*> frames;
        for (const SceneFile& frame : film) frames.push_back(&frame.panels[k]);
        plans.push_back(plan_frames(frames));
        for (SceneFile& frame : film) leave_out(plans.back(), frame.panels[k]);
    }
    return plans;
}

}  // namespace stratus
