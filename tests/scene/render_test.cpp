// Pictures pixel by pixel, against closed forms; occlusion and shadows.
#include <stratus/scene/render.h>

#include <stratus/base/constants.h>

#include "indices.h"
#include "small_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

namespace stratus {
namespace {

Rgb3 along(const Scene& scene, const Vector3& origin, const Vector3& towards) {
    const LayerLight light(scene, nullptr);
    return radiance_along(scene, light, {origin, normalised(towards - origin)}, scene.to_sun);
}

TEST(RenderedPlanet, FollowsLambertsLaw) {
    Scene scene = small_planet(50, 0, 1);
    the_planet(scene).surface.colour = {0.5f, 0.25f, 0.75f};
    const Vector3 normal = normalised({0.8, 0.5, -0.2});
    const Rgb3 light = along(scene, {5, normal.y, normal.z}, {0, normal.y, normal.z});
    EXPECT_NEAR(light[0], 0.5 * dot(normal, scene.to_sun), 1e-7);  // single precision of the colour
    EXPECT_NEAR(light[1], 0.25 * dot(normal, scene.to_sun), 1e-7);
}

TEST(RenderedPlanet, SingleScatteringIsTheClosedForm) {
    const Scene scene = once(small_planet(70, 0.8, 0.6));
    const Vector3 normal = normalised({0.8, 0.5, -0.2}), to_eye{1, 0, 0};
    const double mu_in = dot(normal, scene.to_sun), mu_out = dot(normal, to_eye);
    const double phase = scene.layer.components[0](-dot(scene.to_sun, to_eye));
    const Rgb3 light = along(scene, {5, normal.y, normal.z}, {0, normal.y, normal.z});
    EXPECT_NEAR(light[0] / (mu_in * single_reflection(phase, 0.6, 0.8, mu_in, mu_out)), 1, 1e-5)
        << "slices are of single precision";
}

TEST(RenderedPlanet, IsDarkBeyondTheTerminatorAndShowsBackgroundBesideIt) {
    Scene scene = once(small_planet(90, infinity, 0.6));
    scene.background.colour = {0.125f, 0.25f, 0.5f};
    EXPECT_EQ(along(scene, {5, -0.01, 0.3}, {0, -0.01, 0.3})[0], 0);
    EXPECT_GT(along(scene, {5, 0.01, 0.3}, {0, 0.01, 0.3})[0], 0);
    EXPECT_EQ(along(scene, {5, 0, 1.001}, {0, 0, 1.001})[1], 0.25);
}

// [Blinn82] 2.7: w phi / 2 in his units, which are four times these.
TEST(FullMoon, SingleScatteringIsUniformOverTheDisk) {
    Scene scene = once(small_planet(0, infinity, 0.4));
    scene.width = scene.height = 64;
    const LayerLight light(scene, nullptr);
    const Image image = render(scene, light);
    const double expected = 0.4 * 1.5 / 8;  // Rayleigh's phi is 1.5 straight back
    int on_disk = 0;
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            if (std::hypot(x - 31.5, y - 31.5) > 31.9) continue;
            ++on_disk;
            ASSERT_NEAR(image.pixel(x, y)[1] / expected, 1, 2e-4)  // 1e-5 but at the very edge
                << x << ' ' << y;
        }
    EXPECT_GT(on_disk, 3000);
}

TEST(RenderedSlab, AttenuatesTheBackground) {
    Scene scene = once(small_slab(0.7, 0.5));
    scene.effects.single = false;
    const Vector3 eye = scene.camera.position;
    const double transmitted = std::exp(-0.7 / 0.5);  // 60 degrees from the normal
    EXPECT_NEAR(along(scene, eye, {0, 0, 0})[0], 0.25 * transmitted, 1e-12);
    EXPECT_NEAR(along(scene, eye, {0, 0, 0})[2], transmitted, 1e-12);
    scene.effects.background = false;
    EXPECT_EQ(along(scene, eye, {0, 0, 0})[2], 0);
}

TEST(RenderedSlab, ShowsItsBackgroundByTheBeamAndWhatIsScatteredTowardsTheEye) {
    Scene scene = once(small_slab(0.7, 0.5));
    const Vector3 eye = scene.camera.position;
    const Rgb3 light = along(scene, eye, {0, 0, 0});
    const Slice slice(scene.layer.components[0], {{0.7}, {0.5}});
    const double share = double{slice.background(0.5f)};
    EXPECT_GT(share, std::exp(-0.7 / 0.5) + 0.05);
    EXPECT_NEAR(light[2] - light[0], 0.75 * share, 2e-4);
}

TEST(RenderedSlab, OfDepthZeroShowsTheBackground) {
    const Scene scene = small_slab(0, 1);
    const Rgb3 light = along(scene, scene.camera.position, {0, 0, 0});
    EXPECT_EQ(light[0], 0.25);
    EXPECT_EQ(light[1], 0.5);
    EXPECT_EQ(light[2], 1.0);
}

TEST(RenderedSlab, OfInfiniteDepthHidesTheBackground) {
    Scene scene = once(small_slab(infinity, 0.5));
    const Vector3 eye = scene.camera.position;
    const Rgb3 before = along(scene, eye, {0, 0, 0});
    EXPECT_GT(before[0], 0);
    scene.background.colour = {9, 9, 9};
    EXPECT_EQ(along(scene, eye, {0, 0, 0}), before);
}

TEST(RenderedSlab, TransmitsLightFromTheOtherSide) {
    Scene scene = once(small_slab(0.7, 0.5));
    scene.background.colour = {0, 0, 0};
    scene.to_sun = -scene.to_sun;
    const double mu_in = std::cos(radians(30)), mu_out = 0.5;
    const double phase =
        scene.layer.components[0](-dot(scene.to_sun, normalised(scene.camera.position)));
    const double expected = mu_in * single_transmission(phase, 0.5, 0.7, mu_in, mu_out);
    EXPECT_NEAR(along(scene, scene.camera.position, {0, 0, 0})[0] / expected, 1, 1e-5);
    scene.effects.transmission = false;
    EXPECT_EQ(along(scene, scene.camera.position, {0, 0, 0})[0], 0);
}

TEST(RenderedSlab, CastsAShadowOnTheGround) {
    Scene scene = once(small_slab(2, 0.5));
    scene.effects.single = false;
    Slab& slab = the_slab(scene);
    slab.surface = Texture{};
    slab.surface->colour = {1, 1, 1};
    slab.half_size = 1;
    slab.height = 3;
    // The sun stands 30 degrees from the normal towards -x: the shadow's centre lies 3 tan 30
    // beyond the slab's, the edge one further on.
    const double shift = 3 * std::tan(radians(30)), mu = std::cos(radians(30));
    const auto ground = [&](double x) { return along(scene, {x, 50, 47}, {x, 0, -3})[0]; };
    EXPECT_NEAR(ground(shift + 0.99), mu * std::exp(-2 / mu), 1e-12);
    EXPECT_NEAR(ground(shift - 0.99), mu * std::exp(-2 / mu), 1e-12);
    EXPECT_NEAR(ground(shift + 1.01), mu, 1e-12);
    EXPECT_NEAR(ground(shift - 1.01), mu, 1e-12);
}

// The mirror through the beams, and Lambert's law of the water, which the beam alone lights.
TEST(RenderedSlab, ShowsTheSunInAnOcean) {
    const Scene scene = parse_scene(R"(
[camera]
position = [0.5773502691896258, 0, 1]
look_at = [0, 0, 0]
field_of_view_deg = 10
[sun]
direction = [-0.5773502691896258, 0, 1]
[layer]
phase_function = "isotropic"
albedo = 0
optical_depth = 0.3
[slab]
surface = { wind = 1, colour = 0.02 }
)")
                            .panels[0];
    const double mu = std::cos(radians(30));
    const auto mirror = read_ground_law("ocean:wind=1");
    const double glint = mu * std::exp(-2 * 0.3 / mu) * ((*mirror)({mu, mu, 0}) + 0.02);
    EXPECT_GT(glint, 0.3);
    const Vector3 eye = scene.camera.position;
    EXPECT_NEAR(along(once(scene), eye, {0, 0, 0})[1], glint, 1e-6 * glint);
    const double beside =
        1 / length(eye - Vector3{0, 3, 0});  // the cosine where nothing is mirrored
    const double water = mu * std::exp(-0.3 / mu - 0.3 / beside) * 0.02;
    EXPECT_NEAR(along(once(scene), eye, {0, 3, 0})[1], water, 1e-6 * water);
}

/// Flux over pi of what is seen along all directions up (or down) from `eye`.
Rgb3 flux_from(const Scene& scene, const LayerLight& light, const Vector3& eye, double sign) {
    constexpr int cosines = 40, azimuths = 40;
    Rgb3 flux{};
    for (int i = 0; i < cosines; ++i)
        for (int k = 0; k < azimuths; ++k) {
            // Uniform in mu^2 with weight mu d mu = d(mu^2) / 2, squeezed towards grazing angles.
            const double share = (i + 0.5) / cosines, mu = share * share;
            const Vector3 direction =
                direction_at(std::asin(sign * mu), 2 * pi * (k + 0.5) / azimuths);
            flux = flux + 4.0 * mu * share / (cosines * azimuths) *
                              radiance_along(scene, light, {eye, direction}, scene.to_sun);
        }
    return flux;
}

TEST(RenderedSlab, BalancesTheLightBetweenLayerAndGround) {
    Scene scene = small_slab(2, 0.9);
    scene.background.colour = {0, 0, 0};
    scene.sun_colour = {1, 0.5, 2};
    scene.tolerance = 2e-3;
    Slab& slab = the_slab(scene);
    slab.half_size = infinity;
    slab.height = 3;
    slab.surface = Texture{};
    slab.surface->colour = {1, 0.5f, 0.25f};
    const double ground[] = {1, 0.5, 0.25};
    const double mu_in = scene.to_sun.z, beam = mu_in * std::exp(-2 / mu_in);
    for (const double albedo : {0.9, 1.0}) {
        scene.layer.albedo = {albedo, albedo, albedo};
        const BakedLight light = light_of_all_directions(scene);
        const Rgb3 down = flux_from(scene, light, {0, 0, -1.5}, 1),
                   up = flux_from(scene, light, {0, 0, -1.5}, -1),
                   above = flux_from(scene, light, {0, 0, 1}, -1);
        for (const auto c : three_channels) {
            const double colour = scene.sun_colour[c];
            EXPECT_NEAR(ground[c] * (down[c] + colour * beam) / up[c], 1, 3e-3)
                << "the ground reflects what falls on it; albedo " << albedo << ", channel " << c;
            if (albedo < 1) continue;
            const double absorbed = (1 / ground[c] - 1) * up[c];
            EXPECT_NEAR((above[c] + absorbed) / (colour * mu_in), 1, 3e-3)
                << "what is not absorbed by the ground leaves; channel " << c;
        }
    }
}

TEST(RenderedSlab, ShowsTheSkyFromBeneathAndTheGroundUnveiled) {
    Scene scene = once(small_slab(0.7, 0.5));
    scene.effects.single = false;
    Slab& slab = the_slab(scene);
    slab.height = 2;
    slab.surface = Texture{};
    slab.surface->colour = {0.5f, 0.5f, 0.5f};
    const Vector3 eye{0, 0, -1};
    const double mu_in = scene.to_sun.z;
    EXPECT_NEAR(along(scene, eye, {std::sqrt(3), 0, 0})[2], std::exp(-0.7 / 0.5), 1e-12);
    EXPECT_NEAR(along(scene, eye, {1, 0, -2})[2], 0.5 * mu_in * std::exp(-0.7 / mu_in), 1e-12);
}

TEST(Sun, IsSeenThroughTheLayer) {
    Scene scene = once(small_slab(2, 0.5));
    scene.effects.single = false;
    scene.background.colour = {0, 0, 0};
    scene.layer.extinction = {0.25, 0.5, 1};
    scene.sun_colour = {1, 0.5, 0.25};
    scene.sun_diameter = radians(2);
    const Vector3 eye{0, 0, -1};
    const double mu = scene.to_sun.z;
    EXPECT_EQ(along(scene, eye, eye + scene.to_sun)[0], 0);
    scene.sun_visible = true;
    const auto at = [&](double degrees) {
        const Vector3 beside = normalised(cross(scene.to_sun, {0, 1, 0}));
        return along(
            scene, eye,
            eye + std::cos(radians(degrees)) * scene.to_sun + std::sin(radians(degrees)) * beside);
    };
    EXPECT_EQ(at(1.001)[0], 0);
    EXPECT_GT(at(0.999)[0], 0);
    // The disk's light on a surface that faces it is the sun's.
    const double solid_angle = 2 * pi * (1 - std::cos(radians(1)));
    const Rgb3 disk = at(0);
    for (const auto c : three_channels)
        EXPECT_NEAR(disk[c] * solid_angle / pi,
                    scene.sun_colour[c] * std::exp(-2 * scene.layer.extinction[c] / mu), 1e-9)
            << c;
}

TEST(RenderedRings, AreDarkInThePlanetsShadow) {
    Scene scene = once(small_rings(1));
    scene.to_sun = direction_at(radians(30), 0);
    // Behind the planet, away from the sun, its shadow ends on the ring plane at 1 / sin 30 = 2.
    const auto ring = [&](double x) { return along(scene, {x, 0, 9}, {x, 0, 0})[0]; };
    EXPECT_EQ(ring(-1.99), 0);
    EXPECT_GT(ring(-2.01), 0);
    EXPECT_GT(ring(1.8), 0);
    scene.effects.shadows = false;
    EXPECT_GT(ring(-1.99), 0);
}

TEST(RenderedRings, CastAShadowOnThePlanet) {
    Scene scene = once(small_rings(1.5));
    // Seen from straight above, no ring is in front of the planet; under a sun at 30 degrees the
    // ring where the ray to the sun crosses z = 0 casts a shadow on the point.
    const Vector3 point = normalised({std::cos(radians(20)), 0, -std::sin(radians(20))});
    scene.to_sun = direction_at(radians(30), 0);
    const double crossing = point.x - point.z / std::tan(radians(30));
    ASSERT_GT(crossing, 1.5);
    ASSERT_LT(crossing, 2.5);
    const double lit = 0.5 * dot(point, scene.to_sun);
    const Vector3 eye = point + Vector3{1, 0, -2};  // below the rings
    EXPECT_NEAR(along(scene, eye, point)[0], lit * std::exp(-1.5 / 0.5), 1e-7);
    scene.effects.shadows = false;
    EXPECT_NEAR(along(scene, eye, point)[0], lit, 1e-7);
}

TEST(RenderedRings, AttenuateThePlanetBehindThem) {
    Scene scene = once(small_rings(1));
    scene.effects.single = false;
    const Vector3 eye{4, 0, -0.6}, point = normalised({1, 0, 0.2});
    // The ray meets the ring plane at 1.7 of its radii, the planet behind it.
    const double mu = std::abs(normalised(point - eye).z);
    const double planet = 0.5 * dot(point, scene.to_sun);
    EXPECT_NEAR(along(scene, eye, point)[0], planet * std::exp(-1 / mu), 1e-7);
    scene.effects.background = false;
    EXPECT_EQ(along(scene, eye, point)[0], 0);
}

TEST(RenderedRings, AreHiddenBehindThePlanet) {
    const Scene scene = once(small_rings(1));
    const Vector3 point = normalised({1, 0, 0.2});
    // The ray would go on to meet the ring at x = -2.
    const Vector3 behind{-2, 0, 0};
    const Vector3 eye = point + normalised(point - behind);
    EXPECT_NEAR(along(scene, eye, point)[0], 0.5 * dot(point, scene.to_sun), 1e-7);
}

TEST(RenderedRings, ReflectOnTheLitSideAndTransmitOnTheOther) {
    const Scene scene = once(small_rings(1));
    const Vector3 point{0, 2, 0}, offset{0.5, 0.3, 2};
    const double mu_in = 0.5, mu_out = std::abs(normalised(offset).z);
    for (const bool lit : {true, false}) {
        const Vector3 eye = point + (lit ? offset : Vector3{offset.x, offset.y, -offset.z});
        const double cosine = -dot(scene.to_sun, normalised(eye - point));
        const double phase = 0.4 / 0.6 * scene.layer.components[0](cosine) +
                             0.2 / 0.6 * scene.layer.components[1](cosine);
        const double expected = lit ? single_reflection(phase, 0.6, 1, mu_in, mu_out)
                                    : single_transmission(phase, 0.6, 1, mu_in, mu_out);
        EXPECT_NEAR(along(scene, eye, point)[0] / (mu_in * expected), 1, 1e-12) << lit;
    }
}

TEST(RenderedRings, SurroundAFlattenedPlanet) {
    Scene scene = once(small_rings(1));
    the_rings(scene).flattening = 0.5;
    EXPECT_EQ(along(scene, {0, 9, 0.51}, {0, 0, 0.51})[0], 0) << "above the pole";
    EXPECT_NEAR(along(scene, {0, 0, 9}, {0, 0, 0})[0], 0.5 * 0.5, 1e-7) << "upright on the pole";
    // A point of the ellipse x^2 + 4 z^2 = 1, whose normal is along (x, 4 z).
    const Vector3 point{0.6, 0, 0.4}, normal = normalised({0.6, 0, 1.6});
    EXPECT_NEAR(along(scene, point + Vector3{0, 0, 5}, point)[0], 0.5 * dot(normal, scene.to_sun),
                1e-7);
}

TEST(Render, IsIndependentOfThreadsAndOfOtherPixels) {
    Scene scene = once(small_rings(1));
    scene.samples = 2;
    scene.sun_diameter = 0.05;
    scene.height = 21;
    const LayerLight light(scene, nullptr);
    RenderOptions options;
    options.threads = 1;
    const Image image = render(scene, light, options);
    for (const int threads : {2, 7}) {
        options.threads = threads;
        EXPECT_EQ(render(scene, light, options).rgb, image.rgb);
    }
    for (int y = 0; y < image.height; y += 3)
        for (int x = 0; x < image.width; ++x) {
            const Rgb pixel = radiance(scene, light, x, y);
            EXPECT_EQ(pixel.r, image.pixel(x, y)[0]);
            EXPECT_EQ(pixel.b, image.pixel(x, y)[2]);
        }
}

TEST(Render, SumsWhatItsRaysSeeOneByOne) {
    // Light of uniform layers is looked up for many pixels together, but not along one ray.
    for (Scene scene : {once(small_planet(40, 0.8, 0.6)), once(small_slab(0.7, 0.5)),
                        once(small_slab(infinity, 0.9))})
        for (const bool coloured : {false, true}) {
            if (coloured) scene.layer.albedo = {0.3, 0.6, 0.9};
            scene.width = 70;  // more than are looked up at once
            scene.height = 2;
            const LayerLight light(scene, nullptr);
            const Image image = render(scene, light);
            const PictureRays rays(scene.camera, scene.width, scene.height);
            for (int y = 0; y < scene.height; ++y)
                for (int x = 0; x < scene.width; ++x) {
                    const Rgb3 along =
                        radiance_along(scene, light, rays.through(x + 0.5, y + 0.5), scene.to_sun);
                    for (const auto c : three_channels)
                        ASSERT_NEAR(image.pixel(x, y)[c], along[c], 1e-5 * along[c])
                            << x << ' ' << y << ' ' << c;
                }
        }
}

TEST(Render, AntialiasesEdges) {
    Scene scene = small_planet(0, 0, 1);
    the_planet(scene).surface.colour = {1, 1, 1};
    scene.background.colour = {0, 0, 0};
    scene.samples = 8;
    scene.to_sun = {1, 0, 0};
    scene.camera.width = 2;
    const LayerLight light(scene, nullptr);
    const Image image = render(scene, light);
    double sum = 0;
    for (const float value : image.rgb) sum += double{value};
    // The mean cosine over the disk is 2/3, the disk pi of the picture's 4.
    EXPECT_NEAR(sum / static_cast<double>(image.rgb.size()), 2.0 / 3 * pi / 4, 1e-3);
}

/// Pixels of part of a row, as they are and by 32 x 32 samples each.
struct SampledRow {
    std::vector<double> light, reference;

    double mean_error() const { return std::abs(sum(light) / sum(reference) - 1); }
    /// Root mean square over the mean light.
    double error() const {
        double squares = 0;
        for (const auto k : indices(light)) squares += std::pow(light[k] - reference[k], 2);
        return std::sqrt(squares * static_cast<double>(light.size())) / sum(reference);
    }
    static double sum(const std::vector<double>& numbers) {
        return std::accumulate(numbers.begin(), numbers.end(), 0.0);
    }
};

SampledRow sampled_row(const Scene& scene, int y) {
    Scene twice = scene;  // in width and height, of 16 x 16 samples
    twice.width *= 2;
    twice.height *= 2;
    twice.samples = 16;
    const LayerLight light(scene, nullptr), finer(twice, nullptr);
    SampledRow row;
    for (int x = 0; x < scene.width; ++x) {
        row.light.push_back(radiance(scene, light, x, y).g);
        double sum = 0;
        for (const int dx : {0, 1})
            for (const int dy : {0, 1}) sum += radiance(twice, finer, 2 * x + dx, 2 * y + dy).g;
        row.reference.push_back(sum / 4);
    }
    return row;
}

Texture squares(float brightest, double scale) {
    Texture texture;
    texture.pattern = Texture::Pattern::squares;
    texture.other = {brightest, brightest, brightest};
    texture.scale = scale;
    return texture;
}

TEST(Render, ShowsCloudsAtTheHorizonWithoutSpeckle) {
    Scene scene = once(small_slab(4, 0.99));
    scene.samples = 2;
    scene.width = 128;
    scene.height = 64;
    scene.camera.orthographic = false;
    scene.camera.position = {0, -9, 3};
    scene.camera.look_at = {0, 0, 3};  // the horizon is below row 31
    cover_with_clouds(scene);
    Slab& slab = the_slab(scene);
    slab.half_size = infinity;
    slab.height = 0.25;
    slab.surface = squares(0.3f, 1);
    for (const int under : {1, 2, 3, 6}) {  // a few samples: 24 % for a pixel, up to 3 % for a row
        const SampledRow row = sampled_row(scene, 31 + under);
        EXPECT_LT(row.mean_error(), 0.01) << under;
        EXPECT_LT(row.error(), 0.06) << under << ": 32 x 32 samples themselves err by some 2 %";
    }
}

TEST(Render, ShowsDetailAtThePlanetsLimbWithoutSpeckle) {
    Scene scene = once(small_planet(30, 0, 1));
    scene.samples = 2;
    the_planet(scene).surface = squares(1, 64);
    const SampledRow row = sampled_row(scene, 8);
    EXPECT_LT(row.error(), 0.07) << "four samples: 19 %";
}

TEST(Sun, IsADiskOfDirections) {
    Scene scene = small_planet(30, 1, 1);
    EXPECT_EQ(sun_directions(scene).size(), 1u);
    scene.sun_diameter = 0.2;
    for (const int samples : {1, 2, 3, 4}) {
        scene.samples = samples;
        const auto suns = sun_directions(scene);
        EXPECT_GE(suns.size(), 9u);
        EXPECT_EQ(suns.size() % static_cast<std::size_t>(samples * samples), 0u);
        Vector3 mean{0, 0, 0};
        for (const Vector3& sun : suns) {
            EXPECT_LE(std::acos(dot(sun, scene.to_sun)), 0.1);
            mean = mean + (1 / static_cast<double>(suns.size())) * sun;
        }
        const Vector3 aside = mean - dot(mean, scene.to_sun) * scene.to_sun;
        EXPECT_NEAR(length(aside), 0, 1e-12);
    }
    scene.effects.sun_size = false;
    EXPECT_EQ(sun_directions(scene).size(), 1u);
}

// A disk that is equally bright in all directions to it: their cosines to its centre have equal steps.
TEST(Sun, IsEquallyBrightFromCentreToRim) {
    Scene scene = small_planet(30, 1, 1);
    scene.sun_diameter = pi / 3;
    double mean = 0, lowest = 1;
    const auto suns = sun_directions(scene);
    for (const Vector3& sun : suns) {
        const double cosine = dot(sun, scene.to_sun);
        EXPECT_NEAR(length(sun), 1, 1e-12);
        mean += cosine / static_cast<double>(suns.size());
        lowest = std::min(lowest, cosine);
    }
    EXPECT_NEAR(mean, (1 + std::cos(pi / 6)) / 2, 1e-12);
    EXPECT_GT(lowest, std::cos(pi / 6));
}

TEST(Sun, BlursTheTerminator) {
    Scene scene = small_planet(90, 0, 1);
    the_planet(scene).surface.colour = {1, 1, 1};
    scene.sun_diameter = 0.4;
    const LayerLight light(scene, nullptr);
    const Image image = render(scene, light);
    EXPECT_GT(image.pixel(7, 8)[0], 0) << "the far side of the terminator";
    EXPECT_EQ(image.pixel(2, 8)[0], 0);
}

TEST(SideBySide, ArrangesPicturesInRows) {
    std::vector<Image> pictures(3, Image(2, 1));
    for (int k = 0; k < 3; ++k)
        pictures[static_cast<std::size_t>(k)].pixel(1, 0)[0] = static_cast<float>(k + 1);
    const Image all = side_by_side(pictures, 2);
    EXPECT_EQ(all.width, 4);
    EXPECT_EQ(all.height, 2);
    EXPECT_EQ(all.pixel(1, 0)[0], 1);
    EXPECT_EQ(all.pixel(3, 0)[0], 2);
    EXPECT_EQ(all.pixel(1, 1)[0], 3);
    EXPECT_EQ(all.pixel(3, 1)[0], 0);
}

}  // namespace
}  // namespace stratus
