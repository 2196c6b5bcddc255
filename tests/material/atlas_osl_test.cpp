// The example for Open Shading Language, compiled as C++ (CMakeLists.txt rewrites its declaration)
// and run on an atlas: Debian 12 has no compiler of the language itself.
#include <stratus/io/image.h>

#include "atlas_reader.h"
#include "material_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace stratus {
namespace {

using namespace test;

// What the shader uses of the language; its vectors, normals and colours differ in meaning alone.
namespace osl {

struct vector {
    double x = 0, y = 0, z = 0;

    vector(double all = 0) : x(all), y(all), z(all) {}
    vector(double x_, double y_, double z_) : x(x_), y(y_), z(z_) {}
};
using color = vector;
using normal = vector;
using std::asin, std::sqrt, std::acos, std::abs, std::string;

vector operator-(const vector& a) { return {-a.x, -a.y, -a.z}; }
vector operator-(const vector& a, const vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
vector operator+(const vector& a, const vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
vector operator*(const vector& a, const vector& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
vector operator/(const vector& a, const vector& b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
double dot(const vector& a, const vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double length(const vector& a) { return std::sqrt(dot(a, a)); }
vector normalize(const vector& a) { return a / length(a); }
double min(double a, double b) { return std::min(a, b); }
int min(int a, int b) { return std::min(a, b); }
double clamp(double x, double low, double high) { return std::clamp(x, low, high); }
vector mix(const vector& a, const vector& b, double share) { return a * (1 - share) + b * share; }

const Image* picture = nullptr;

/// Bilinear, s to the right, t downward, the centres of texels at half numbers.
color texture(const string& /*name*/, double s, double t, double, double, double, double,
              const char*, const char* filter, const char*, const char*) {
    EXPECT_STREQ(filter, "linear");
    const double x = s * picture->width - 0.5, y = t * picture->height - 0.5;
    const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
    color sum(0);
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
            const float* const texel = picture->pixel(std::clamp(left + i, 0, picture->width - 1),
                                                      std::clamp(top + j, 0, picture->height - 1));
            const double weight = (i ? x - left : 1 - (x - left)) * (j ? y - top : 1 - (y - top));
            sum = sum + color(static_cast<double>(texel[0]), static_cast<double>(texel[1]),
                              static_cast<double>(texel[2])) *
                            weight;
        }
    return sum;
}

vector N, I;

#include "atlas_osl.inc"

}  // namespace osl

TEST(AtlasShader, ShowsALayerUnderOneSun) {
    const TemporaryFolder folder;
    Stack red = layer("henyey_greenstein:g=0.5", 0.95, 1), blue = red;
    blue.layers[0].albedo = 0.7;
    write_material(make_material({{red, red, blue}, ""}, MaterialFormat::exr_atlas),
                   folder / "atlas.exr");
    const Image picture = read_exr_image(folder / "atlas.exr");
    osl::picture = &picture;
    const AtlasReader reader(folder / "atlas.exr", content(folder / "atlas.json"));
    const auto direction = [](double cosine, double angle) -> osl::vector {
        const double sine = std::sqrt(1 - cosine * cosine);
        return {sine * std::cos(angle), sine * std::sin(angle), cosine};
    };
    const auto shown = [&](const osl::vector& sun, int transmission) {
        osl::color colour(0);
        osl::atlas("atlas.exr", sun, osl::color(2), transmission, reader.number("columns"),
                   reader.number("tile_width"), reader.number("tile_height"), reader.rows(),
                   colour);
        return colour;
    };
    for (const Expected& at : random_geometries(red, 60, 0.02)) {
        const auto& [mu_in, mu_out, azimuth] = at.geometry;
        // Forward is where the light goes: away from the sun.
        const osl::vector eye = direction(mu_out, 0.3 + pi + azimuth);
        for (const double facing : {1.0, -1.0}) {  // N points at either side
            osl::N = osl::vector(0, 0, 3 * facing);
            osl::I = -eye * osl::vector(5);
            const osl::color lit = shown(direction(mu_in, 0.3), 1);
            const auto f = reader(0, mu_in, mu_out, azimuth);
            EXPECT_NEAR(lit.x, 2 * mu_in * f[0], 1e-6 * lit.x);
            EXPECT_NEAR(lit.z, 2 * mu_in * f[2], 1e-6 * lit.z);
            EXPECT_NEAR(lit.x, 2 * mu_in * at.reflection / pi, 2e-2 * lit.x);
            const osl::color through = shown(direction(-mu_in, 0.3), 1);
            EXPECT_NEAR(through.x, 2 * mu_in * at.transmission / pi, 2e-2 * through.x);
            EXPECT_EQ(shown(direction(-mu_in, 0.3), 0).x, 0);
        }
    }
}

}  // namespace
}  // namespace stratus
