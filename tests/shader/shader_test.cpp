#include <stratus/shader/shader.h>

#include <stratus/runtime/path_law.h>

#include "lookups.h"
#include "refusal.h"
#include "shader_as_cxx.h"
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

std::string name_of(const testing::TestParamInfo<Kind>& row) { return row.param.name; }

std::vector<Light> as_cxx(const PackedTable& table, const std::vector<Lookup>& lookups) {
    const shader::Textures textures(shader_textures(table));
    shader::bound = &textures;
    std::vector<Light> all;
    for (const auto& [w, tau, mu_in, mu_out, azimuth] : lookups) {
        const auto r = shader::stratus_reflection(w, tau, mu_in, mu_out, azimuth),
                   t = shader::stratus_transmission(w, tau, mu_in, mu_out, azimuth);
        all.push_back({r.single, r.multiple, t.single, t.multiple});
    }
    shader::bound = nullptr;
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

#ifdef STRATUS_RUN_CHROMIUM
class ShaderInABrowserOf : public testing::TestWithParam<Kind> {};

TEST_P(ShaderInABrowserOf, IsTheRuntime) {
    const PackedTable table(pack(table_of(GetParam())));
    const std::vector<Lookup> lookups = test::random_lookups(table, 10000);
    const std::vector<Light> found = test::by_browser(table, lookups);
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
