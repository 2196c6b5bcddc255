// Random scenes of few pixels, and how much their pictures change with their effects.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/scene/plan.h>
#include <stratus/scene/render.h>

#include "random_scene.h"

#include <cmath>
#include <string>
#include <utility>

namespace stratus::test {

/// Maximum change of a pixel relative to its own light, or to 1 % of the brightest.
inline double max_change(const Image& all, const Image& some) {
    return difference_between(all, some, infinity).most;
}

inline Image picture(const Scene& scene) { return render(scene, BakedLight(scene)); }

/// How much a picture changes without one of its effects: the largest change of a pixel, and of what
/// is estimated.
struct FoundChange {
    const char* effect;
    double estimate, found;
    std::string where;  // the estimate's
};

/// Of the orders n >= 2, of their azimuth, and of a shell, where a scene has them and its estimate leaves a
/// doubt.
inline std::vector<FoundChange> changes_of(const Scene& scene) {
    const bool has_shell = seen_shell(scene) > 0;
    std::vector<FoundChange> changes;
    if (needed_paths(scene).empty() && !has_shell) return changes;
    const OrderEstimates estimates = estimate_orders(scene, infinity);
    const Image all = picture(scene);
    const auto add = [&](const char* name, const ChangeEstimate& estimate,
                         bool SceneEffects::*effect) {
        if (estimate.change >= 1) return;
        Scene less = scene;
        less.effects.*effect = false;
        double found = max_change(all, picture(less));
        if (found > estimate.change) {  // or the tables' own errors: found again with finer ones
            Scene fine = scene;
            fine.tolerance = less.tolerance = scene.tolerance / 10;
            found = max_change(picture(fine), picture(less));
        }
        changes.push_back({name, estimate.change, found, estimate.where});
    };
    add("multiple", estimates.multiple, &SceneEffects::multiple);
    add("azimuth", estimates.azimuth, &SceneEffects::azimuth);
    if (has_shell) add("shell", estimate_shell(scene, infinity), &SceneEffects::shell);
    return changes;
}

class RandomScenes : private RandomParts {
  public:
    using RandomParts::RandomParts;

    Scene next() {
        Scene scene;
        switch (static_cast<int>(between(0, 3))) {
            case 0: scene = rings(); break;
            case 1: scene = planet(); break;
            default: scene = slab();
        }
        scene = with_picture(std::move(scene));
        scene.to_sun = direction_at(std::asin(between(-1, 1)), between(0, 2 * pi));
        if (happens(0.2)) scene.sun_diameter = radians(between(0.1, 2));
        if (happens(0.2)) scene.layer.density = between(0.01, 0.3);
        if (happens(0.3)) scene.layer.opposition = Opposition::hapke(1, power(-3, -1));
        return scene;
    }

    /// A stack as the layer of a planet, or of a slab that is seen from its lit side; in colours of one phase
    /// function.
    Scene stack() {
        Scene scene = next();
        while (std::holds_alternative<Rings>(scene.subject)) scene = next();
        scene.to_sun.z = std::abs(scene.to_sun.z);
        scene.sun_diameter = scene.layer.density = 0;
        scene.layer.opposition = {};
        std::vector<std::vector<StackLayer>> stacks(happens(0.5) ? 3 : 1);
        const double white = power(-2.5, 0);
        for (int k = happens(0.5) ? 3 : 2; k > 0; --k) {
            const double depth = power(-3, 1);
            const PhaseFunction scattering = phase_function(0.7);
            for (auto& each : stacks)
                each.push_back({scattering, white * between(0.01, 1), depth * between(0.7, 1)});
        }
        scene.layer = layer_of_stacks(stacks);
        return scene;
    }

    /// A planet whose layer is a shell, seen whole or in part, from afar or from close by.
    Scene shell() {
        Scene scene = with_picture(planet());
        scene.layer.albedo = tint(1);
        DepthMap& depth = scene.layer.optical_depth;
        depth.max = power(-2, std::log10(50));
        if (happens(0.2)) depth.pattern = DepthMap::Pattern::clouds;
        Planet& planet = the_planet(scene);
        planet.shell = power(-5, std::log10(std::min(0.05, 0.05 / depth.max)));
        if (happens(0.3)) {
            planet.surface.pattern = Texture::Pattern::continents;
            planet.surface.other = colour();
        }
        scene.to_sun = direction_at(std::asin(between(-1, 1)), between(0, 2 * pi));
        Camera& camera = scene.camera;
        const Vector3 aside = direction_at(between(0, pi), between(0, 2 * pi));
        if (happens(0.6)) {  // a part of the disk
            camera.position = between(1.1, 5) * direction_at(0, 0);
            camera.look_at = between(0, 0.7) * aside;
            camera.width = camera.orthographic ? power(-2, 0) : power(-2, -0.3);
        }
        if (happens(0.2)) scene.sun_diameter = radians(between(0.1, 2));
        return scene;
    }

    /// A scene that grids of directions and samples of pixels may misjudge: a thin ringlet in a faint
    /// ring, a grazing sun, a narrow forward peak, or a sun behind the camera.
    Scene adversarial() {
        Scene scene = next();
        switch (static_cast<int>(between(0, 4))) {
            case 0: {
                scene = with_picture(rings());
                auto& profile = the_rings(scene).profile;
                const double half_width = power(-5, -3), depth = power(-3, -1.5);
                profile.radius = {
                    1.5, 2 - 2 * half_width, 2 - half_width, 2 + half_width, 2 + 2 * half_width,
                    2.5};
                const double brightest = power(-3, -1);
                profile.optical_depth = {depth, depth, 30 * depth, 30 * depth, depth, depth};
                profile.w1 = profile.w2 = {brightest / 4, brightest / 4, brightest / 2,
                                           brightest / 2, brightest / 4, brightest / 4};
                scene.camera.orthographic = true;
                scene.camera.position = 10.0 * direction_at(std::asin(between(0.2, 1)), 0);
                scene.camera.look_at = {2, 0, 0};
                scene.camera.width = 8 * half_width;
                return scene;
            }
            case 1:
                scene = with_picture(slab());
                scene.to_sun = direction_at(power(-3, -1), between(0, 2 * pi));
                return scene;
            case 2:
                scene = with_picture(happens(0.5) ? slab() : planet());
                scene.layer.components = {PhaseFunction::henyey_greenstein(between(0.7, 0.95))};
                return scene;
            default:
                scene = with_picture(happens(0.5) ? slab() : planet());
                scene.to_sun = normalised(scene.camera.position +
                                          length(scene.camera.position) *
                                              Vector3{0, power(-4, -1), power(-4, -1)});
                return scene;
        }
    }

  private:
    static Scene with_picture(Scene scene) {
        scene.width = 28;
        scene.height = 20;
        scene.samples = 1;
        scene.tolerance = 0.01;
        return scene;
    }
    std::array<double, 3> tint(double most) {
        return {most * between(0.01, 1), most * between(0.01, 1), most * between(0.01, 1)};
    }

    Scene rings() {
        Scene scene = small_rings(1);
        scene.layer.components = {phase_function(0.7), phase_function(0.7)};
        scene.layer.albedo = tint(1);
        auto& subject = the_rings(scene);
        subject.surface.colour = happens(0.2) ? colour() : Rgb{0, 0, 0};
        RingProfile profile;
        const int knots = 2 + static_cast<int>(between(0, 6));
        double radius = between(1.1, 1.5);
        const double deepest = power(-4, 0.5), brightest = power(-2.5, 0);
        for (int k = 0; k < knots; ++k) {
            profile.radius.push_back(radius);
            profile.optical_depth.push_back(deepest * between(0.1, 1));
            const double w = brightest * between(0.2, 1), share = between(0, 1);
            profile.w1.push_back(w * share);
            profile.w2.push_back(w * (1 - share));
            radius += happens(0.3) ? 1e-4 : between(0.1, 0.3);  // thin ringlets among them
        }
        subject.profile = profile;
        scene.camera.position =
            between(6, 12) * direction_at(std::asin(between(-1, 1)), between(0, 2 * pi));
        scene.camera.orthographic = happens(0.5);
        scene.camera.width = scene.camera.orthographic ? between(1, 6) : radians(between(5, 40));
        if (happens(0.5)) scene.background.colour = colour();
        return scene;
    }
    Scene planet() {
        Scene scene = small_planet(0, happens(0.2) ? infinity : power(-3, 1), 1);
        scene.layer.components = {phase_function(0.7)};
        scene.layer.albedo = tint(power(-2.5, 0));
        if (happens(0.5)) the_planet(scene).surface.colour = colour();
        scene.camera.orthographic = happens(0.5);
        scene.camera.width = scene.camera.orthographic ? 2.1 : radians(25);
        return scene;
    }
    Scene slab() {
        Scene scene = small_slab(power(-3, 1), 1);
        scene.layer.components = {phase_function(0.7)};
        scene.layer.albedo = tint(power(-2.5, 0));
        scene.background.colour = happens(0.5) ? colour() : Rgb{0, 0, 0};
        scene.camera.position =
            10.0 * direction_at(std::asin(between(0.05, 1)), between(0, 2 * pi));
        scene.camera.orthographic = happens(0.5);
        scene.camera.width = scene.camera.orthographic ? 2 : radians(between(10, 90));
        auto& subject = the_slab(scene);
        if (happens(0.3)) {
            subject.surface.emplace();
            subject.surface->colour = colour();
        }
        if (happens(0.3)) {
            cover_with_clouds(scene);
            scene.layer.optical_depth.scale = 0.5;
        }
        return scene;
    }
};

}  // namespace stratus::test
