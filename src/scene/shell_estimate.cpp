// The largest change of a picture whose planet has a plane layer in place of a shell. Light along a ray
// does not bound it: beside a planet of plane air it is dark, however thin the shell, which few of a
// pixel's rays may cross. So pixels are compared, each with all its samples: those where the view or the
// sunlight grazes the planet most, at the limb, along the terminator and in the twilight, and an even
// grid of others, in the light of small tables. Where the layer or the ground vary, even ones stand for
// them, for the worst place may have any depth, over dark or bright ground.
#include <stratus/scene/contents.h>
#include <stratus/scene/plan.h>
#include <stratus/scene/render.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <variant>

namespace stratus {
namespace {

/// Margin for all that is not looked at, and for errors of small tables, by the record of
/// bench/plan_bench.cpp.
constexpr double shell_margin = 1.5;

constexpr int grid_pixels = 12;             // along each side of the picture
constexpr int grazing_pixels_per_side = 3;  // times width and height
constexpr std::size_t quick_look = 24;      // pixels of each kind
constexpr double quick_look_factor = 10;    // all light over that scattered once, at most
constexpr int depth_steps = 5;              // of a map of depths, each
constexpr double depth_step = 4;            // times as deep as the next

struct Pixel {
    int x, y;
};

/// A pixel's middle, where it is lit.
struct LitPixel {
    Pixel pixel;
    double from_limb;            // impact parameter less the planet's radius, either way
    double over_the_terminator;  // cosine to the sun, less what the pixel covers of it, or below 0
};

/// The pixels that sunlight may reach.
std::vector<LitPixel> lit_pixels(const Scene& scene) {
    const PictureRays rays(scene.camera, scene.width, scene.height);
    const double height = seen_shell(scene),
                 sun_radius = scene.effects.sun_size ? scene.sun_diameter / 2 : 0;
    const double x = 0.5 * scene.width, y = 0.5 * scene.height,
                 distance = length(scene.camera.position);
    // From a pixel's middle to the next one's, where they pass the planet.
    const double reach =
        length(rays.through(x + 1, y).at(distance) - rays.through(x, y).at(distance));
    std::vector<LitPixel> lit;
    for (int row = 0; row < scene.height; ++row)
        for (int column = 0; column < scene.width; ++column) {
            const Ray ray = rays.through(column + 0.5, row + 0.5);
            const double along = -dot(ray.origin, ray.direction);
            const Vector3 nearest = ray.at(along);
            const double impact = length(nearest);
            if (along <= 0 || impact > 1 + height + reach) continue;
            const double mu_out = std::sqrt(std::max(0.0, 1 - impact * impact));
            const double to_sun = dot(normalised(ray.at(along - mu_out)), scene.to_sun);
            // A pixel covers the more of the planet the more slanting that is.
            const double covered = reach / std::max(mu_out, std::sqrt(reach)) + sun_radius;
            if (to_sun > -covered - std::sqrt(2 * height))
                lit.push_back(
                    {{column, row}, std::abs(impact - 1), std::max(0.0, to_sun - covered)});
        }
    return lit;
}

/// The first of them by one of their numbers.
std::vector<Pixel> first_pixels(std::vector<LitPixel> lit, double LitPixel::*by, std::size_t most) {
    const std::size_t count = std::min(most, lit.size());
    std::ranges::partial_sort(lit, lit.begin() + static_cast<std::ptrdiff_t>(count), {}, by);
    std::vector<Pixel> pixels;
    for (std::size_t k = 0; k < count; ++k) pixels.push_back(lit[k].pixel);
    return pixels;
}

std::vector<Pixel> even_pixels(const Scene& scene) {
    const int across = std::min(grid_pixels, scene.width),
              down = std::min(grid_pixels, scene.height);
    std::vector<Pixel> pixels;
    for (int row = 0; row < down; ++row)
        for (int column = 0; column < across; ++column)
            pixels.push_back({(2 * column + 1) * scene.width / (2 * across),
                              (2 * row + 1) * scene.height / (2 * down)});
    return pixels;
}

/// The scene; where its layer or ground varies also even layers over even grounds that stand for these.
Scenes scene_and_even_ones(const Scene& scene) {
    const DepthMap& map = scene.layer.optical_depth;
    const Texture& texture = std::get<Planet>(scene.subject).surface;
    std::vector<DepthMap> depths{map};
    std::vector<Texture> grounds{texture};
    if (!map.is_plain()) {
        depths.assign(depth_steps, {});
        for (int k = 0; k < depth_steps; ++k)
            depths[size(k)].max = map.max / std::pow(depth_step, k);
    }
    if (texture.pattern != Texture::Pattern::plain) {
        const auto most = static_cast<float>(brightest_ground(scene));
        grounds.assign(2, {});
        grounds[1].colour = {most, most, most};
    }
    Scenes scenes{scene};
    if (depths.size() * grounds.size() == 1) return scenes;
    for (const DepthMap& depth : depths)
        for (const Texture& ground : grounds) {
            Scene& even = scenes.emplace_back(scene);
            even.layer.optical_depth = depth;
            std::get<Planet>(even.subject).surface = ground;
        }
    return scenes;
}

/// Compares pixels of a scene, whose layer is a shell, with those of the same layer as a plane.
class ShellPixels {
  public:
    ShellPixels(const Scene& scene, const LayerTables* tables)
        : shell_(scene),
          plane_(with_effects(scene, without(scene.effects, &SceneEffects::shell))),
          curved_(shell_, tables, 1, LightDetail::sketch),
          flat_(plane_, tables, 1, LightDetail::sketch) {
        for (const auto& [x, y] : even_pixels(scene))
            darkest_ = std::max(darkest_, min_reference * brightest(radiance(plane_, flat_, x, y)));
    }

    /// Raises what is found by these pixels, until it exceeds `enough`.
    void compare(std::span<const Pixel> pixels, double enough, ChangeEstimate& change) const {
        for (const auto& [x, y] : pixels) {
            if (change.found > enough) return;
            const Rgb all = radiance(shell_, curved_, x, y), some = radiance(plane_, flat_, x, y);
            const double difference = brightest(
                {std::abs(all.r - some.r), std::abs(all.g - some.g), std::abs(all.b - some.b)});
            const double reference = std::max(brightest(all), darkest_);
            if (reference == 0 || difference <= change.found * reference) continue;
            change.found = difference / reference;
            change.where = "pixel (" + std::to_string(x) + ", " + std::to_string(y) + ")";
        }
    }

  private:
    Scene shell_, plane_;
    LayerLight curved_, flat_;
    double darkest_ = 0;  // that a change is relative to
};

}  // namespace

ChangeEstimate estimate_shell(const Scene& scene, double enough) {
    const std::vector<LitPixel> lit = lit_pixels(scene);
    const std::size_t most = size(grazing_pixels_per_side * (scene.width + scene.height));
    const std::vector<Pixel> looked_at[] = {first_pixels(lit, &LitPixel::from_limb, most),
                                            first_pixels(lit, &LitPixel::over_the_terminator, most),
                                            even_pixels(scene)};
    ChangeEstimate change;
    // Light scattered once tells in no time where a shell is needed.
    std::vector<Pixel> few;
    for (const std::vector<Pixel>& pixels : looked_at)
        for (std::size_t k = 0; k < std::min(quick_look, pixels.size()); ++k)
            few.push_back(pixels[k * pixels.size() / quick_look]);
    const SceneEffects once = without(scene.effects, &SceneEffects::multiple);
    ShellPixels(with_effects(scene, once), nullptr)
        .compare(few, quick_look_factor * enough, change);
    if (change.found <= quick_look_factor * enough) {
        change = {};
        const Scenes scenes = scene_and_even_ones(scene);
        const SceneTables tables = make_tables(scenes, small_table);
        for (std::size_t k = 0; k < scenes.size(); ++k) {
            const ShellPixels pair(scenes[k], tables[k].get());
            for (const std::vector<Pixel>& pixels : looked_at) pair.compare(pixels, enough, change);
        }
    }
    change.change = shell_margin * change.found;
    return change;
}

}  // namespace stratus
