#include <stratus/scene/texture.h>

#include "instruction_sets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace stratus {
namespace {

/// Points spread evenly over the unit sphere.
std::vector<Vector3> sphere(int count) {
    std::vector<Vector3> points;
    for (int k = 0; k < count; ++k) {
        const double z = 1 - (2 * k + 1.0) / count, around = k * pi * (3 - std::sqrt(5.0));
        const double across = std::sqrt(1 - z * z);
        points.push_back({across * std::cos(around), across * std::sin(around), z});
    }
    return points;
}

TEST(DepthMap, CloudsHaveTheRequestedCoverage) {
    const auto points = sphere(20000);
    for (const double coverage : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        DepthMap map;
        map.pattern = DepthMap::Pattern::clouds;
        map.max = 10;
        map.scale = 6;  // many clouds, so that their share varies little
        map.coverage = coverage;
        int covered = 0;
        for (const Vector3& point : points) {
            const double depth = map.at(sphere_point(point));
            ASSERT_GE(depth, 0);
            ASSERT_LE(depth, 10);
            covered += depth > 0;
        }
        EXPECT_NEAR(covered / 20000.0, coverage, 0.08);  // noise is not quite normally distributed
    }
}

TEST(DepthMap, CloudsDriftByTheirOffset) {
    DepthMap map;
    map.pattern = DepthMap::Pattern::clouds;
    map.max = 10;
    map.scale = 2;
    DepthMap drifted = map;
    drifted.offset = {0.5, 0.25, -1};
    for (const Vector3& point : sphere(100))
        EXPECT_NEAR(drifted.at({point + drifted.offset, 0, 0}), map.at({point, 0, 0}), 1e-9);
}

/// Perlin's noise, corner by corner and octave by octave.
double plain_noise(Vector3 p, unsigned seed) {
    const auto scrambled = [](std::uint32_t n) {
        for (int round = 0; round < 2; ++round) n = (n ^ (n >> 16)) * 0x45d9f3bu;
        return n ^ (n >> 16);
    };
    const auto eased = [](double t) { return t * t * t * (t * (6 * t - 15) + 10); };
    double sum = 0;
    for (int octave = 0; octave < 8; ++octave) {
        const Vector3 cell{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
        double corner[8];
        for (int c = 0; c < 8; ++c) {
            const int step[] = {c & 1, (c >> 1) & 1, c >> 2};
            std::uint32_t hash = scrambled(seed + static_cast<std::uint32_t>(octave) + 0x9e3779b9u);
            const double at[] = {cell.x, cell.y, cell.z};
            for (int axis = 0; axis < 3; ++axis)
                hash = scrambled(hash ^ static_cast<std::uint32_t>(
                                            static_cast<std::int64_t>(at[axis]) + step[axis]));
            const double x = p.x - cell.x - step[0], y = p.y - cell.y - step[1],
                         z = p.z - cell.z - step[2];
            const double pairs[3][2] = {{x, y}, {x, z}, {y, z}};
            const std::uint32_t which = hash % 12;
            corner[c] = (which & 1 ? -1 : 1) * pairs[which / 4][0] +
                        (which & 2 ? -1 : 1) * pairs[which / 4][1];
        }
        const double share[] = {eased(p.x - cell.x), eased(p.y - cell.y), eased(p.z - cell.z)};
        for (int axis = 0, count = 4; axis < 3; ++axis, count /= 2)
            for (int c = 0; c < count; ++c)
                corner[c] = corner[2 * c] + share[axis] * (corner[2 * c + 1] - corner[2 * c]);
        sum += std::ldexp(corner[0], -octave);
        p = {1.6 * p.x + 1.2 * p.y + 17.3, 1.6 * p.y - 1.2 * p.x + 5.1, 2 * p.z + 11.7};
    }
    return sum;
}

TEST(Noise, IsPerlinsOnEveryProcessor) {
    for (const auto set : instruction_sets) {
        const InstructionSetLimit limit(set);
        for (int k = 0; k < 2000; ++k) {
            const double far = k % 4 == 3 ? 1e12 : 1;  // where cells pass 2^32
            const Vector3 point{far * (0.37 * k - 300), far * (200 - 0.171 * k), 0.5 - 0.03 * k};
            const auto seed = static_cast<unsigned>(k % 7);
            ASSERT_EQ(noise(point, seed), plain_noise(point, seed))
                << instruction_set_name(set) << ' ' << k;
        }
    }
}

TEST(SurfacePoint, OnASphereIsLongitudeAndLatitude) {
    EXPECT_NEAR(sphere_point({1, 0, 0}).u, 0.5, 1e-15);
    EXPECT_NEAR(sphere_point({0, 1, 0}).u, 0.75, 1e-15);
    EXPECT_NEAR(sphere_point({0, 0, 1}).v, 0, 1e-15);
    EXPECT_NEAR(sphere_point({0, 0, -1}).v, 1, 1e-15);
}

Texture image_texture(const std::shared_ptr<Image>& image) {
    Texture texture;
    texture.pattern = Texture::Pattern::image;
    texture.image = image;
    return texture;
}

TEST(Texture, InterpolatesImages) {
    auto image = std::make_shared<Image>(2, 2);
    const float values[] = {0.1f, 0.2f, 0.4f, 0.8f};
    for (int k = 0; k < 4; ++k)
        for (int c = 0; c < 3; ++c) image->pixel(k % 2, k / 2)[c] = values[k];
    const Texture texture = image_texture(image);
    auto at = [&](double u, double v) { return texture.at({{0, 0, 0}, u, v}).g; };
    EXPECT_FLOAT_EQ(at(0.25, 0.25), 0.1f);
    EXPECT_FLOAT_EQ(at(0.75, 0.25), 0.2f);
    EXPECT_FLOAT_EQ(at(0.25, 0.75), 0.4f);
    EXPECT_FLOAT_EQ(at(0.5, 0.25), 0.15f);
    EXPECT_FLOAT_EQ(at(0.5, 0.5), 0.375f);
    EXPECT_FLOAT_EQ(at(0, 0.25), 0.15f) << "across the seam";
    EXPECT_FLOAT_EQ(at(1, 0.25), 0.15f);
    EXPECT_FLOAT_EQ(at(-3.75, 2.25), 0.1f) << "repeated";

    DepthMap map;
    map.pattern = DepthMap::Pattern::image;
    map.image = image;
    map.max = 5;
    EXPECT_NEAR(map.at({{0, 0, 0}, 0.75, 0.75}), 4, 1e-6);
}

TEST(Texture, EndsImagesAtThePoles) {
    auto image = std::make_shared<Image>(4, 2);
    for (int x = 0; x < 4; ++x) image->pixel(x, 0)[0] = 1;  // the northern hemisphere
    const Texture texture = image_texture(image);
    const auto at = [&](const Vector3& point) { return texture.at(sphere_point(point)).r; };
    EXPECT_EQ(at({0, 0, 1}), 1);
    EXPECT_EQ(at({0.1, 0, std::sqrt(0.99)}), 1);
    EXPECT_EQ(at({-1, 0, 0}), 0.5f);
    EXPECT_EQ(at({0.1, 0, -std::sqrt(0.99)}), 0);
    EXPECT_EQ(at({0, 0, -1}), 0);
}

TEST(Texture, ShowsImagesOnAPlaneUprightFromAbove) {
    auto image = std::make_shared<Image>(2, 2);
    image->pixel(0, 0)[0] = 1;  // the upper left
    const Texture texture = image_texture(image);
    const auto at = [&](double x, double y) { return texture.at(plane_point(x, y, 4)).r; };
    EXPECT_EQ(at(1, 3), 1);
    EXPECT_EQ(at(1, 1), 0);
    EXPECT_EQ(at(3, 3), 0);
    EXPECT_EQ(at(-3, 7), 1) << "repeated";
}

TEST(Texture, ContinentsHaveTheirTwoColours) {
    Texture texture;
    texture.pattern = Texture::Pattern::continents;
    texture.colour = {0.1f, 0.1f, 0.1f};
    texture.other = {1, 1, 1};
    int land = 0;
    for (const Vector3& point : sphere(2000)) {
        const Rgb met = texture.at(sphere_point(point));
        ASSERT_EQ(met.g, met.r) << "grey as both";
        ASSERT_LE(met.g, 1);
        land += met.g == 1;
    }
    EXPECT_GT(land, 400);
}

TEST(Texture, SquaresHaveOneColourEach) {
    Texture texture;
    texture.pattern = Texture::Pattern::squares;
    texture.colour = {0.1f, 0.2f, 0.3f};
    texture.other = {0.5f, 0.6f, 0.7f};
    texture.scale = 4;
    auto at = [&](double u, double v) { return texture.at({{0, 0, 0}, u, v}).r; };
    EXPECT_EQ(at(0.01, 0.01), at(0.12, 0.24));
    EXPECT_NE(at(0.12, 0.24), at(0.13, 0.24));
    EXPECT_NE(at(0.12, 0.24), at(0.12, 0.26));
    for (int k = 0; k < 64; ++k) {
        EXPECT_GE(at(k / 64.0, 0.9), 0.1f);
        EXPECT_LE(at(k / 64.0, 0.9), 0.5f);
    }
}

}  // namespace
}  // namespace stratus
