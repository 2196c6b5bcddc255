#include <stratus/shader/shader.h>

#include <stratus/runtime/bsdf.h>
#include <stratus/runtime/path_law.h>

#include "as_cxx.h"
#include "lookups.h"
#include "refusal.h"
#include "small_table.h"
#ifdef STRATUS_RUN_CHROMIUM
#include "browser.h"
#endif

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace stratus {
namespace {

using test::differences, test::Differences, test::Light, test::Lookup;

/// Between 1 and 3, symmetric in the cosines.
double shape(const Point& p) {
    const double depth = p.optical_depth < infinity ? p.optical_depth / (1 + p.optical_depth) : 1;
    const double sines = std::sqrt((1 - p.mu_in * p.mu_in) * (1 - p.mu_out * p.mu_out));
    return 2 + 0.6 * std::sin(3 * depth + p.albedo) * std::cos(2 * (p.mu_in + p.mu_out)) +
           0.4 * sines * std::cos(p.azimuth) * (1 + p.albedo * depth) / 2;
}

/// A kind of table: what lookups do differs from one to another.
struct Kind {
    const char* name;
    const char* phase;
    bool to_infinity = true;
    int azimuths = 9;
    LowerBoundary below = {};
    bool narrowed = false, one_side = false;
};

Table table_of(const Kind& kind) {
    const bool over = kind.below.is_present();
    const Depths depths{0.05, 8, kind.to_infinity && !over};
    Table table = empty_table({6, 9, 12, kind.narrowed ? 7 : 12, kind.azimuths}, depths);
    table.phase_function = parse_phase_function(kind.phase);
    table.lower_boundary = kind.below;
    table.tolerance = 1e-3;
    if (kind.narrowed) {
        table.mu_out = make_axis(table.mu_out.scale, 0.2, 0.8, 7);
        table.azimuth = make_axis(AxisScale::square_root, 0.3, 2, kind.azimuths);
    }
    table.reflection_multiple = samples_of(table, [&](const Point& p) {
        return over ? 0.1 * shape(p) * (1 - std::exp(-p.optical_depth)) * p.albedo + 0.05 * shape(p)
                    : small_table_reflection_scale(p) * shape(p);
    });
    if (!over && !kind.one_side)
        table.transmission_multiple = samples_of(table, [](const Point& p) {
            return std::isinf(p.optical_depth) ? 0 : small_table_transmission_scale(p) * shape(p);
        });
    table.path_law = PathOrders::of(table.phase_function);
    prepare(table);
    return table;
}

const std::vector<Kind>& kinds() {
    static const std::vector<Kind> all{
        {"rings", "0.6*henyey_greenstein:g=-0.5 + 0.4*henyey_greenstein:g=0.5"},
        {"isotropic", "isotropic", true, 1},
        {"finite", "rayleigh", false},
        {"path_law", "henyey_greenstein:g=0.9", false},
        {"sampled_phase", "tabulated:points=0 3/30 1.5/90 0.5/180 1"},
        {"over_surface", "rayleigh", false, 9, LowerBoundary::surface(0.3)},
        {"over_layer", "rayleigh", false, 9, LowerBoundary::layer(PhaseFunction::rayleigh(), 0.6)},
        {"narrowed", "rayleigh", true, 7, {}, true},
        {"one_side", "rayleigh", true, 9, {}, false, true}};
    return all;
}

/// Light in so narrow a peak that directions are drawn in other coordinates.
const Kind droplets{"droplets", "mie:radius=10um,variance=0.1,wavelength=0.55um,material=water",
                    false};

std::string name_of(const testing::TestParamInfo<Kind>& row) { return row.param.name; }

std::vector<Light> as_cxx(const PackedTable& table, const std::vector<Lookup>& lookups) {
    shader::AsCxx shader(shader_textures(table));
    std::vector<Light> all;
    for (const auto& [w, tau, mu_in, mu_out, azimuth] : lookups) {
        const auto r = shader.stratus_reflection(w, tau, mu_in, mu_out, azimuth),
                   t = shader.stratus_transmission(w, tau, mu_in, mu_out, azimuth);
        all.push_back({r.single, r.multiple, t.single, t.multiple});
    }
    return all;
}

class ShaderOf : public testing::TestWithParam<Kind> {};

TEST_P(ShaderOf, IsTheRuntimeAsCxx) {
    const PackedTable table(pack(table_of(GetParam())));
    const std::vector<Lookup> lookups = test::random_lookups(table, 2000);
    const std::vector<Light> found = as_cxx(table, lookups), expected = by_runtime(table, lookups);
    const Differences off = differences(found, expected);
    EXPECT_LE(off.median, 1e-6);
    EXPECT_LE(off.worst, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ShaderOf, testing::ValuesIn(kinds()), name_of);

constexpr Medium<3> medium{{0.4, 1, 6}, {0.9, 0.7, 0.99}};

std::vector<ShaderTexture> with_layer(const PackedTable& table) {
    std::vector<ShaderTexture> textures = shader_textures(table);
    textures.push_back(shader_layer(table, medium));
    return textures;
}

/// Kinds that may be bound.
class ShaderLayerOf : public testing::TestWithParam<Kind> {};

TEST_P(ShaderLayerOf, IsTheTableAtThatLayer) {
    const PackedTable table(pack(table_of(GetParam())));
    shader::AsCxx shader(with_layer(table));
    for (const Lookup& at : test::random_lookups(table, 300)) {
        const auto r = shader.stratus_layer_reflection(at.mu_in, at.mu_out, at.azimuth);
        const auto t = shader.stratus_layer_transmission(at.mu_in, at.mu_out, at.azimuth);
        const auto direct = shader.stratus_layer_direct(at.mu_out);
        const auto expect_colour = [&](int c, float found_r, float found_t, float found_direct) {
            const Geometry geometry{double{at.mu_in}, double{at.mu_out}, double{at.azimuth}};
            const double w = medium.albedo[c], tau = medium.optical_depth[c];
            const double expected_r = table.reflection(w, tau, geometry).total(),
                         expected_t = table.transmission(w, tau, geometry).total();
            EXPECT_NEAR(double{found_r}, expected_r, 1e-5 * expected_r + 1e-6);
            EXPECT_NEAR(double{found_t}, expected_t, 1e-5 * expected_t + 1e-6);
            const double beam =
                GetParam().below.is_present() ? 0 : direct_transmittance(tau, double{at.mu_out});
            EXPECT_NEAR(double{found_direct}, beam, 1e-6);
        };
        expect_colour(0, r.single.x + r.multiple.x, t.single.x + t.multiple.x, direct.x);
        expect_colour(1, r.single.y + r.multiple.y, t.single.y + t.multiple.y, direct.y);
        expect_colour(2, r.single.z + r.multiple.z, t.single.z + t.multiple.z, direct.z);
    }
}

TEST_P(ShaderLayerOf, DrawsTheDirectionsOfABsdf) {
    const PackedTable table(pack(table_of(GetParam())));
    const RgbBsdf bsdf(RgbSlice(table.view(), medium));
    shader::AsCxx shader(with_layer(table));
    EXPECT_EQ(shader.stratus_is_peaked(), std::string(GetParam().name) == "droplets");
    for (const Lookup& at : test::random_lookups(table, 300)) {
        const float sine = std::sqrt((1 - at.mu_in) * (1 + at.mu_in));
        const float z = at.azimuth < 1 ? -at.mu_in : at.mu_in;  // some from below
        const Vector wi{sine * std::cos(at.azimuth), sine * std::sin(at.azimuth), z};
        const float u1 = at.mu_out, u2 = std::fmod(at.azimuth, 1.0f), u3 = at.albedo;
        const auto expected = bsdf.sample(wi, u1, u2, u3);
        const auto found = shader.stratus_layer_sample({wi.x, wi.y, wi.z}, u1, u2, u3);
        ASSERT_EQ(expected.pdf > 0, found.pdf > 0);
        if (!(expected.pdf > 0)) continue;
        EXPECT_NEAR(double{found.wo.x}, double{expected.wo.x}, 1e-4);
        EXPECT_NEAR(double{found.wo.y}, double{expected.wo.y}, 1e-4);
        EXPECT_NEAR(double{found.wo.z}, double{expected.wo.z}, 1e-4);
        EXPECT_NEAR(double{found.pdf}, double{expected.pdf}, 1e-3 * double{expected.pdf});
        const float pdf = bsdf.pdf(wi, expected.wo);
        EXPECT_NEAR(double{shader.stratus_layer_pdf({wi.x, wi.y, wi.z},
                                                    {expected.wo.x, expected.wo.y, expected.wo.z})},
                    double{pdf}, 1e-3 * double{pdf});
        const auto value = shader.stratus_layer_bsdf({wi.x, wi.y, wi.z}, found.wo);
        EXPECT_EQ(value.y, found.value.y);
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, ShaderLayerOf,
                         testing::Values(kinds()[0], kinds()[1], kinds()[2], kinds()[3], kinds()[5],
                                         kinds()[6], droplets),
                         name_of);

TEST(Shader, RefusesWhatItDoesNotRead) {
    const Table table = table_of(kinds()[0]);
    const PackedTable mixture(pack(mixed(table, table)));
    expect_refusal<std::invalid_argument>([&] { shader_textures(mixture); },
                                          {"shader", "TABLE", "mixture"});
    const PackedTable narrowed(pack(table_of(kinds()[7])));
    expect_refusal<std::invalid_argument>([&] { shader_layer(narrowed, medium); },
                                          {"shader", "TABLE", "narrowed"});
    const PackedTable finite(pack(table_of(kinds()[2])));
    expect_refusal<std::invalid_argument>(
        [&] {
            shader_layer(finite, {{100, 1, 1}, {1, 1, 1}});
        },
        {"100"});
}

#ifdef STRATUS_RUN_CHROMIUM
TEST(ShaderInABrowser, DrawsTheDirectionsOfABsdf) {
    const PackedTable table(pack(table_of(kinds()[0])));
    const RgbBsdf bsdf(RgbSlice(table.view(), medium));
    const std::vector<Lookup> lookups = test::random_lookups(table, 1000);
    const std::vector<Light> found = test::by_browser(with_layer(table), lookups, R"glsl(
        vec3 wi = vec3(sqrt((1.0 - along.x) * (1.0 + along.x)), 0.0, along.x);
        StratusSample drawn = stratus_layer_sample(wi, along.y, along.z / 6.2831854, layer.x);
        light = vec4(drawn.wo.xz, drawn.pdf, stratus_layer_pdf(wi, drawn.wo));
    )glsl");
    std::vector<double> off;
    for (std::size_t n = 0; n < lookups.size(); ++n) {
        const Lookup& at = lookups[n];
        const auto expected = bsdf.sample({std::sqrt((1 - at.mu_in) * (1 + at.mu_in)), 0, at.mu_in},
                                          at.mu_out, at.azimuth / 6.2831854f, at.albedo);
        off.push_back(std::max({double{std::abs(found[n][0] - expected.wo.x)},
                                double{std::abs(found[n][1] - expected.wo.z)},
                                double{std::abs(found[n][2] / expected.pdf - 1)},
                                double{std::abs(found[n][3] / expected.pdf - 1)}}));
    }
    std::sort(off.begin(), off.end());
    std::cout << "directions drawn: " << Differences{off[off.size() / 2], off.back()} << '\n';
    EXPECT_LE(off[off.size() / 2], 1e-5);
    EXPECT_LE(off[off.size() * 99 / 100], 1e-3);
}

class ShaderInABrowserOf : public testing::TestWithParam<Kind> {};

TEST_P(ShaderInABrowserOf, IsTheRuntime) {
    const PackedTable table(pack(table_of(GetParam())));
    const std::vector<Lookup> lookups = test::random_lookups(table, 10000);
    const std::vector<Light> found = test::by_browser(shader_textures(table), lookups);
    const Differences off = differences(found, by_runtime(table, lookups));
    std::cout << GetParam().name << ", 10000 points: " << off << '\n';
    EXPECT_LE(off.median, 1e-5);
    EXPECT_LE(off.worst, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ShaderInABrowserOf,
                         testing::Values(kinds()[0], kinds()[3], kinds()[6]), name_of);
#endif

}  // namespace
}  // namespace stratus
