// Ringlets narrower than pixels, whose light is that of their area wherever the pixels lie.
#include "ring_light.h"

#include <stratus/base/constants.h>
#include <stratus/scene/render.h>

#include "small_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace stratus {
namespace {

constexpr int pixels = 200;
constexpr double radius = 2, pixel = 6.0 / pixels, width = pixel / 50;
constexpr double elevation = 0.7;  // radians, of the eye

/// One ringlet around a black planet, 1/50 of a pixel wide where it is seen face on.
Scene ringlet(double optical_depth, int samples) {
    Scene scene = once(small_rings(optical_depth));
    scene.width = scene.height = pixels;
    scene.samples = samples;
    scene.camera.width = pixels * pixel;
    scene.camera.position = 10.0 * Vector3{std::cos(elevation), 0, std::sin(elevation)};
    scene.effects.shadows = false;
    Rings& rings = the_rings(scene);
    rings.surface = {};
    const double ramp = 1e-9;
    rings.profile = {{radius - ramp, radius, radius + width, radius + width + ramp},
                     {0, optical_depth, optical_depth, 0},
                     {0.5, 0.5, 0.5, 0.5},
                     {0.1, 0.1, 0.1, 0.1}};
    return scene;
}

/// Of the ringlet's own light, along a ray.
double ringlet_light(const Scene& scene, const LayerLight& light) {
    const Vector3 point{0, radius + width / 2, 0};
    const Vector3 forward = scene.camera.forward();
    return radiance_along(scene, light, {point + -10.0 * forward, forward}, scene.to_sun)[0];
}

/// Pixels that the ringlet covers in a row whose middle is `middle` above that of the picture, by
/// the chord of either circle along lines in it.
double area_in_row(double middle) {
    constexpr int lines = 2000;
    double sum = 0;
    for (int k = 0; k < lines; ++k) {
        const double up = (middle + pixel * ((k + 0.5) / lines - 0.5)) / std::sin(elevation);
        auto half_chord = [&](double r) { return std::sqrt(std::max(0.0, r * r - up * up)); };
        sum += 2 * (half_chord(radius + width) - half_chord(radius));
    }
    return sum / lines / pixel;
}

TEST(Ringlet, CountsByItsAreaWhereverThePixelsLie) {
    const double area = pi * ((radius + width) * (radius + width) - radius * radius) *
                        std::sin(elevation) / (pixel * pixel);
    for (const int samples : {1, 2, 5})
        for (const double shift : {0.0, 0.13, 0.29, 0.5, 0.77}) {  // of a pixel
            Scene scene = ringlet(2, samples);
            const Vector3 offset = shift * pixel * scene.camera.right();
            scene.camera.position = scene.camera.position + offset;
            scene.camera.look_at = scene.camera.look_at + offset;
            const LayerLight light(scene, nullptr);
            const double own = ringlet_light(scene, light);
            ASSERT_GT(own, 0.01);
            const Image image = render(scene, light);
            double all = 0;
            for (int y = 0; y < scene.height; ++y) {
                double sum = 0;
                for (int x = 0; x < scene.width; ++x) sum += double{image.pixel(x, y)[0]};
                all += sum;
                if (y < 62 || y >= 138) continue;  // the ring ends 43 rows from the middle
                const double middle = ((pixels - 1) / 2.0 - y) * pixel;
                EXPECT_NEAR(sum / own / area_in_row(middle), 1, 0.01)
                    << samples << " samples, shift " << shift << ", row " << y;
            }
            EXPECT_NEAR(all / own / area, 1, 0.01) << samples << " samples, shift " << shift;
        }
}

TEST(Ringlet, DimsWhatLiesBehindByItsArea) {
    Scene scene = ringlet(1, 1);
    scene.effects.single = false;
    scene.background.colour = {1, 1, 1};
    const LayerLight light(scene, nullptr);
    const double dimmed = 1 - std::exp(-1 / std::sin(elevation));
    const Image image = render(scene, light);
    double sum = 0;
    for (int x = 0; x < scene.width; ++x)
        if (std::abs(x - 99.5) > 40) sum += 1 - double{image.pixel(x, 85)[0]};  // beside the planet
    EXPECT_NEAR(sum / dimmed / area_in_row(14.5 * pixel), 1, 0.01);
}

/// The mean of `value` over a cell, and the sum of the shares.
std::array<double, 2> mean_over(const RingFootprint& cell, const RingProfile& profile,
                                const std::function<double(double depth)>& value) {
    std::array<double, 2> sums{};
    cell.visit(profile, {1, 1, 1}, 1, [&](const Matter& matter, double, double share) {
        sums[0] += share * value(matter.optical_depth);
        sums[1] += share;
    });
    return sums;
}

TEST(RingFootprint, MeansArePartsOfACell) {
    // A cell 3 wide by columns and 1 by rows about radius 5: of its area 1/24 lies within 3.5 and
    // 1/6 + 1/6 between 4 and 5.
    const RingFootprint cell(5, {3.5, 6.5, 4.5, 5.5});
    EXPECT_DOUBLE_EQ(cell.within(3), 0);
    EXPECT_DOUBLE_EQ(cell.within(3.5), 1.0 / 24);
    EXPECT_DOUBLE_EQ(cell.within(4), 1.0 / 6);
    EXPECT_DOUBLE_EQ(cell.within(5), 0.5);
    EXPECT_DOUBLE_EQ(cell.within(7), 1);
}

TEST(RingFootprint, MeansTheLightAndNotTheDepth) {
    // exp(-tau) over a ramp of depths from 0 to 8: (1 - exp(-8)) / 8; the cell is 4 wide, half of it
    // beyond the rings.
    const RingProfile ramp{{10, 12}, {0, 8}, {0, 0}, {0, 0}};
    const auto [mean, shares] = mean_over(RingFootprint(10, {8, 12, 10, 10}), ramp,
                                          [](double depth) { return std::exp(-depth); });
    EXPECT_NEAR(shares, 1, 1e-14);
    EXPECT_NEAR(mean, 0.5 + 0.5 * (1 - std::exp(-8)) / 8, 3e-4);
}

TEST(RingFootprint, StandsForManyRowsByFew) {
    RingProfile comb;
    for (int k = 0; k <= 20000; ++k) {
        comb.radius.push_back(10 + k * 1e-4);
        comb.optical_depth.push_back(k % 4 < 2 ? 0 : 1);
    }
    comb.w1 = comb.w2 = std::vector<double>(comb.radius.size());
    int visits = 0;
    const RingFootprint cell(11, {10, 12, 11, 11});
    cell.visit(comb, {1, 1, 1}, 1, [&](const Matter&, double, double) { ++visits; });
    EXPECT_LE(visits, 64);
    double sum = 0, squares = 0;
    constexpr int cells = 400;
    for (int k = 0; k < cells; ++k) {
        const double left = 10 + 0.001 * k;
        const auto [mean, shares] =
            mean_over(RingFootprint(left + 0.5, {left, left + 1, left + 0.5, left + 0.5}), comb,
                      [](double depth) { return depth; });
        EXPECT_NEAR(shares, 1, 1e-12);
        sum += mean - 0.5;
        squares += (mean - 0.5) * (mean - 0.5);
    }
    EXPECT_NEAR(sum / cells, 0, 0.02);
    EXPECT_LT(std::sqrt(squares / cells), 0.43 / 8) << "the depths' standard deviation is 0.43";
}

TEST(RingFootprint, IsAPointWhereThePlaneEnds) {
    const RingFootprint cell(5, {4, 6, infinity, 5});
    EXPECT_EQ(cell.begin(), 5);
    EXPECT_EQ(cell.end(), 5);
}

}  // namespace
}  // namespace stratus
