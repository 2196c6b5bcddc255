// A path tracer of a dusty sphere on dusty ground, lit by the sun and a dim sky.
//
//     path_tracer TABLE.h5 PICTURE.ppm [SUN SKY BOUNCES]
//
// SUN is the irradiance on a plane that faces the sun, SKY the radiance of the sky. The picture
// holds linear radiance; 1 is white.
#include <stratus/base/constants.h>
#include <stratus/bsdf/bsdf.h>
#include <stratus/io/table_file.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <utility>

using stratus::infinity;
using stratus::Rgb;
using stratus::Vector;

Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vector operator*(float s, Vector a) { return {s * a.x, s * a.y, s * a.z}; }
Rgb operator+(Rgb a, Rgb b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
Rgb operator*(Rgb a, Rgb b) { return {a.r * b.r, a.g * b.g, a.b * b.b}; }
Rgb operator*(float s, Rgb a) { return {s * a.r, s * a.g, s * a.b}; }
float dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector cross(Vector a, Vector b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vector unit(Vector a) { return 1 / std::sqrt(dot(a, a)) * a; }

struct Ray {
    Vector origin, direction;
    Vector at(float t) const { return origin + t * direction; }
};

struct Hit {
    float distance = std::numeric_limits<float>::infinity();
    Vector normal{0, 0, 1};
};

/// The unit sphere about the origin and the plane z = -1.
Hit nearest_hit(const Ray& ray) {
    constexpr float min_distance = 1e-3f;  // so that a ray does not hit its own origin
    Hit hit;
    const float down = (-1 - ray.origin.z) / ray.direction.z;
    if (down > min_distance) hit.distance = down;
    const float b = dot(ray.origin, ray.direction), c = dot(ray.origin, ray.origin) - 1;
    if (b * b <= c) return hit;
    const float near = -b - std::sqrt(b * b - c);
    if (near > min_distance && near < hit.distance) hit = {near, unit(ray.at(near))};
    return hit;
}

/// The local frame of a surface, z along its normal, in which a BSDF's vectors are given.
struct Frame {
    Vector x, y, z;
    explicit Frame(Vector normal)
        : x(unit(cross(std::abs(normal.x) < 0.5f ? Vector{1, 0, 0} : Vector{0, 1, 0}, normal))),
          y(cross(normal, x)),
          z(normal) {}
    Vector to_local(Vector v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
    Vector to_world(Vector v) const { return v.x * x + v.y * y + v.z * z; }
};

struct Scene {
    stratus::RgbBsdf dust;
    float sun, sky;
    int bounces;
    Vector to_sun;
};

/// Radiance along a ray: sunlight at every bounce, and the sky where the path escapes.
template <class Random>
Rgb radiance(const Scene& scene, Ray ray, Random& random) {
    Rgb light{0, 0, 0}, weight{1, 1, 1};
    for (int bounce = 0; bounce < scene.bounces; ++bounce) {
        const Hit hit = nearest_hit(ray);
        if (std::isinf(hit.distance)) return light + scene.sky * weight;
        const Vector point = ray.at(hit.distance);
        const Frame frame(hit.normal);
        const Vector wo = frame.to_local(-1.0f * ray.direction);
        const Vector wi = frame.to_local(scene.to_sun);
        if (wi.z > 0 && std::isinf(nearest_hit({point, scene.to_sun}).distance))
            light = light + scene.sun * wi.z * weight * scene.dust.eval(wi, wo);
        // By reciprocity, where light came from is sampled as where it would go.
        const auto next = scene.dust.sample(wo, random(), random(), random());
        if (!(next.pdf > 0)) break;
        weight = std::abs(next.wo.z) / next.pdf * weight * next.value;
        ray = {point, frame.to_world(next.wo)};
    }
    return light;
}

int main(int argc, char** argv) {
    if (argc < 3)
        return std::fputs("usage: path_tracer TABLE PICTURE [SUN SKY BOUNCES]\n", stderr), 2;
    const auto number = [&](int i, float standard) {
        return argc > i ? std::strtof(argv[i], nullptr) : standard;
    };
    // Semi-infinite dust, so that nothing is transmitted; a little redder than white.
    const stratus::Table table = stratus::read_table(argv[1]);
    stratus::RgbSlice dust = stratus::bind_rgb(
        table.view(), {stratus::infinity, stratus::infinity, stratus::infinity}, {1, 0.97, 0.9});
    const Scene scene{stratus::RgbBsdf(std::move(dust)), number(3, 2.5f), number(4, 0.05f),
                      static_cast<int>(number(5, 100)), unit({1, -1, 1})};

    // Parallel rays, 45 degrees downwards.
    constexpr int size = 120, samples = 32;
    constexpr float half_width = 1.6f;
    const Vector forward = unit({0, 1, -1}), right{1, 0, 0}, up = cross(right, forward);
    std::mt19937 generator(1982);
    const auto random = [&] { return static_cast<float>(generator() >> 8) * 0x1p-24f; };
    std::FILE* const picture = std::fopen(argv[2], "w");
    if (picture == nullptr) return std::perror(argv[2]), 1;
    std::fprintf(picture, "P3\n%d %d\n65535\n", size, size);
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column) {
            Rgb sum{0, 0, 0};
            for (int s = 0; s < samples; ++s) {
                const float x = half_width * (2 * (column + random()) / size - 1);
                const float y = half_width * (1 - 2 * (row + random()) / size);
                sum =
                    sum + radiance(scene, {x * right + y * up + -10.0f * forward, forward}, random);
            }
            for (const float value : {sum.r, sum.g, sum.b})
                std::fprintf(picture, "%.0f ", std::fmin(value / samples, 1.0f) * 65535);
            std::fputc('\n', picture);
        }
    return std::fclose(picture) == 0 ? 0 : 1;
}
