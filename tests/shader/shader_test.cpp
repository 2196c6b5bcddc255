#include <stratus/shader/shader.h>

#include <stratus/bsdf/bsdf.h>
#include <stratus/phase/path_law.h>
#include <stratus/table/member_and_ground.h>

#include "filtered_as_cxx.h"
#include "indices.h"
#include "kinds.h"
#include "lookups.h"
#include "refusal.h"
#ifdef STRATUS_RUN_CHROMIUM
#include "browser.h"
#include "row_name.h"
#include "uniform.h"
#endif

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <locale>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

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
    const std::vector<Lookup> lookups = random_lookups(table, 2000);
    const std::vector<Light> found = as_cxx(table, lookups), expected = by_runtime(table, lookups);
    const Differences off = differences(found, expected);
    EXPECT_LE(off.median, 1e-6);
    EXPECT_LE(off.worst, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ShaderOf, testing::ValuesIn(kinds()), row_name);
INSTANTIATE_TEST_SUITE_P(Stacks, ShaderOf, testing::ValuesIn(stacks()), row_name);

TEST(Shader, IsTheRuntimeBehindDeepDroplets) {
    Table path_law_alone = table_of(droplets);
    for (float& sample : path_law_alone.transmission_multiple) sample = 0;
    const PackedTable table(pack(path_law_alone));
    shader::AsCxx shader(shader_textures(table));
    Uniform<float> uniform(1);
    for (int n = 0; n < 1000; ++n) {
        const float w = 0.9f + 0.1f * uniform(), tau = 30 + 20 * uniform(),
                    mu_in = 0.9f + 0.1f * uniform(), mu_out = mu_in - 0.1f * uniform(),
                    azimuth = 0.3f * uniform();
        const double expected = table
                                    .transmission(double{w}, double{tau},
                                                  {double{mu_in}, double{mu_out}, double{azimuth}})
                                    .multiple;
        const float found = shader.stratus_transmission(w, tau, mu_in, mu_out, azimuth).multiple;
        EXPECT_NEAR(found, expected, 1e-3 * std::abs(expected) + 2e-8);
    }
}

TEST(Shader, TakesOneMixtureOfATable) {
    Kind other = kind_of("rings");
    other.phase = "rayleigh";
    Table second = table_of(other);
    for (float& sample : second.reflection_multiple) sample *= 1.2f;
    const Table mixture = mixed(table_of(kind_of("rings")), second);
    const PackedTable packed(pack(mixture)), one(pack(table_at(mixture, {0.4})));
    const std::vector<Lookup> lookups = random_lookups(one, 1000);
    const Differences off = differences(as_cxx(one, lookups), by_runtime(packed, lookups, 0.4));
    EXPECT_LE(off.median, 1e-4);
    EXPECT_LE(off.worst, 1e-3);  // the table's tolerance
    expect_refusal([&] { shader_textures(packed); },
                   {"TABLE", "of one phase function", "got one of a family"});
}

constexpr Medium<3> three_layers{{0.4, 1, 6}, {0.9, 0.7, 0.99}};

/// What is bound: of a stack itself.
Medium<3> make_medium(const PackedTable& table) {
    if (!table.view().is_stack()) return three_layers;
    const double depth = table.view().optical_depth.lowest, albedo = table.view().albedo.lowest;
    return {{depth, depth, depth}, {albedo, albedo, albedo}};
}

std::vector<ShaderTexture> with_layer(const PackedTable& table) {
    std::vector<ShaderTexture> textures = shader_textures(table);
    textures.push_back(shader_layer(table, make_medium(table)));
    return textures;
}

/// Kinds that may be bound.
class ShaderLayerOf : public testing::TestWithParam<Kind> {};

TEST_P(ShaderLayerOf, IsTheTableAtThatLayer) {
    const PackedTable table(pack(table_of(GetParam())));
    shader::AsCxx shader(with_layer(table));
    const Medium<3> medium = make_medium(table);
    for (const Lookup& at : random_lookups(table, 300)) {
        const auto r = shader.stratus_layer_reflection(at.mu_in, at.mu_out, at.azimuth);
        const auto t = shader.stratus_layer_transmission(at.mu_in, at.mu_out, at.azimuth);
        const auto direct = shader.stratus_layer_direct(at.mu_out);
        const auto expect_colour = [&](int c, float found_r, float found_t, float found_direct) {
            const double w = medium.albedo[c], tau = medium.optical_depth[c];
            const double expected_r = table.reflection(w, tau, at.geometry()).total(),
                         expected_t = table.transmission(w, tau, at.geometry()).total();
            EXPECT_NEAR(found_r, expected_r, 1e-5 * expected_r + 1e-6);
            EXPECT_NEAR(found_t, expected_t, 1e-5 * expected_t + 1e-6);
            const double beam =
                GetParam().below.is_present() ? 0 : direct_transmittance(tau, double{at.mu_out});
            EXPECT_NEAR(found_direct, beam, 1e-6);
        };
        expect_colour(0, r.single.x + r.multiple.x, t.single.x + t.multiple.x, direct.x);
        expect_colour(1, r.single.y + r.multiple.y, t.single.y + t.multiple.y, direct.y);
        expect_colour(2, r.single.z + r.multiple.z, t.single.z + t.multiple.z, direct.z);
    }
}

TEST_P(ShaderLayerOf, DrawsTheDirectionsOfABsdf) {
    const PackedTable table(pack(table_of(GetParam())));
    const RgbBsdf bsdf(RgbSlice(table.view(), make_medium(table)));
    shader::AsCxx shader(with_layer(table));
    EXPECT_EQ(shader.stratus_is_peaked(), std::string(GetParam().name) == "droplets");
    for (const Lookup& at : random_lookups(table, 300)) {
        const float sine = std::sqrt((1 - at.mu_in) * (1 + at.mu_in));
        const float z = at.azimuth < 1 ? -at.mu_in : at.mu_in;  // some from below
        const Vector wi{sine * std::cos(at.azimuth), sine * std::sin(at.azimuth), z};
        const float u1 = at.mu_out, u2 = std::fmod(at.azimuth, 1.0f), u3 = at.albedo;
        const auto expected = bsdf.sample(wi, u1, u2, u3);
        const auto found = shader.stratus_layer_sample({wi.x, wi.y, wi.z}, u1, u2, u3);
        ASSERT_EQ(expected.pdf > 0, found.pdf > 0);
        if (!(expected.pdf > 0)) continue;
        EXPECT_NEAR(found.wo.x, expected.wo.x, 1e-4);
        EXPECT_NEAR(found.wo.y, expected.wo.y, 1e-4);
        EXPECT_NEAR(found.wo.z, expected.wo.z, 1e-4);
        EXPECT_NEAR(found.pdf, expected.pdf, 1e-3 * double{expected.pdf});
        const float pdf = bsdf.pdf(wi, expected.wo);
        EXPECT_NEAR(shader.stratus_layer_pdf({wi.x, wi.y, wi.z},
                                             {expected.wo.x, expected.wo.y, expected.wo.z}),
                    pdf, 1e-3 * double{pdf});
        const auto value = shader.stratus_layer_bsdf({wi.x, wi.y, wi.z}, found.wo);
        EXPECT_EQ(value.y, found.value.y);
        const auto [red, green, blue] = bsdf.eval(wi, {found.wo.x, found.wo.y, found.wo.z});
        EXPECT_NEAR(value.y, green, 1e-3 * double{green});
    }
    for (const float z :
         {1.0f, -1.0f}) {  // straight on and back, where either may take another azimuth
        const float pdf = bsdf.pdf({0, 0, 1}, {0, 0, z});
        EXPECT_NEAR(shader.stratus_layer_pdf({0, 0, 1}, {0, 0, z}), pdf, 0.2 * double{pdf});
    }
    if (!table.view().is_stack() && !table.view().has_lower_boundary()) return;
    EXPECT_EQ(shader.stratus_layer_bsdf({0, 0.6f, -0.8f}, {0, 0.6f, 0.8f}).y, 0);
    EXPECT_EQ(shader.stratus_bsdf({0, 0.6f, -0.8f}, {0, 0.6f, -0.8f}, 0.9f, 1), 0);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ShaderLayerOf,
                         testing::ValuesIn(kinds_of({"rings", "isotropic", "finite", "path_law",
                                                     "over_surface", "over_layer", "stack",
                                                     "stack_over_surface", "droplets"})),
                         row_name);

TEST(Shader, ScattersNothingToASideThatTheTableLacks) {
    const PackedTable table(pack(table_of(kinds_of({"one_side"})[0])));
    shader::AsCxx shader(with_layer(table));
    const shader::vec3 in{0.6f, 0, 0.8f}, up{0, 0.6f, 0.8f}, down{0, 0.6f, -0.8f};
    EXPECT_GT(shader.stratus_bsdf(in, up, 0.9f, 1), 0);
    EXPECT_EQ(shader.stratus_bsdf(in, down, 0.9f, 1), 0);
    EXPECT_GT(shader.stratus_layer_bsdf(in, up).y, 0);
    EXPECT_EQ(shader.stratus_layer_bsdf(in, down).y, 0);
}

class FilteredLayerOf : public testing::TestWithParam<Kind> {};

/// At the same directions by the runtime: R, T of all orders of the first and the last colour.
std::vector<Light> filtered_light(const PackedTable& table, const std::vector<Lookup>& lookups) {
    const Medium<3> medium = make_medium(table);
    std::vector<Light> all;
    for (const Lookup& at : lookups) {
        const auto total = [&](Side side, int c) {
            return static_cast<float>(
                table.scattering(side, medium.albedo[c], medium.optical_depth[c], at.geometry())
                    .total());
        };
        all.push_back({total(Side::reflection, 0), total(Side::reflection, 2),
                       total(Side::transmission, 0), total(Side::transmission, 2)});
    }
    return all;
}

/// The share of differences, relative to the runtime's, above 2e-3.
double share_off(const std::vector<Light>& found, const std::vector<Light>& expected) {
    int off = 0, all = 0;
    for (const auto n : indices(found))
        for (std::size_t k = 0; k < 4; ++k) {
            if (expected[n][k] == 0 && found[n][k] == 0) continue;
            ++all;
            off += !(std::abs(found[n][k] - expected[n][k]) <= 2e-3f * expected[n][k] + 1e-6f);
        }
    return static_cast<double>(off) / all;
}

TEST_P(FilteredLayerOf, IsTheTableAtThatLayerByFourFetches) {
    const PackedTable table(pack(table_of(GetParam())));
    const FilteredLight layer = filtered_layer(table, make_medium(table));
    EXPECT_LE(layer.usual_error, 2e-3);
    shader::FilteredAsCxx shader(layer);
    const std::vector<Lookup> lookups = random_lookups(table, 1000);
    std::vector<Light> found;
    for (const Lookup& at : lookups) {
        shader.fetches = 0;
        const auto r = shader.stratus_layer_reflection(at.mu_in, at.mu_out, at.azimuth);
        const bool narrow_peak = table.view().path_law != nullptr;
        const int layers = table.view().is_stack() ? 4 : 1;   // their phase functions, sampled
        const int most = 4 + layers + (narrow_peak ? 3 : 0);  // of the law one a depth
        EXPECT_LE(shader.fetches, most);
        const auto t = shader.stratus_layer_transmission(at.mu_in, at.mu_out, at.azimuth);
        EXPECT_LE(shader.fetches, 2 * most);
        found.push_back({r.single.x + r.multiple.x, r.single.z + r.multiple.z,
                         t.single.x + t.multiple.x, t.single.z + t.multiple.z});
    }
    EXPECT_LE(share_off(found, filtered_light(table, lookups)), 2e-3);
}

INSTANTIATE_TEST_SUITE_P(Kinds, FilteredLayerOf,
                         testing::ValuesIn(kinds_of({"rings", "isotropic", "finite", "path_law",
                                                     "over_surface", "over_layer", "one_side",
                                                     "stack", "stack_over_layer"})),
                         row_name);

class FilteredLayersOf : public testing::TestWithParam<Kind> {};

/// R and T of all orders.
std::vector<Light> totals(std::vector<Light> light) {
    for (Light& at : light) at = {at[0] + at[1], 0, at[2] + at[3], 0};
    return light;
}

/// Between the deepest finite sample and infinity these tables turn faster than light does.
Kind without_infinity(Kind kind) {
    kind.to_infinity = false;
    return kind;
}

TEST_P(FilteredLayersOf, AreTheTableByAtMost32Fetches) {
    const PackedTable table(pack(table_of(without_infinity(GetParam()))));
    const FilteredLight layers = filtered_layers(table);
    EXPECT_LE(layers.usual_error, 2e-3);
    shader::FilteredAsCxx shader(layers);
    const std::vector<Lookup> lookups = random_lookups(table, 1000);
    const bool narrow_peak = table.view().path_law != nullptr;
    const int of_words = GetParam().azimuths > 1 ? 8 : 4;
    // One of the phase function's samples, if it has any.
    const int most = 3 * (of_words + 1) + 1 + (narrow_peak ? 4 : 0);
    std::vector<Light> found;
    for (const auto& [w, tau, mu_in, mu_out, azimuth] : lookups) {
        shader.fetches = 0;
        const auto r = shader.stratus_reflection(w, tau, mu_in, mu_out, azimuth);
        EXPECT_LE(shader.fetches, most);
        const auto t = shader.stratus_transmission(w, tau, mu_in, mu_out, azimuth);
        EXPECT_LE(shader.fetches, 2 * most);
        found.push_back({r.single, r.multiple, t.single, t.multiple});
    }
    EXPECT_LE(share_off(totals(found), totals(by_runtime(table, lookups))), 2e-3);
}

INSTANTIATE_TEST_SUITE_P(Kinds, FilteredLayersOf,
                         testing::ValuesIn(kinds_of({"rings", "isotropic", "path_law",
                                                     "over_surface", "over_layer", "one_side"})),
                         row_name);

TEST(Shader, CountsArgumentsOutOfRangeAsTheNearest) {
    shader::AsCxx shader(shader_textures(PackedTable(pack(table_of(kinds()[4])))));
    const auto single = [&](float albedo) {
        return shader.stratus_single(STRATUS_REFLECTION, albedo, 1, 0.5f, 0.6f, 1);
    };
    EXPECT_EQ(single(1.5f), single(1));
    EXPECT_EQ(single(-1), 0);
    EXPECT_EQ(shader.stratus_phase(1.0000001f), shader.stratus_phase(1));
    EXPECT_EQ(shader.stratus_phase(-1.0000001f), shader.stratus_phase(-1));
}

TEST(Shader, BindsLayersThatATableKnowsByLaw) {
    Kind deep = kinds()[2];
    deep.deepest = 20;
    const PackedTable table(pack(table_of(deep)));
    const Medium<3> black_and_deep{{1, 24, infinity}, {0, 0.9, 0.5}};
    std::vector<ShaderTexture> textures = shader_textures(table);
    textures.push_back(shader_layer(table, black_and_deep));
    shader::AsCxx exact(textures);
    shader::FilteredAsCxx filtered(filtered_layer(table, black_and_deep));
    const RgbSlice slice(table.view(), black_and_deep);
    for (const Lookup& at : random_lookups(table, 100))
        for (const int side : {STRATUS_REFLECTION, STRATUS_TRANSMISSION}) {
            const Rgb light =
                slice.scattering(static_cast<Side>(side), at.mu_in, at.mu_out, at.azimuth);
            const auto expect_light = [&](auto& text) {
                const auto path = text.stratus_path(side, at.mu_in, at.mu_out, at.azimuth);
                const auto [single, multiple] = text.stratus_layer_scattered(side, path);
                EXPECT_NEAR(single.x + multiple.x, light.r, 5e-3 * double{light.r});
                EXPECT_NEAR(single.y + multiple.y, light.g, 5e-3 * double{light.g});
                EXPECT_NEAR(single.z + multiple.z, light.b, 5e-3 * double{light.b});
            };
            expect_light(exact);
            expect_light(filtered);
        }
}

/// Halves lose none of what peaks of light leave aside.
TEST(Shader, FiltersThePathLawOfTheNarrowestPeaks) {
    Kind large = droplets;
    large.phase = "mie:radius=20um,variance=0.1,wavelength=0.45um,material=water";
    const PackedTable table(pack(table_of(large)));
    shader::AsCxx exact(shader_textures(table));
    shader::FilteredAsCxx any(filtered_layers(table)), bound(filtered_layer(table, three_layers));
    constexpr float diffuse = 0.1f;  // about what clouds scatter everywhere besides
    std::vector<double> off;
    for (const Lookup& at : random_lookups(table, 3000))
        for (const int side : {STRATUS_REFLECTION, STRATUS_TRANSMISSION}) {
            const auto path = exact.stratus_path(side, at.mu_in, at.mu_out, at.azimuth);
            const auto filtered = any.stratus_path(side, at.mu_in, at.mu_out, at.azimuth);
            const auto compare = [&](float albedo, float depth, float found) {
                const float law = exact.stratus_along_path(side, albedo, depth, path),
                            once = exact.stratus_single(side, albedo, depth, at.mu_in, at.mu_out,
                                                        at.azimuth);
                off.push_back(double{std::abs(found - law) / (std::abs(law) + once + diffuse)});
            };
            compare(at.albedo, at.optical_depth,
                    any.stratus_along_path(side, at.albedo, at.optical_depth, filtered));
            compare(0.99f, 6,
                    bound
                        .stratus_layer_along_path(
                            side, bound.stratus_path(side, at.mu_in, at.mu_out, at.azimuth))
                        .z);
        }
    std::ranges::sort(off);
    EXPECT_LE(off[off.size() * 999 / 1000], 2e-3);
}

TEST(Shader, HasFilteredLayersWithoutEnd) {
    const PackedTable table(pack(table_of(kind_of("rings"))));
    shader::FilteredAsCxx shader(filtered_layers(table));
    for (const Lookup& at : random_lookups(table, 300)) {
        const auto r = shader.stratus_reflection(at.albedo, 1e9f, at.mu_in, at.mu_out, at.azimuth);
        const double expected =
            table.reflection(double{at.albedo}, infinity, at.geometry()).total();
        EXPECT_NEAR(double{r.single} + double{r.multiple}, expected, 4e-3 * expected);
    }
}

TEST(Shader, SharesFilteredLightAmongAlbedos) {
    shader::FilteredAsCxx shader(filtered_layers(PackedTable(pack(table_of(kind_of("rings"))))));
    const shader::vec3 wi{0.6f, 0, 0.8f};
    for (const float z : {0.5f, -0.5f}) {
        const shader::vec3 wo{0, std::sqrt(1 - z * z), z};
        shader.fetches = 0;
        const shader::vec3 all = shader.stratus_bsdf_rgb(wi, wo, {0.95f, 0.8f, 0.6f}, 1.5f);
        EXPECT_LE(shader.fetches, 24 + 3 * 3);
        EXPECT_EQ(all.x, shader.stratus_bsdf(wi, wo, 0.95f, 1.5f));
        EXPECT_EQ(all.y, shader.stratus_bsdf(wi, wo, 0.8f, 1.5f));
        EXPECT_EQ(all.z, shader.stratus_bsdf(wi, wo, 0.6f, 1.5f));
    }
}

TEST(Shader, HasFilteredLayersOfFewAzimuths) {
    for (const int azimuths : {2, 3, 4}) {
        Kind few = kind_of("rings");
        few.azimuths = azimuths;
        const PackedTable table(pack(table_of(few)));
        const FilteredLight layer = filtered_layer(table, make_medium(table));
        EXPECT_LE(layer.usual_error, 2e-3) << azimuths << " azimuths";
    }
}

struct DecimalComma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
};

TEST(Shader, WritesTheSameNumbersInEveryLocale) {
    const float texel[] = {0.5f, -1e-30f, 3.4e38f, 2};
    ShaderTexture numbers{"stratus_numbers", 1, false, std::vector<char>(sizeof texel)};
    std::memcpy(numbers.bytes.data(), texel, sizeof texel);
    FilteredLight light{};
    light.textures = {numbers, numbers, numbers};
    light.constant_numbers = 1;
    const std::string text = shader_text(ShaderLanguage::glsl, &light);
    EXPECT_NE(text.find("vec4(5.00000000e-01, -1.00000000e-30, "), text.npos);
    const std::locale before =
        std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
    const std::string elsewhere = shader_text(ShaderLanguage::glsl, &light);
    std::locale::global(before);
    EXPECT_EQ(elsewhere, text);
}

TEST(Shader, RefusesWhatItDoesNotRead) {
    const Table table = table_of(kind_of("rings"));
    const PackedTable mixture(pack(mixed(table, table)));
    expect_refusal(
        [&] { shader_textures(mixture); },
        "shader: TABLE must be of one phase function: table_at(), --at, got one of a family");
    const PackedTable narrowed(pack(table_of(kind_of("narrowed"))));
    expect_refusal(
        [&] { shader_layer(narrowed, three_layers); },
        "shader: TABLE must be one of all directions, which are sampled, got one narrowed");
    const PackedTable rings(pack(table_of(kind_of("rings"))));
    const FilteredLight layer = filtered_layer(rings, make_medium(rings));
    const PackedTable stack(pack(table_of(kind_of("stack"))));
    expect_refusal([&] { filtered_layers(stack); },
                   "shader: TABLE must be of one layer, whose depth and albedo vary, got a stack");
    expect_refusal([&] { shader_text(ShaderLanguage::osl, &layer); },
                   "shader: --filtered must be with glsl or hlsl, got osl");
    const PackedTable finite(pack(table_of(kind_of("finite"))));
    expect_refusal([&] { shader_layer(finite, {{100, 1, 1}, {1, 1, 1}}); }, "100");
}

#ifdef STRATUS_RUN_CHROMIUM
TEST(ShaderInABrowser, DrawsTheDirectionsOfABsdf) {
    const PackedTable table(pack(table_of(kind_of("rings"))));
    const RgbBsdf bsdf(RgbSlice(table.view(), make_medium(table)));
    const std::vector<Lookup> lookups = random_lookups(table, 1000);
    const std::vector<Light> found = by_browser(with_layer(table), lookups, R"glsl(
        vec3 wi = vec3(sqrt((1.0 - along.x) * (1.0 + along.x)), 0.0, along.x);
        StratusSample drawn = stratus_layer_sample(wi, along.y, along.z / 6.2831854, layer.x);
        light = vec4(drawn.wo.xz, drawn.pdf, stratus_layer_pdf(wi, drawn.wo));
    )glsl");
    std::vector<double> off;
    for (const auto n : indices(lookups)) {
        const Lookup& at = lookups[n];
        const auto expected = bsdf.sample({std::sqrt((1 - at.mu_in) * (1 + at.mu_in)), 0, at.mu_in},
                                          at.mu_out, at.azimuth / 6.2831854f, at.albedo);
        off.push_back(std::max({double{std::abs(found[n][0] - expected.wo.x)},
                                double{std::abs(found[n][1] - expected.wo.z)},
                                double{std::abs(found[n][2] / expected.pdf - 1)},
                                double{std::abs(found[n][3] / expected.pdf - 1)}}));
    }
    std::ranges::sort(off);
    EXPECT_LE(off[off.size() / 2], 1e-5);
    EXPECT_LE(off[off.size() * 99 / 100], 1e-3);
}

TEST(ShaderInABrowser, FiltersABoundLayer) {
    const PackedTable table(pack(table_of(kind_of("path_law"))));  // with a path law
    const FilteredLight layer = filtered_layer(table, make_medium(table));
    const std::vector<Lookup> lookups = random_lookups(table, 1000);
    const std::vector<Light> found = by_browser(layer.textures, lookups, R"glsl(
        StratusColours r = stratus_layer_reflection(along.x, along.y, along.z);
        StratusColours t = stratus_layer_transmission(along.x, along.y, along.z);
        light = vec4((r.single + r.multiple).xz, (t.single + t.multiple).xz);
    )glsl",
                                                &layer);
    EXPECT_LE(share_off(found, filtered_light(table, lookups)), 2e-3);
}

TEST(ShaderInABrowser, FiltersLayersOfAnyDepth) {
    const PackedTable table(pack(table_of(without_infinity(kind_of("path_law")))));
    const FilteredLight layers = filtered_layers(table);
    const std::vector<Lookup> lookups = random_lookups(table, 1000);
    const std::vector<Light> found = by_browser(layers.textures, lookups, both_sides, &layers);
    EXPECT_LE(share_off(totals(found), totals(by_runtime(table, lookups))), 2e-3);
}

class ShaderInABrowserOf : public testing::TestWithParam<Kind> {};

TEST_P(ShaderInABrowserOf, IsTheRuntime) {
    const PackedTable table(pack(table_of(GetParam())));
    const std::vector<Lookup> lookups = random_lookups(table, 2000);
    const std::vector<Light> found = by_browser(shader_textures(table), lookups);
    const Differences off = differences(found, by_runtime(table, lookups));
    EXPECT_LE(off.median, 1e-5);
    EXPECT_LE(off.worst, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ShaderInABrowserOf,
                         testing::ValuesIn(kinds_of({"rings", "path_law", "over_layer", "stack",
                                                     "stack_over_layer"})),
                         row_name);
#endif

}  // namespace
}  // namespace stratus::test
