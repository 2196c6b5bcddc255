#include <stratus/scene/render.h>

#include <stratus/bake/parallel.h>

#include "ring_light.h"
#include "subjects.h"

#include <variant>

namespace stratus {
namespace {

constexpr int min_suns = 9;  // directions to the sun's disk in each pixel

Rgb3 radiance_seen(const View& view) {
    return std::visit([&](const auto& subject) { return ray_radiance(subject, view); },
                      view.scene.subject);
}

/// Suns of each sample, where samples do not have one sun each.
std::size_t suns_of_sample(const Scene& scene, std::size_t suns) {
    return std::max<std::size_t>(1, suns / size(scene.samples * scene.samples));
}

/// Rows of samples that take the place of each, a sun each, so that every wave of detail in a pixel has some
/// and every sun as many: towards horizons and limbs a pixel covers many waves, which a few samples would
/// show as speckle. The light is averaged, not the depth: mean clouds have another light.
int finer_rows(const Scene& scene, const PictureRays& rays, std::size_t suns, int x, int y) {
    constexpr double samples_per_wave = 8, most = 256;  // of a pixel
    const Cell pixel{rays, static_cast<double>(x), static_cast<double>(y), x + 1.0, y + 1.0};
    const double waves =
        std::visit([&](const auto& subject) { return waves_within(subject, scene.layer, pixel); },
                   scene.subject);
    const double finer = std::min(samples_per_wave * waves, most) / (scene.samples * scene.samples);
    const double step = static_cast<double>(suns_of_sample(scene, suns));
    return finer > 1 ? static_cast<int>(step * std::ceil(finer / step)) : 1;
}

/// Pictures of a scene, pixels [begin, end) of a row at a time.
class RowRenderer {
  public:
    RowRenderer(const Scene& scene, const LayerLight& light, bool finer = true)
        : scene_(scene),
          light_(light),
          finer_(finer),
          rays_(scene.camera, scene.width, scene.height),
          suns_(sun_directions(scene)) {}

    /// Writes red, green and blue of each pixel to `light`.
    void row(int y, int begin, int end, float* light) const {
        std::vector<Rgb3> sums(size(end - begin), Rgb3{});
        LightSum scattered(light_);
        for (int x = begin; x < end; ++x) add_samples(x, y, scattered, sums[size(x - begin)]);
        scattered.finish();
        const double share = 1.0 / std::max(scene_.samples * scene_.samples, int_size(suns_));
        for (const Rgb3& sum : sums)
            for (const double channel : sum) *light++ = static_cast<float>(share * channel);
    }

  private:
    void add_samples(int x, int y, LightSum& scattered, Rgb3& sum) const {
        const int n = scene_.samples,
                  finer = finer_ ? finer_rows(scene_, rays_, suns_.size(), x, y) : 1;
        // Where rows are finer, the layer's light is not summed by the layer.
        LightSum* const layer = light_.has_sums() && finer == 1 ? &scattered : nullptr;
        scattered.into(sum);
        const std::size_t all_suns = suns_of_sample(scene_, suns_.size()),
                          suns = finer == 1 ? all_suns : 1;
        const double share = static_cast<double>(all_suns / suns) / finer;
        for (int row = 0; row < n * finer; ++row)
            for (int column = 0; column < n; ++column) {
                // A sheared grid: no two samples share a row, column or diagonal, so that an edge along
                // one of these crosses them one by one.
                const double sheared =
                    finer == 1 ? (row + 0.5) / n : (row + 0.5) * std::numbers::phi;
                const double across = (column + sheared - std::floor(sheared)) / n,
                             down = (row + (n - column - 0.5) / n) / (n * finer);
                const Ray ray = rays_.through(x + across, y + down);
                const double cell = 1.0 / n, left = x + column * cell, top = y + row / finer * cell;
                const Cell around{rays_, left, top, left + cell, top + cell};
                std::size_t sun = size(row * n + column);
                for (std::size_t s = 0; s < suns; ++s, sun += size(n * n))
                    sum += share * radiance_seen({scene_, light_, ray, suns_[sun % suns_.size()],
                                                  &around, layer});
            }
    }

    const Scene& scene_;
    const LayerLight& light_;
    const bool finer_;
    PictureRays rays_;
    std::vector<Vector3> suns_;
};

}  // namespace

Rgb3 background_along(const Scene& scene, const Vector3& direction) {
    const bool plain = scene.background.pattern == Texture::Pattern::plain;
    return widened(plain ? scene.background.colour : scene.background.at(sphere_point(direction)));
}

bool is_sun_along(const Scene& scene, const Vector3& direction) {
    return scene.sun_visible &&
           length(direction - scene.to_sun) <= 2 * std::sin(scene.sun_diameter / 4);
}

Rgb3 sun_along(const Scene& scene, const Vector3& direction) {
    if (!is_sun_along(scene, direction)) return {};
    const double quarter = std::sin(scene.sun_diameter / 4);  // the solid angle is 4 pi its square
    return 1 / (4 * quarter * quarter) * scene.sun_colour;
}

std::vector<Vector3> sun_directions(const Scene& scene) {
    if (scene.sun_diameter == 0 || !scene.effects.sun_size) return {scene.to_sun};
    const int samples = scene.samples * scene.samples;
    const int count = (min_suns + samples - 1) / samples * samples;
    const bool upright = std::abs(scene.to_sun.z) > 0.9;
    const Vector3 across =
        normalised(cross(scene.to_sun, upright ? Vector3{1, 0, 0} : Vector3{0, 0, 1}));
    const Vector3 along = cross(scene.to_sun, across);
    // Opposite pairs along Vogel's spiral, whose mean is the centre, in even steps of the solid angle within it:
    // 4 pi times sin^2(angle / 2). An odd number begins with the centre. The first pair is turned so that a level
    // horizon through the disk meets those of 9 to 256 best.
    const double golden_section = pi * (std::numbers::phi - 1), turned = 2.33;  // of half a turn
    const bool odd = count % 2 == 1;
    std::vector<Vector3> directions;
    for (int k = 0; k < count; ++k) {
        const int pair = (k + (odd ? 1 : 2)) / 2;
        const double share = odd ? 2.0 * pair * count / (count * count - 1.0)
                                 : (2.0 * pair - 1) / count,
                     angle = 2 * std::asin(std::sin(scene.sun_diameter / 4) * std::sqrt(share)),
                     around = turned + pair * golden_section + k % 2 * pi;
        const Vector3 sideways = std::cos(around) * across + std::sin(around) * along;
        directions.push_back(
            normalised(std::cos(angle) * scene.to_sun + std::sin(angle) * sideways));
    }
    return directions;
}

Rgb3 radiance_along(const Scene& scene, const LayerLight& light, const Ray& ray,
                    const Vector3& to_sun) {
    return radiance_seen({scene, light, ray, to_sun});
}

Rgb radiance(const Scene& scene, const LayerLight& light, int x, int y) {
    float pixel[3];
    RowRenderer(scene, light).row(y, x, x + 1, pixel);
    return {pixel[0], pixel[1], pixel[2]};
}

double sample_count(const Scene& scene, int row_step) {
    const PictureRays rays(scene.camera, scene.width, scene.height);
    const std::size_t suns = sun_directions(scene).size();
    double samples = 0;
    for (int y = row_step / 2; y < scene.height; y += row_step)
        for (int x = 0; x < scene.width; ++x) {
            const int finer = finer_rows(scene, rays, suns, x, y);
            samples += finer > 1 ? finer : static_cast<double>(suns_of_sample(scene, suns));
        }
    return samples * scene.samples * scene.samples;
}

Image render(const Scene& scene, const LayerLight& light, const RenderOptions& options) {
    Image image(scene.width, scene.height);
    const RowRenderer rows(scene, light, options.finer);
    constexpr int tile = 8;  // rows
    const int tiles = (scene.height + tile - 1) / tile;
    parallel_for(
        tiles, options.threads,
        [&](int t) {
            for (int y = t * tile; y < std::min((t + 1) * tile, scene.height); ++y)
                if (y % options.row_step == options.row_step / 2)
                    rows.row(y, 0, scene.width, image.pixel(0, y));
        },
        [&](int done) {
            if (options.progress) options.progress(static_cast<double>(done) / tiles, "rendering");
        });
    return image;
}

Image render(const Film& film, int frame, const SceneTables& tables, const RenderOptions& options) {
    const SceneFile& file = film[size(frame)];
    const std::size_t first = size(frame) * file.panels.size();
    const double panels = static_cast<double>(file.panels.size());
    std::vector<Image> pictures;
    for (std::size_t k = 0; k < file.panels.size(); ++k) {
        const LayerLight light(file.panels[k], tables[first + k].get(), options.threads);
        RenderOptions own = options;
        own.progress = [&](double done, const std::string& stage) {
            if (options.progress) options.progress((static_cast<double>(k) + done) / panels, stage);
        };
        pictures.push_back(render(file.panels[k], light, own));
    }
    return side_by_side(pictures, file.columns);
}

Image side_by_side(const std::vector<Image>& pictures, int columns) {
    const int count = int_size(pictures);
    const int across = std::min(columns, count), rows = (count + across - 1) / across;
    const int width = pictures[0].width, height = pictures[0].height;
    Image all(across * width, rows * height);
    for (int k = 0; k < count; ++k)
        for (int y = 0; y < height; ++y)
            std::copy_n(pictures[size(k)].pixel(0, y), 3 * width,
                        all.pixel(k % across * width, k / across * height + y));
    return all;
}

}  // namespace stratus
