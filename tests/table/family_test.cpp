// Families of phase functions: axes over their parameters, and tables seen at one point of them.
#include <stratus/bsdf/slice.h>
#include <stratus/phase/phase_family.h>
#include <stratus/table/lookup.h>
#include <stratus/table/member_and_ground.h>
#include <stratus/table/packed_table.h>

#include "indices.h"
#include "refusal.h"
#include "small_table.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

FamilyAxis range_of(PhaseParameter parameter, double low, double high, int count) {
    return {parameter, make_axis(parameter_scale(parameter), low, high, count), false};
}

/// A level that a cubic in -log2(1 - g) follows exactly, g that of the phase function.
double level_of(const PhaseFunction& phase_function) {
    const double x = -std::log2(1 - phase_function.asymmetry());
    return 1 + 0.4 * x - 0.1 * x * x;
}

/// Tables of `axes` whose members differ in their level alone.
Table family_table(const std::vector<FamilyAxis>& axes, const PhaseFunction& first,
                   const PhaseFunction& second = {}) {
    Table table = empty_table({4, 4, 4, 4, 4}, {0.25, 8, true}), one = table;
    table.phase_function = first;
    table.second_phase_function = second;
    table.family = axes;
    table.diffusion_exponent.clear();
    for (std::size_t m = 0; m < table.member_count(); ++m) {
        const double level = level_of(phase_function_at(first, second, axes, member_at(axes, m)));
        fill(one, [level](const SamplePoint&) { return level; });
        append_members(table, one);
        table.extrapolation_lengths.push_back(small_table_length);
    }
    table.tolerance = 1e-3;
    prepare(table);
    return table;
}

Table lobes() {
    return family_table({range_of(PhaseParameter::g, 0.2, 0.9, 5)},
                        PhaseFunction::henyey_greenstein(0.5));
}

constexpr double family_rounding = 2e-6;  // samples are floats

TEST(Family, OfGIsTheTableOfThatG) {
    const Table table = lobes();
    for (const double g : {0.2, 0.37, 0.85, 0.9}) {
        const PhaseFunction phase_function = PhaseFunction::henyey_greenstein(g);
        const TableView view = table.view().at({g});
        for (const double depth : {0.05, 0.9, 8.0, 20.0, infinity})
            for (const Geometry& at : three_geometries) {
                const double growth = thin_line(table, depth);
                const double scale = growth * level_of(phase_function) *
                                     small_table_scale(Side::reflection, {0.9, depth, at.mu_in,
                                                                          at.mu_out, at.azimuth});
                const Scattered found = reflection(view, 0.9, depth, at);
                EXPECT_NEAR(found.multiple, scale, (depth > 8 ? 1e-3 : family_rounding) * scale);
                EXPECT_EQ(found.single,
                          single_reflection(phase_function(cos_scattering_angle_reflected(at)), 0.9,
                                            depth, at.mu_in, at.mu_out));
            }
    }
}

TEST(Family, IsBoundByItsValues) {
    const Table table = lobes();
    const Slice slice = bind(table.view(), 0.9, 0.9, {0.6});
    for (const Geometry& at : three_geometries) {
        const double R = reflection(table.view().at({0.6}), 0.9, 0.9, at).total();
        EXPECT_NEAR(value_of(slice, Side::reflection, at), R, 2e-3 * R);
    }
}

TEST(Family, OfTwoAxesIsTheirProduct) {
    const std::vector<FamilyAxis> axes{
        range_of(PhaseParameter::mixture, 0, 1, 2),
        {PhaseParameter::g, {AxisScale::linear, {0.3, 0.5, 0.8}}, true}};
    const PhaseFunction lobe = PhaseFunction::henyey_greenstein(0.5), even;
    const Table table = family_table(axes, lobe, even);
    for (const double g : {0.3, 0.5, 0.8})
        for (const double share : {0.0, 0.25, 1.0}) {
            const TableView view = table.view().at({share, g});
            const PhaseFunction full = PhaseFunction::henyey_greenstein(g);
            const double level = share * level_of(full) + (1 - share) * level_of(even);
            const Geometry at = three_geometries[0];
            const double expected =
                level *
                small_table_scale(Side::reflection, {0.9, 1, at.mu_in, at.mu_out, at.azimuth});
            const Scattered found = reflection(view, 0.9, 1, at);
            EXPECT_NEAR(found.multiple, expected, family_rounding * expected);
            const double phase = PhaseFunction::mixture(share, full, even)(0.3);
            EXPECT_NEAR(view.phase(0.3), phase, 1e-14 * phase);
        }
    expect_refusal([&] { table.view().at({0.5, 0.4}); }, "at: g must be one of 0.3, 0.5, 0.8");
}

/// Lookups at a point against those of the table of its own there, at samples of layers.
void expect_same_at(const Table& table, const FamilyPoint& point) {
    const TableView view = table.view().at(point);
    const Table one = table_at(table, point);
    EXPECT_FALSE(one.has_family());
    EXPECT_EQ(one.phase_function.text(), view.chosen_phase_function().text());
    for (const double w : table.albedo.values)
        for (const double depth : table.optical_depth.values)
            for (const Geometry& at : three_geometries)
                for (const auto look_up : {reflection, transmission}) {
                    const Scattered expected = look_up(view, w, depth, at),
                                    found = look_up(one.view(), w, depth, at);
                    EXPECT_NEAR(found.multiple, expected.multiple,
                                family_rounding * expected.multiple);
                    EXPECT_NEAR(found.single, expected.single, family_rounding * expected.single);
                }
}

TEST(Family, HasATableOfItsOwnAtEveryPoint) {
    Table table = lobes();
    const std::size_t albedos = table.albedo.values.size();
    for (const auto n : indices(table.diffusion_exponent))  // T falls unlike in members
        table.diffusion_exponent[n] *= 1 - 0.1 * static_cast<double>(n / albedos);
    prepare(table);
    for (const double g : {0.2, 0.37, 0.9}) expect_same_at(table, {g});
    for (const double g : {0.1, 0.91})
        expect_refusal([&] { table_at(table, {g}); }, "table_at: g must be in [0.2, 0.9]");
    expect_refusal([&] { table_at(table, {}); },
                   "at: values of parameters must be 1, one for each axis of the family, got 0");
    const Table two =
        family_table({range_of(PhaseParameter::mixture, 0, 1, 2),
                      {PhaseParameter::g, {AxisScale::linear, {0.3, 0.5, 0.8}}, true}},
                     PhaseFunction::henyey_greenstein(0.5), {});
    expect_same_at(two, {0.25, 0.5});
    const Table one = table_at(table, {0.5});
    EXPECT_EQ(table_at(one, {}).reflection_multiple, one.reflection_multiple);
}

TEST(Family, TellsTheValuesOfItsParameters) {
    const auto of = [](const char* text, PhaseParameter parameter) {
        return find_parameter(parse_phase_function(text), parameter);
    };
    EXPECT_EQ(of("0.5*isotropic + 0.5*henyey_greenstein:g=0.4", PhaseParameter::g), 0.4);
    const char* const droplets = "mie:radius=3um,variance=0.2,wavelength=650nm";
    EXPECT_EQ(of(droplets, PhaseParameter::radius), 3);
    EXPECT_EQ(of(droplets, PhaseParameter::variance), 0.2);
    EXPECT_EQ(of(droplets, PhaseParameter::wavelength), 0.65);
    EXPECT_FALSE(of(droplets, PhaseParameter::g));
    EXPECT_FALSE(of("isotropic", PhaseParameter::radius));
    EXPECT_FALSE(
        of("0.5*henyey_greenstein:g=0.1 + 0.5*henyey_greenstein:g=0.4", PhaseParameter::g));
}

TEST(Family, PackedIsThatOfItsTable) {
    const Table table = lobes();
    const PackedTable packed(pack(table));
    EXPECT_EQ(packed.header().family.size(), 1u);
    EXPECT_EQ(packed.header().extrapolation_lengths, table.extrapolation_lengths);
    for (const double g : {0.2, 0.6})
        for (const Geometry& at : three_geometries) {
            const Scattered expected = reflection(table.view().at({g}), 0.9, 1, at),
                            found = reflection(packed.view().at({g}), 0.9, 1, at);
            EXPECT_NEAR(found.multiple, expected.multiple, 4e-4 * expected.total());
            EXPECT_EQ(found.single, expected.single);
            const Slice slice = bind(packed.view(), 1, 0.9, {g});
            EXPECT_NEAR(value_of(slice, Side::reflection, at), expected.total(),
                        2e-3 * expected.total());
        }
    EXPECT_TRUE(std::isnan(packed.reflection(0.9, 1, three_geometries[0]).total()));
}

TEST(Family, RefusesWhatItDoesNotHold) {
    const Table table = lobes();
    expect_refusal([&] { bind(table.view(), 1, 0.9, {0.95}); },
                   "bind: g must be in [0.2, 0.9] of the table, got 0.95");
    EXPECT_TRUE(bind(table.view(), 1, 0.9, {0.95}, {}, OutsideTable::clamp).clamped());
    expect_refusal(
        [&] {
            table.view().at({0.5, 0.5});
        },
        "at: values of parameters must be 1, one for each axis of the family, got 2");
    expect_refusal([&] { table.view().at({}); },
                   "at: values of parameters must be 1, one for each axis of the family, got 0");
    expect_refusal([&] { table.view().at({1.5}); },
                   "henyey_greenstein: g must be in (-1, 1), got 1.5");
    expect_refusal(
        [&] {
            empty_table({4, 4, 4, 4, 4}, {0.25, 8, true}).view().at({0.5});
        },
        "at: values of parameters must be 0, one for each axis of the family, got 1");
}

TEST(Family, SetsTheOneTermThatHasTheParameter) {
    const PhaseFunction sum = parse_phase_function("0.25*isotropic + 0.75*henyey_greenstein:g=0.5");
    EXPECT_EQ(with_parameter(sum, PhaseParameter::g, 0.25).text(),
              "0.25*isotropic + 0.75*henyey_greenstein:g=0.25");
    const PhaseFunction drops = parse_phase_function("mie:radius=10um,variance=0.1");
    EXPECT_EQ(with_parameter(drops, PhaseParameter::radius, 4).text(),
              parse_phase_function("mie:radius=4um,variance=0.1").text());
    EXPECT_EQ(with_parameter(drops, PhaseParameter::wavelength, 0.65).text(),
              parse_phase_function("mie:radius=10um,variance=0.1,wavelength=650nm").text());
    expect_refusal([&] { with_parameter(drops, PhaseParameter::g, 0.5); },
                   "family: g must be of a phase function with one henyey_greenstein, got mie");
    expect_refusal(
        [&] {
            with_parameter(
                parse_phase_function("0.5*henyey_greenstein:g=0.5 + 0.5*henyey_greenstein:g=-0.5"),
                PhaseParameter::g, 0.5);
        },
        "family: g must be of a phase function with one henyey_greenstein");
    expect_refusal([&] { with_parameter(drops, PhaseParameter::radius, -1); },
                   "mie: radius (um) must be above 0 and finite, got -1");
}

TEST(Family, RefusesAxesThatAreNone) {
    const auto refuse = [](std::vector<FamilyAxis> axes, const Fragments& parts) {
        Table table = lobes();
        table.family = std::move(axes);
        expect_refusal([&] { prepare(table); }, parts);
    };
    const FamilyAxis g = range_of(PhaseParameter::g, 0.2, 0.9, 5);
    refuse({g, g}, "prepare: family must be of axes that differ");
    refuse({g, g, g}, "prepare: family must be of one or two");
    refuse({{PhaseParameter::g, {AxisScale::linear, {0.2, 0.4}}, false}},
           "scale of axis g must be logarithm_of_complement, got linear");
    refuse({{PhaseParameter::g, {AxisScale::linear, {0.2, 0.1}}, true}},
           "g must be finite and ascending, got 0.1");
    refuse({range_of(PhaseParameter::radius, 4, 20, 5)},
           "radius must be of a phase function with one mie");
    refuse({range_of(PhaseParameter::g, 0.2, 0.9, 4)},
           "extrapolation_lengths must be as many as members, 4, got 5");
}

}  // namespace
}  // namespace stratus
