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
constexpr std::size_t quick_look = 48;      // pixels
constexpr double quick_look_factor = 10;    // all light over that scattered once, at most
constexpr int depth_steps = 5;              // of a map of depths, each
constexpr double depth_step = 4;            // times as deep as the next

struct Pixel {
    int x, y;
};

/// How much the shell is likely to change in a pixel, and which it is.
struct RankedPixel {
    double rank;
    Pixel pixel;
};

/// Ranks a pixel by its ray through the middle, with what its other rays may graze; 0: no light.
class GrazingRank {
  public:
    GrazingRank(const Scene& scene, const PictureRays& rays)
        : scene_(scene),
          rays_(rays),
          height_(seen_shell(scene)),
          sun_radius_(scene.effects.sun_size ? scene.sun_diameter / 2 : 0) {
        const double x = 0.5 * scene.width, y = 0.5 * scene.height;
        const double distance = length(scene.camera.position);
        reach_ = length(rays.through(x + 1, y).at(distance) - rays.through(x, y).at(distance));
    }

    double operator()(const Pixel& pixel) const noexcept {
        const Ray ray = rays_.through(pixel.x + 0.5, pixel.y + 0.5);
        const double along = -dot(ray.origin, ray.direction);
        const Vector3 nearest = ray.at(along);
        const double squared_impact = dot(nearest, nearest), beyond = 1 + height_ + reach_;
        if (along <= 0 || squared_impact > beyond * beyond) return 0;
        const double mu_out = std::sqrt(std::max(0.0, 1 - squared_impact));
        const double sun = dot(normalised(ray.at(along - mu_out)), scene_.to_sun);
        // The planet's face that a pixel covers is the longer the more slanting it is.
        const double covered = reach_ / std::max(mu_out, std::sqrt(reach_)) + sun_radius_;
        if (sun < -covered - std::sqrt(2 * height_)) return 0;
        const double grazing_sun = std::max(0.0, sun - covered),
                     squared_view = std::max(0.0, 1 - squared_impact - 2 * reach_);
        return 1 / (squared_view + height_) + 1 / (grazing_sun * grazing_sun + height_);
    }

  private:
    const Scene& scene_;
    const PictureRays& rays_;
    double height_, sun_radius_;
    double reach_;  // from a pixel's middle to the next one's, where they pass the planet
};

/// The pixels that are grazed most, worst first.
std::vector<Pixel> grazing_pixels(const Scene& scene, std::size_t most) {
    const PictureRays rays(scene.camera, scene.width, scene.height);
    const GrazingRank rank(scene, rays);
    std::vector<RankedPixel> ranked;
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x)
            if (const double own = rank({x, y}); own > 0) ranked.push_back({own, {x, y}});
    const std::size_t count = std::min(most, ranked.size());
    std::ranges::partial_sort(ranked, ranked.begin() + static_cast<std::ptrdiff_t>(count),
                              std::greater<>(), &RankedPixel::rank);
    std::vector<Pixel> pixels;
    for (std::size_t k = 0; k < count; ++k) pixels.push_back(ranked[k].pixel);
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

/// The scene, or even ones that stand for its layer and ground where these vary.
std::vector<Scene> even_scenes(const Scene& scene) {
    std::vector<Scene> scenes{scene};
    const DepthMap depth = scene.layer.optical_depth;
    if (!depth.is_plain()) {
        scenes.assign(depth_steps, scene);
        for (int k = 0; k < depth_steps; ++k) {
            DepthMap& even = scenes[static_cast<std::size_t>(k)].layer.optical_depth = {};
            even.max = depth.max / std::pow(depth_step, k);
        }
    }
    if (std::get<Planet>(scene.subject).surface.pattern == Texture::Pattern::plain) return scenes;
    const auto brightest = static_cast<float>(brightest_ground(scene));
    for (std::size_t k = scenes.size(); k-- > 0;) {
        for (const float ground : {0.0f, brightest}) {
            Scene even = scenes[k];
            Texture& surface = std::get<Planet>(even.subject).surface = {};
            surface.colour = {ground, ground, ground};
            scenes.push_back(std::move(even));
        }
        scenes.erase(scenes.begin() + static_cast<std::ptrdiff_t>(k));
    }
    return scenes;
}

double brightest_channel(const Rgb& light) { return double{std::max({light.r, light.g, light.b})}; }

/// Compares pixels of a scene, whose layer is a shell, with those of the same layer as a plane.
class ShellPixels {
  public:
    ShellPixels(const Scene& scene, const LayerTables* tables)
        : shell_(scene),
          plane_(with_effects(scene, without(scene.effects, &SceneEffects::shell))),
          curved_(shell_, tables, 1, LightDetail::sketch),
          flat_(plane_, tables, 1, LightDetail::sketch) {
        for (const auto& [x, y] : even_pixels(scene))
            darkest_ = std::max(darkest_,
                                min_reference * brightest_channel(radiance(plane_, flat_, x, y)));
    }

    /// Raises what is found by these pixels, until it exceeds `enough`.
    void compare(std::span<const Pixel> pixels, double enough, ChangeEstimate& change) const {
        for (const auto& [x, y] : pixels) {
            if (change.found > enough) return;
            const Rgb all = radiance(shell_, curved_, x, y), some = radiance(plane_, flat_, x, y);
            const double difference = brightest_channel(
                {std::abs(all.r - some.r), std::abs(all.g - some.g), std::abs(all.b - some.b)});
            const double reference = std::max(brightest_channel(all), darkest_);
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
    const std::vector<Scene> scenes = even_scenes(scene);
    const std::vector<Pixel> grazing = grazing_pixels(
        scene, static_cast<std::size_t>(grazing_pixels_per_side * (scene.width + scene.height)));
    const std::vector<Pixel> even = even_pixels(scene);
    ChangeEstimate change;
    // Light scattered once tells in no time where a shell is needed.
    std::vector<Pixel> few;
    for (std::size_t k = 0; k < std::min(quick_look, grazing.size()); ++k)
        few.push_back(grazing[k * grazing.size() / quick_look]);
    const Scene once = with_effects(scenes[0], without(scene.effects, &SceneEffects::multiple));
    ShellPixels(once, nullptr).compare(few, quick_look_factor * enough, change);
    if (change.found > quick_look_factor * enough) {
        change.change = std::min(1.0, shell_margin * change.found);
        return change;
    }
    change = {};
    const SceneTables tables = make_tables(scenes, small_table);
    for (std::size_t k = 0; k < scenes.size(); ++k) {
        const ShellPixels pixels(scenes[k], tables[k].get());
        pixels.compare(grazing, enough, change);
        pixels.compare(even, enough, change);
    }
    change.change = shell_margin * change.found;
    return change;
}

}  // namespace stratus
