// Every lookup at not-a-number, infinities, zeros, the smallest number and others out of range, one
// argument at a time: it is not-a-number exactly where an argument is, else what it is at the
// argument's nearest value in range, and never negative.
#include <stratus/base/constants.h>
#include <stratus/bsdf/bsdf.h>
#include <stratus/bsdf/slice.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/phase/phase_function.h>
#include <stratus/table/lookup.h>
#include <stratus/table/packed_table.h>

#include "indices.h"
#include "instruction_sets.h"
#include "small_table.h"
#include "table/lookup_arguments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace stratus {
namespace {

constexpr double none = NAN;

constexpr double odd_numbers[] = {none, infinity, -infinity, -0.0, 0,     1e-40,
                                  -1,   -0.5,     1.5,       1e30, 5e-324};

/// An argument: its name and range. Beyond it, it counts as its nearer end; infinity where it has
/// none gives not-a-number.
struct Argument {
    const char* name;
    double low, high, usual;

    bool is_unknown_at(double x) const {
        return std::isnan(x) || (std::isinf(x) && high > 1e20 && low < 0);
    }
    double within(double x) const { return std::clamp(x, low, high); }
};

constexpr Argument albedo_argument{"albedo", 0, 1, 0.9};
constexpr Argument depth_argument{"optical_depth", 0, infinity, 0.7};
constexpr Argument in_argument{"mu_in", 0, 1, 0.6}, out_argument{"mu_out", 0, 1, 0.4};
constexpr Argument azimuth_argument{"azimuth", -infinity, infinity, 1.1};

using Arguments = std::vector<Argument>;
using Values = std::vector<double>;
using LookUp = std::function<Values(const Values&)>;

void expect_known(const Values& value, const Values& expected, const std::string& at) {
    ASSERT_EQ(value.size(), expected.size()) << at;
    for (const auto i : indices(value)) {
        ASSERT_FALSE(std::isnan(value[i])) << at;
        EXPECT_GE(value[i], 0) << at;
        if (std::isfinite(expected[i]))
            EXPECT_NEAR(value[i], expected[i], 3e-6 * std::abs(expected[i])) << at;
        else
            EXPECT_EQ(value[i], expected[i]) << at;
    }
}

/// One lookup, each argument in turn.
void expect_rule(const std::string& what, const Arguments& arguments, const LookUp& look_up) {
    Values usual;
    for (const Argument& argument : arguments) usual.push_back(argument.usual);
    for (const auto k : indices(arguments))
        for (const double odd : odd_numbers) {
            Values here = usual;
            here[k] = odd;
            const std::string at = what + " at " + arguments[k].name + " = " + std::to_string(odd);
            const Values value = look_up(here);
            if (arguments[k].is_unknown_at(odd)) {
                for (const double x : value) EXPECT_TRUE(std::isnan(x)) << at << ": " << x;
                continue;
            }
            here[k] = arguments[k].within(odd);
            expect_known(value, look_up(here), at);
        }
}

using LookUpMany = std::function<std::vector<float>(const std::vector<std::vector<float>>&)>;

/// Many at once, `channels` after one another: odd ones beside usual ones, which they leave alone.
void expect_rule_of_many(const std::string& what, const Arguments& arguments, int channels,
                         const LookUpMany& look_up) {
    constexpr std::size_t count = 45;
    std::vector<std::vector<float>> usual;
    for (const Argument& argument : arguments)
        usual.emplace_back(count, static_cast<float>(argument.usual));
    const std::vector<float> untouched = look_up(usual);
    for (const auto k : indices(arguments))
        for (const double odd : odd_numbers)
            for (const std::size_t place : {std::size_t{0}, std::size_t{7}, count - 1}) {
                auto here = usual, inside = usual;
                here[k][place] = static_cast<float>(odd);
                inside[k][place] = static_cast<float>(arguments[k].within(odd));
                const std::string at =
                    what + " at " + arguments[k].name + " = " + std::to_string(odd);
                const std::vector<float> value = look_up(here), expected = look_up(inside);
                for (std::size_t n = 0; n < count * static_cast<std::size_t>(channels); ++n)
                    if (n % count != place)
                        EXPECT_EQ(value[n], untouched[n]) << at << ", beside it at " << n;
                    else if (arguments[k].is_unknown_at(odd))
                        EXPECT_TRUE(std::isnan(value[n])) << at << ": " << value[n];
                    else
                        expect_known({value[n]}, {expected[n]}, at);
            }
}

Values of(float value) { return {value}; }
Values of(const Rgb& value) { return {value.r, value.g, value.b}; }
float in_float(double x) { return static_cast<float>(x); }

const Arguments angles = {in_argument, out_argument, azimuth_argument};
const Arguments all_five = {albedo_argument, depth_argument, in_argument, out_argument,
                            azimuth_argument};

template <int channels>
void expect_rule_of_slice(const std::string& name, const SliceOf<channels>& slice) {
    for (const Side side : both_sides) {
        const std::string what =
            name + (side == Side::reflection ? " reflection" : " transmission");
        expect_rule(what, angles, [&](const Values& x) {
            return of(slice.scattering(side, in_float(x[0]), in_float(x[1]), in_float(x[2])));
        });
        expect_rule_of_many(what + " of many", angles, channels, [&](const auto& x) {
            const std::size_t count = x[0].size();
            std::vector<float> value(channels * count);
            slice.scattering(side, count, x[0].data(), x[1].data(), x[2].data(), value.data());
            return value;
        });
    }
    for (const auto& [function, look_up] :
         {std::pair<const char*, LookUp>{
              "direct", [&](const Values& x) { return of(slice.direct(in_float(x[0]))); }},
          {"background", [&](const Values& x) { return of(slice.background(in_float(x[0]))); }},
          {"source_behind",
           [&](const Values& x) { return of(slice.source_behind(in_float(x[0]))); }}})
        expect_rule(name + " " + function, {in_argument}, look_up);
}

/// Not-a-number in a component of either vector, on both sides of the layer.
template <int channels>
void expect_rule_of_vectors(const std::string& name, const SliceOf<channels>& slice) {
    constexpr std::size_t count = 21;
    for (const float z_in : {0.8f, -0.8f})
        for (const float z_out : {0.6f, -0.6f, 0.0f})
            for (std::size_t k = 0; k < 7; ++k) {
                std::array<float, 6> w = {0.6f, 0, z_in, 0, -0.8f, z_out};
                if (k < 6) w[k] = in_float(none);
                const std::string at = name + " eval, unknown " + std::to_string(k);
                for (const double x : of(slice.eval({w[0], w[1], w[2]}, {w[3], w[4], w[5]})))
                    EXPECT_EQ(std::isnan(x), k < 6) << at;
                std::vector<std::vector<float>> all;
                for (std::size_t d = 0; d < 6; ++d) {
                    all.emplace_back(count, d == 2 ? 0.8f : d == 5 ? 0.6f : d % 3 == 0 ? 0.6f : 0);
                    all[d][5] = w[d];
                }
                const float* const wi[3] = {all[0].data(), all[1].data(), all[2].data()};
                const float* const wo[3] = {all[3].data(), all[4].data(), all[5].data()};
                std::vector<float> value(channels * count);
                slice.eval(count, wi, wo, value.data());
                for (const auto n : indices(value))
                    EXPECT_EQ(std::isnan(value[n]), k < 6 && n % count == 5) << at << " at " << n;
            }
}

TEST(OddArguments, KeepToTheRuleInSlices) {
    const Table with_azimuth = smooth_table(true), without = smooth_table(false);
    const Table ground = over(LowerBoundary::surface(0.5), smooth_table(true));
    Effects multiple, single, lit, opposed;
    multiple.single = false;
    single.multiple = false;
    lit.transmission = false;
    opposed.opposition = Opposition::blinn(0.1);
    const struct {
        const char* name;
        const Table* table;
        Effects effects;
    } rows[] = {{"all", &with_azimuth, {}},
                {"azimuth-free", &without, {}},
                {"multiple", &without, multiple},
                {"multiple, azimuth", &with_azimuth, multiple},
                {"single", &with_azimuth, single},
                {"single, isotropic", &without, single},
                {"one side", &with_azimuth, lit},
                {"opposition", &with_azimuth, opposed},
                {"ground", &ground, {}}};
    for (const InstructionSet set : instruction_sets) {
        const InstructionSetLimit limit(set);
        for (const auto& row : rows) {
            const std::string name = row.name + (" " + std::to_string(static_cast<int>(set)));
            const Slice one(row.table->view(), {{0.7}, {0.9}}, row.effects);
            const RgbSlice three(row.table->view(), {{0.3, 0.7, 2}, {0.9, 0.8, 0.5}}, row.effects);
            expect_rule_of_slice<1>(name, one);
            expect_rule_of_slice<3>(name + " rgb", three);
            expect_rule_of_vectors<1>(name, one);
            expect_rule_of_vectors<3>(name + " rgb", three);
        }
        const Slice none_at_all(PhaseFunction::isotropic(), {{0}, {0}});
        expect_rule_of_slice<1>("empty", none_at_all);
        const Slice sampled(PhaseFunction::lambert_sphere(), {{0.7}, {0.9}});
        expect_rule_of_slice<1>("sampled", sampled);
        expect_rule_of_vectors<1>("sampled", sampled);
        const Slice stack(
            std::vector<StackLayer>{{PhaseFunction::rayleigh(), 0.9, 0.2},
                                    {PhaseFunction::henyey_greenstein(0.5), 0.8, 0.3}},
            Effects{});
        expect_rule_of_slice<1>("stack", stack);
        expect_rule_of_vectors<1>("stack", stack);
    }
}

TEST(OddArguments, KeepToTheRuleInPathLaws) {
    Table table = smooth_table(true);
    table.phase_function = PhaseFunction::henyey_greenstein(0.95);
    table.path_law = PathOrders::of_any(table.phase_function);
    prepare(table);
    for (const InstructionSet set : instruction_sets) {
        const InstructionSetLimit limit(set);
        const Slice slice(table.view(), {{0.7}, {0.9}});
        expect_rule_of_slice<1>("path law", slice);
        expect_rule_of_vectors<1>("path law", slice);
    }
    expect_rule("path law in a table", all_five, [&](const Values& x) -> Values {
        const Geometry g{x[2], x[3], x[4]};
        return {reflection(table.view(), x[0], x[1], g).total(),
                transmission(table.view(), x[0], x[1], g).total()};
    });
}

TEST(OddArguments, KeepToTheRuleInTables) {
    for (const Table& table : {smooth_table(true), smooth_table(false),
                               over(LowerBoundary::surface(0.5), smooth_table(true)),
                               over(LowerBoundary::layer({}, 0.7), smooth_table(true))})
        expect_rule("table", all_five, [&](const Values& x) -> Values {
            const Geometry g{x[2], x[3], x[4]};
            const Scattered R = reflection(table.view(), x[0], x[1], g),
                            T = transmission(table.view(), x[0], x[1], g);
            return {R.single, R.multiple, T.single, T.multiple};
        });
}

TEST(OddArguments, KeepToTheRuleInPackedTables) {
    Table first = smooth_table(true), second = smooth_table(true);
    second.phase_function = PhaseFunction::rayleigh();
    const Table tables[] = {smooth_table(true), smooth_table(false),
                            over(LowerBoundary::surface(0.5), smooth_table(true)),
                            over(LowerBoundary::layer({}, 0.7), smooth_table(true)),
                            mixed(first, second)};
    for (const InstructionSet set : instruction_sets) {
        const InstructionSetLimit limit(set);
        int number = 0;
        for (const Table& table : tables) {
            const std::string name = "packed " + std::to_string(number++) + " of set " +
                                     std::to_string(static_cast<int>(set));
            const PackedTable packed(pack(table));
            Arguments arguments = all_five;
            if (table.has_family()) arguments.push_back({"mixture", 0, 1, 0.3});
            expect_rule(name, arguments, [&](const Values& x) -> Values {
                const Geometry g{x[2], x[3], x[4]};
                const double share = x.size() > 5 ? x[5] : 1;
                const Scattered R = packed.reflection(x[0], x[1], g, share),
                                T = packed.transmission(x[0], x[1], g, share);
                double three[3];
                packed.multiple(Side::reflection, {{x[0], x[0], x[0]}, {x[1], x[1], x[1]}}, g,
                                share, three);
                return {R.single, R.multiple, T.single, T.multiple, three[0], three[2]};
            });
            for (const Side side : both_sides)
                expect_rule_of_many(name, all_five, 1, [&](const auto& x) {
                    std::vector<float> total(x[0].size());
                    const PackedPoints points{x[0].data(), x[1].data(), x[2].data(),
                                              x[3].data(), x[4].data(), x[0].size()};
                    packed.scattering(side, points, total.data(), 0.3);
                    return total;
                });
        }
    }
}

TEST(OddArguments, StayNotANumberInClosedForms) {
    for (int k = 0; k < 5; ++k)
        for (const double depth : {0.5, infinity}) {
            double x[] = {0.8, 0.9, depth, 0.6, 0.4};
            x[k] = none;
            EXPECT_TRUE(std::isnan(single_reflection(x[0], x[1], x[2], x[3], x[4]))) << k;
            EXPECT_TRUE(std::isnan(single_transmission(x[0], x[1], x[2], x[3], x[4]))) << k;
            EXPECT_EQ(std::isnan(source_seen_through(x[0], x[1], x[2], x[3])), k < 4) << k;
        }
    EXPECT_TRUE(std::isnan(direct_transmittance(none, 1)));
    EXPECT_TRUE(std::isnan(intercepted_share(1, none)));
}

TEST(OddArguments, KeepToTheRuleInPhaseFunctions) {
    for (const char* const text :
         {"isotropic", "rayleigh", "anisotropic:x=1", "lambert_sphere", "henyey_greenstein:g=0.75",
          "henyey_greenstein:g=-0.75", "moments:chi=1 0.3 0.1",
          "mie:radius=1um,index=1.33,wavelength=0.5um", "0.5*rayleigh + 0.5*isotropic"}) {
        const PhaseFunction phase = parse_phase_function(text);
        expect_rule(text, {{"cosine", -1, 1, 0.3}},
                    [&](const Values& x) -> Values { return {phase(x[0])}; });
    }
    const PhaseFunction table = PhaseFunction::tabulated({0, 90, 180}, {1, 0.5, 2});
    expect_rule("tabulated", {{"cosine", -1, 1, 0.3}},
                [&](const Values& x) -> Values { return {table(x[0])}; });
}

TEST(OddArguments, KeepToTheRuleInBsdfs) {
    const Table table = smooth_table(true);
    const Bsdf bsdf(bind(table.view(), 0.7, 0.9));
    const RgbBsdf three(bind_rgb(table.view(), {0.3, 0.7, 2}, {0.9, 0.8, 0.5}));
    for (const Side side : both_sides)
        expect_rule("eval and pdf", angles, [&](const Values& x) -> Values {
            const float in = in_float(x[0]), out = in_float(x[1]), azimuth = in_float(x[2]);
            return {bsdf.eval(side, in, out, azimuth), bsdf.pdf(side, in, out, azimuth)};
        });
    expect_rule("albedo", {in_argument}, [&](const Values& x) -> Values {
        const auto shares = bsdf.albedo(in_float(x[0]));
        return {shares.reflected, shares.transmitted};
    });
    constexpr double below_one = 1 - 6e-8;
    const Argument random[] = {
        {"u1", 0, below_one, 0.2}, {"u2", 0, below_one, 0.7}, {"u3", 0, below_one, 0.4}};
    expect_rule("sample", {in_argument, random[0], random[1], random[2]},
                [&](const Values& x) -> Values {
                    const auto at =
                        bsdf.sample(in_float(x[0]), in_float(x[1]), in_float(x[2]), in_float(x[3]));
                    return {at.mu_out, std::abs(at.azimuth), at.value, at.pdf};
                });
    for (std::size_t k = 0; k < 7; ++k) {
        float x[6] = {0.6f, 0, 0.8f, 0.2f, 0.7f, 0.4f};
        if (k < 6) x[k] = in_float(none);
        const Vector wi{x[0], x[1], x[2]};
        const auto at = bsdf.sample(wi, x[3], x[4], x[5]);
        const auto of_three = three.sample(wi, x[3], x[4], x[5]);
        for (const float value : {at.wo.x, at.wo.y, at.wo.z, at.value, at.pdf, of_three.wo.x,
                                  of_three.value.g, of_three.pdf})
            EXPECT_EQ(std::isnan(value), k < 6) << k;
        for (const Vector& other : {Vector{0, 0.6f, 0.8f}, Vector{0, 0.6f, -0.8f}}) {
            EXPECT_EQ(std::isnan(bsdf.pdf(wi, other)), k < 3) << k;
            EXPECT_EQ(std::isnan(bsdf.pdf(other, wi)), k < 3) << k;
        }
        EXPECT_EQ(std::isnan(bsdf.albedo(wi).reflected), k < 3) << k;
        EXPECT_EQ(std::isnan(three.albedo(wi).transmitted.b), k < 3) << k;
    }
}

// What lookups refuse in a build with STRATUS_CHECKED; any other build tests the refusal by itself.

TEST(CheckedLookups, NameTheArgumentItsRangeAndTheValue) {
    EXPECT_DEATH(refuse_outside("mu_in", 0, 1, -0.5), "mu_in must be in \\[0, 1\\], got -0.5");
    EXPECT_DEATH(refuse_outside("mu_in", 0, 1, double{NAN}), "mu_in .* got -?nan");
    refuse_outside("mu_in", 0, 1, 0);
    refuse_outside("optical_depth", 0, infinity, infinity);
}

TEST(CheckedLookups, EndAtWhatIsOutOfRange) {
    if (!lookups_are_checked) GTEST_SKIP() << "a build without STRATUS_CHECKED";
    const Table table = smooth_table(true);
    const Geometry level{0.5, 0.5, 0};
    const PackedTable packed(pack(table));
    const Bsdf bsdf(bind(table.view(), 0.7, 0.9));
    const Slice& slice = bsdf.slice();
    const Vector up{0, 0, 1}, longer{3, 0, 4};
    const float one = 1, low = -0.5f, nan = NAN;
    float value;
    EXPECT_DEATH(reflection(table.view(), -1, 1, level), "albedo must be in \\[0, 1\\], got -1");
    EXPECT_DEATH(packed.transmission(0.5, -1, level), "optical_depth .* got -1");
    EXPECT_DEATH(packed.reflection({&one, &one, &one, &low, &one, 1}, &value),
                 "mu_out .* got -0.5");
    EXPECT_DEATH(slice.reflection(1, low, 0), "mu_out .* got -0.5");
    EXPECT_DEATH(slice.transmission(1, &one, &one, &nan, &value), "azimuth .* got -?nan");
    EXPECT_DEATH(slice.eval(longer, up), "length of wi must be in .* got 5");
    EXPECT_DEATH(bsdf.pdf(up, longer), "length of wo must be in .* got 5");
    EXPECT_DEATH(bsdf.sample(up, 0, 2, 0), "u2 must be in \\[0, 1\\], got 2");
    EXPECT_DEATH(slice.direct(2), "mu must be in \\[0, 1\\], got 2");
}

}  // namespace
}  // namespace stratus
