// Bright scenes that nobody chose, of a few pixels, and how much two pictures differ: whether pictures
// keep their tolerance.
#pragma once

#include <stratus/io/image.h>
#include <stratus/scene/scene.h>

#include "small_scene.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <variant>
#include <vector>

namespace stratus {

/// The largest difference of a pixel relative to its own light, or to 1 % of the brightest pixel's, and
/// how many pixels differ by more than `allowed`.
struct PictureDifference {
    double most = 0;
    int exceeding = 0, lit = 0;
    int x = 0, y = 0;  // of the largest
};

inline PictureDifference difference_between(const Image& expected, const Image& found,
                                            double allowed) {
    const auto light = [&](std::size_t pixel) {
        const float* const rgb = &expected.rgb[3 * pixel];
        return double{std::max({rgb[0], rgb[1], rgb[2]})};
    };
    const std::size_t pixels = expected.rgb.size() / 3;
    double brightest = 0;
    for (std::size_t k = 0; k < pixels; ++k) brightest = std::max(brightest, light(k));
    PictureDifference difference;
    for (std::size_t k = 0; k < pixels && brightest > 0; ++k) {
        double here = 0;
        for (std::size_t c = 3 * k; c < 3 * k + 3; ++c)
            here = std::max(here, std::abs(double{expected.rgb[c]} - double{found.rgb[c]}));
        here /= std::max(light(k), 0.01 * brightest);
        difference.lit += light(k) > 0;
        difference.exceeding += here > allowed;
        if (here <= difference.most) continue;
        difference.most = here;
        difference.x = static_cast<int>(k) % expected.width;
        difference.y = static_cast<int>(k) / expected.width;
    }
    return difference;
}

/// Draws what random scenes are made of.
class RandomParts {
  public:
    explicit RandomParts(unsigned seed) : random_(seed) {}

    double between(double min, double max) {
        return std::uniform_real_distribution<double>(min, max)(random_);
    }
    double power(double min, double max) { return std::pow(10, between(min, max)); }
    bool happens(double chance) { return between(0, 1) < chance; }
    Rgb colour() {
        return {static_cast<float>(between(0, 1)), static_cast<float>(between(0, 1)),
                static_cast<float>(between(0, 1))};
    }
    PhaseFunction phase_function(double largest_g = 0.75) {
        switch (static_cast<int>(between(0, 4))) {
            case 0: return PhaseFunction::isotropic();
            case 1: return PhaseFunction::rayleigh();
            case 2: return PhaseFunction::lambert_sphere();
            default: return PhaseFunction::henyey_greenstein(between(-0.4, largest_g));
        }
    }

  private:
    std::mt19937 random_;
};

/// Half of them rings around a planet that light one another, the others slabs, with ground or a
/// background more often than not, and planets.
class RandomScene : private RandomParts {
  public:
    using RandomParts::RandomParts;

    Scene scene() {
        Scene scene = happens(0.5) ? rings() : happens(0.7) ? slab() : planet();
        scene.width = 36;
        scene.height = 24;
        scene.samples = 1;
        scene.tolerance = happens(0.5) ? 5e-3 : 1e-2;
        // Half of all suns are low.
        const double elevation = happens(0.5) ? between(-1, 1) : between(-0.2, 0.2);
        scene.to_sun = direction_at(std::asin(elevation), between(0, 2 * pi));
        return scene;
    }

    /// The same, and with them layers in three colours, stacks, shells, oceans, suns that are disks, and
    /// clouds within rings.
    Scene of_any_kind() {
        Scene scene = this->scene();
        if (happens(0.1)) scene.sun_diameter = radians(between(0.5, 10));
        if (Rings* const rings = std::get_if<Rings>(&scene.subject)) {
            rings->planet_layer = layer(happens(0.4));
            return scene;
        }
        const DepthMap usual = scene.layer.optical_depth;
        Slab* const slab = std::get_if<Slab>(&scene.subject);
        const bool is_stack = happens(0.4);
        scene.layer = layer(is_stack);
        if (is_stack && slab) {  // lit from above and seen from there
            scene.to_sun.z = std::abs(scene.to_sun.z);
            scene.sun_diameter = 0;
            scene.camera.position.z = std::abs(scene.camera.position.z);
        }
        if (!is_stack) scene.layer.optical_depth = usual;
        Planet* const planet = std::get_if<Planet>(&scene.subject);
        if (planet && !is_stack && happens(0.4))
            planet->shell = std::min(between(1e-3, 0.02), 0.05 / usual.max);
        Texture* const ground = planet          ? &planet->surface
                                : slab->surface ? &*slab->surface
                                                : nullptr;
        if (ground && happens(0.3)) *ground = ocean(between(1, 25));
        return scene;
    }

  private:
    /// Grey or in three colours.
    SceneLayer layer(bool is_stack) {
        const int colours = happens(0.5) ? 3 : 1;
        std::vector<std::vector<StackLayer>> stacks;
        for (int c = 0; c < colours; ++c) stacks.emplace_back();
        for (int k = is_stack && happens(0.5) ? 3 : is_stack ? 2 : 1; k > 0; --k) {
            const double depth = power(-1.5, 1);
            for (auto& stack : stacks)
                stack.push_back({phase_function(), between(0.5, 1), depth * between(0.7, 1)});
        }
        SceneLayer layer = layer_of_stacks(stacks);
        if (!is_stack) layer.stacks.clear();
        return layer;
    }
    static Texture ocean(double wind) {
        const SceneFile file = parse_scene(
            "camera = { distance = 5, orthographic_width = 2 }\nsun = { elevation_deg = 0 }\n"
            "layer = { phase_function = \"isotropic\", albedo = 1, optical_depth = 1 }\n"
            "planet = { surface = { wind = " +
            std::to_string(wind) + " } }\n");
        return the_planet(file.panels[0]).surface;
    }

    void look_from(Scene& scene, double distance, double degrees) {
        scene.camera.position =
            distance * direction_at(std::asin(between(-1, 1)), between(0, 2 * pi));
        scene.camera.orthographic = happens(0.3);
        scene.camera.width =
            scene.camera.orthographic ? between(0.2, 0.6) * distance : radians(degrees);
    }

    Scene rings() {
        Scene scene = small_rings(1);
        shine_on_one_another(scene, true);
        scene.layer.components = {phase_function(), phase_function()};
        scene.layer.albedo = {1, between(0.5, 1), between(0.3, 1)};
        Rings& rings = the_rings(scene);
        rings.surface.colour = colour();
        rings.flattening = happens(0.5) ? 0.1 : 0;
        RingProfile profile;
        const int knots = 2 + static_cast<int>(between(0, 6));
        double radius = between(1.1, 1.5);
        const double deepest = power(-1.5, 0.6), white = between(0.3, 1);
        const bool even = happens(0.4);
        for (int k = 0; k < knots; ++k) {
            profile.radius.push_back(radius);
            profile.optical_depth.push_back(deepest * between(0.1, 1));
            const double w = white * between(0.3, 1), share = even ? 0.7 : between(0, 1);
            profile.w1.push_back(w * share);
            profile.w2.push_back(w * (1 - share));
            radius += happens(0.3) ? 1e-3 : between(0.1, 0.4);
        }
        rings.profile = profile;
        look_from(scene, between(3, 12), between(10, 50));
        if (happens(0.3)) scene.background.colour = colour();
        return scene;
    }
    Scene planet() {
        Scene scene = small_planet(0, power(-1.5, 1), between(0.5, 1));
        scene.layer.components = {phase_function()};
        if (happens(0.6)) the_planet(scene).surface.colour = colour();
        if (happens(0.5)) cover_with_clouds(scene);
        return scene;
    }
    Scene slab() {
        Scene scene = small_slab(power(-1.5, 1), between(0.5, 1));
        scene.layer.components = {phase_function()};
        scene.background.colour = happens(0.6) ? colour() : Rgb{0, 0, 0};
        look_from(scene, 10, between(10, 90));
        if (happens(0.4)) {
            Slab& slab = the_slab(scene);
            slab.surface.emplace();
            slab.surface->colour = colour();
            slab.half_size = infinity;
            slab.height = 1;
            scene.camera.position.z = std::abs(scene.camera.position.z);
        }
        if (happens(0.4)) cover_with_clouds(scene);
        return scene;
    }
};

/// Tables that are `finer` times as fine as the scene asks for, along all light paths.
inline std::vector<std::shared_ptr<const LayerTables>> bake_finer(const Scene& scene, double finer,
                                                                  const BakeOptions& options = {}) {
    return make_tables({scene}, [&](Recipe recipe) {
        recipe.tolerance = scene.tolerance / finer;
        return bake_layer_table(recipe, options);
    });
}

}  // namespace stratus
