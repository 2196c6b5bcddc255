// The C interface beside the C++ one: the same bits, and every refusal in words.
#include <stratus/stratus.h>

#include <stratus/base/constants.h>
#include <stratus/bsdf/bsdf.h>
#include <stratus/bsdf/slice.h>
#include <stratus/io/table_file.h>
#include <stratus/table/lookup.h>

#include "indices.h"
#include "../io/temporary_folder.h"
#include "../picture/synthetic_table.h"
#include "expect_refused.h"
#include "refusal.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace stratus::test {
namespace {

using BoundSlice = std::unique_ptr<stratus_slice, decltype(&stratus_slice_free)>;

stratus_effects default_effects() {
    stratus_effects effects{};
    effects.size = sizeof effects;
    check_ok(stratus_effects_default(&effects));
    return effects;
}

/// Directions over both hemispheres, as arrays of x, y and z.
struct Directions {
    std::vector<float> x, y, z;

    explicit Directions(std::size_t count, unsigned seed) : x(count), y(count), z(count) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<float> cosine(-1, 1), angle(0, 6.2831853f);
        for (std::size_t i = 0; i < count; ++i) {
            z[i] = cosine(random);
            const float sine = std::sqrt(1 - z[i] * z[i]), around = angle(random);
            x[i] = sine * std::cos(around);
            y[i] = sine * std::sin(around);
        }
    }
    std::array<const float*, 3> arrays() const { return {x.data(), y.data(), z.data()}; }
    std::array<float, 3> at(std::size_t i) const { return {x[i], y[i], z[i]}; }
};

class C : public testing::Test {
  protected:
    C() {
        SyntheticOptions options;
        options.and_infinity = true;
        table_ = make_synthetic_table(options);
        const std::string path = (folder_.path() / "table.h5").string();
        write_table(table_, path);
        check_ok(stratus_table_open(path.c_str(), &handle_));
    }
    ~C() override { stratus_table_close(handle_); }

    BoundSlice bind(int channels, const double* depths, const double* albedos,
                    const stratus_effects* effects = nullptr) {
        stratus_slice* slice = nullptr;
        check_ok(stratus_slice_bind(handle_, channels, depths, albedos, effects, &slice));
        return {slice, &stratus_slice_free};
    }

    TemporaryFolder folder_;
    Table table_;
    stratus_table* handle_ = nullptr;
};

TEST_F(C, DescribesTheTable) {
    const stratus_table_info info = described(handle_);
    EXPECT_EQ(info.optical_depth.lowest, 0.01);
    EXPECT_EQ(info.optical_depth.highest, infinity);
    EXPECT_EQ(info.optical_depth.samples, 12u);
    EXPECT_EQ(info.albedo.lowest, 0);
    EXPECT_EQ(info.albedo.highest, 1);
    EXPECT_EQ(info.mu_in.samples, 8u);
    EXPECT_EQ(info.azimuth.samples, 5u);
    EXPECT_EQ(info.has_reflection, 1);
    EXPECT_EQ(info.has_transmission, 1);
    EXPECT_EQ(info.has_lower_boundary, 0);
    EXPECT_EQ(info.tolerance, 1e-3);
    EXPECT_EQ(info.measured_error, 8.1e-4);
    EXPECT_EQ(info.mixture.samples, 0u);
    EXPECT_EQ(info.is_packed, 0);
    EXPECT_EQ(info.is_stack, 0);
    EXPECT_EQ(stratus_table_text(handle_, "phase_function"), table_.phase_function.text());
    EXPECT_EQ(stratus_table_text(handle_, "title"), table_.attributes["title"]);
    EXPECT_EQ(stratus_table_text(handle_, "absent"), nullptr);
}

TEST_F(C, LooksUpTablesToTheBitsOfCpp) {
    const double none = NAN;  // and others out of range
    const std::vector<stratus_point> points = {
        {1.5, 0.9, 0.5, 0.8, 1},   {infinity, 1, 0.01, 1, 3}, {0.001, 0.5, 0.3, 0.3, 0},
        {-1, infinity, -1, 2, 20}, {none, 0.9, 0.5, 0.8, 1},  {1.5, none, 0.5, 0.8, 1},
        {1.5, 0.9, none, 0.8, 1},  {1.5, 0.9, 0.5, none, 1},  {1.5, 0.9, 0.5, 0.8, infinity}};
    const auto expect_same = [](double found, double expected) {
        if (std::isnan(expected))
            EXPECT_TRUE(std::isnan(found));
        else
            EXPECT_EQ(found, expected);
    };
    for (const Side side : both_sides) {
        const auto look_up =
            side == Side::reflection ? stratus_table_reflection : stratus_table_transmission;
        std::vector<stratus_scattered> light(points.size());
        check_ok(look_up(handle_, points.size(), points.data(), light.data()));
        for (const auto i : indices(points)) {
            const stratus_point& at = points[i];
            const Scattered expected = scattering(table_.view(), side, at.albedo, at.optical_depth,
                                                  {at.mu_in, at.mu_out, at.azimuth});
            expect_same(light[i].single, expected.single);
            expect_same(light[i].multiple, expected.multiple);
        }
    }
}

TEST_F(C, TakesOppositionFromTheDensity) {
    stratus_effects effects = default_effects();
    effects.multiple = 0;
    effects.density = 0.2;
    effects.opposition = STRATUS_BLINN_OPPOSITION;
    const double depth = 0.5, albedo = 0.7;
    const BoundSlice one = bind(1, &depth, &albedo, &effects);
    const Slice cpp =
        stratus::bind(table_.view(), depth, albedo,
                      {.multiple = false, .density = 0.2, .opposition = Opposition::blinn()});
    float met = 0;
    check_ok(stratus_slice_reflection(one.get(), 0.5f, 0.6f, 3.0f, &met));
    EXPECT_EQ(met, cpp.reflection(0.5f, 0.6f, 3.0f));
}

TEST_F(C, BindsToTheBitsOfCpp) {
    stratus_effects effects = default_effects();
    effects.density = 0.2;
    effects.opposition = STRATUS_HAPKE_OPPOSITION;
    effects.opposition_width = 0.1;
    effects.opposition_amplitude = 0.5;
    Effects same;
    same.density = 0.2;
    same.opposition = Opposition::hapke(0.5, 0.1);
    const double depths[3] = {0.5, 1, 2}, albedos[3] = {0.7, 0.8, 0.9};
    const BoundSlice one = bind(1, depths, albedos, &effects),
                     three = bind(3, depths, albedos, &effects);
    const Slice cpp_one = stratus::bind(table_.view(), depths[0], albedos[0], same);
    const RgbSlice cpp_three = bind_rgb(table_.view(), depths, albedos, same);
    EXPECT_EQ(stratus_slice_channels(one.get()), 1);
    EXPECT_EQ(stratus_slice_channels(three.get()), 3);
    EXPECT_EQ(stratus_slice_bytes(one.get()), cpp_one.bytes());
    EXPECT_EQ(stratus_slice_bytes(three.get()), cpp_three.bytes());

    const auto expect_rgb = [](const float(&met)[3], const Rgb& expected) {
        EXPECT_EQ(met[0], expected.r);
        EXPECT_EQ(met[1], expected.g);
        EXPECT_EQ(met[2], expected.b);
    };
    float value[3];
    check_ok(stratus_slice_reflection(one.get(), 0.4f, 0.7f, 1, value));
    EXPECT_EQ(value[0], cpp_one.reflection(0.4f, 0.7f, 1));
    check_ok(stratus_slice_reflection(three.get(), 0.4f, 0.7f, 1, value));
    expect_rgb(value, cpp_three.reflection(0.4f, 0.7f, 1));
    check_ok(stratus_slice_transmission(three.get(), 0.4f, 0.7f, 1, value));
    expect_rgb(value, cpp_three.transmission(0.4f, 0.7f, 1));
    check_ok(stratus_slice_direct(three.get(), 0.4f, value));
    expect_rgb(value, cpp_three.direct(0.4f));
    check_ok(stratus_slice_background(three.get(), 0.4f, value));
    expect_rgb(value, cpp_three.background(0.4f));
    check_ok(stratus_slice_source_behind(three.get(), 0.4f, value));
    expect_rgb(value, cpp_three.source_behind(0.4f));

    constexpr std::size_t count = 50;
    const Directions wi(count, 1), wo(count, 2);
    for (std::size_t i = 0; i < count; ++i) {
        const auto in = wi.at(i), out = wo.at(i);
        check_ok(stratus_slice_eval(three.get(), in.data(), out.data(), value));
        expect_rgb(value, cpp_three.eval({in[0], in[1], in[2]}, {out[0], out[1], out[2]}));
    }
    std::vector<float> met(3 * count), expected(3 * count);
    check_ok(stratus_slice_eval_many(three.get(), count, wi.arrays().data(), wo.arrays().data(),
                                     met.data()));
    cpp_three.eval(count, wi.arrays().data(), wo.arrays().data(), expected.data());
    EXPECT_EQ(met, expected);

    const std::vector<float> mu(count, 0.3f), azimuth(count, 2.0f);
    met.assign(count, 0);
    expected.assign(count, 0);
    for (const Side side : both_sides) {
        const auto scatter_many = side == Side::reflection ? stratus_slice_reflection_many
                                                           : stratus_slice_transmission_many;
        check_ok(scatter_many(one.get(), count, mu.data(), mu.data(), azimuth.data(), met.data()));
        cpp_one.scattering(side, count, mu.data(), mu.data(), azimuth.data(), expected.data());
        EXPECT_EQ(met, expected);
    }
}

TEST_F(C, RefusesLayersThatTheTableDoesNotKnowOrClampsThem) {
    SyntheticOptions options;
    options.and_infinity = false;
    const std::string path = (folder_.path() / "finite.h5").string();
    write_table(make_synthetic_table(options), path);
    stratus_table* finite = nullptr;
    check_ok(stratus_table_open(path.c_str(), &finite));
    const double depth = infinity, albedo = 1;
    stratus_slice* slice = nullptr;
    expect_refused(stratus_slice_bind(finite, 1, &depth, &albedo, nullptr, &slice),
                   "optical_depth");
    EXPECT_EQ(slice, nullptr);
    check_ok(stratus_slice_bind_clamped(finite, 1, &depth, &albedo, nullptr, &slice));
    EXPECT_EQ(stratus_slice_clamped(slice), 1);
    stratus_slice_free(slice);
    const double thin = 0.5;
    check_ok(stratus_slice_bind_clamped(finite, 1, &thin, &albedo, nullptr, &slice));
    EXPECT_EQ(stratus_slice_clamped(slice), 0);
    EXPECT_EQ(stratus_slice_clamped(nullptr), 0);
    stratus_slice_free(slice);
    stratus_table_close(finite);
}

TEST_F(C, AsksForEachEffectAlone) {
    const double depth = 1, albedo = 0.9;
    const auto side_sums = [&](int stratus_effects::*off) {
        stratus_effects effects = default_effects();
        effects.*off = 0;
        const BoundSlice slice = bind(1, &depth, &albedo, &effects);
        std::array<float, 2> sides{};
        stratus_slice_reflection(slice.get(), 0.5f, 0.5f, 0, &sides[0]);
        stratus_slice_transmission(slice.get(), 0.5f, 0.5f, 0, &sides[1]);
        return sides;
    };
    const auto orders_1 = side_sums(&stratus_effects::multiple);
    const auto orders_2 = side_sums(&stratus_effects::single);
    const auto without_r = side_sums(&stratus_effects::reflection);
    const auto without_t = side_sums(&stratus_effects::transmission);
    EXPECT_EQ(without_r[0], 0);
    EXPECT_EQ(without_t[1], 0);
    // A quarter of the table's tolerance: what is asked for decides how finely a slice is sampled.
    EXPECT_NEAR((orders_1[0] + orders_2[0]) / without_t[0], 1, 2.5e-4);
    EXPECT_NEAR((orders_1[1] + orders_2[1]) / without_r[1], 1, 2.5e-4);
    EXPECT_GT(orders_1[0], 0);
    EXPECT_GT(orders_2[0], 0);
}

TEST_F(C, DrawsToTheBitsOfCpp) {
    const double depths[3] = {0.5, 1, 2}, albedos[3] = {0.7, 0.8, 0.9};
    const Bsdf cpp_one(stratus::bind(table_.view(), depths[0], albedos[0]));
    const RgbBsdf cpp_three(bind_rgb(table_.view(), depths, albedos));
    stratus_bsdf *one = nullptr, *three = nullptr;
    stratus_slice* slice = bind(1, depths, albedos).release();
    check_ok(stratus_bsdf_build(&slice, &one));
    EXPECT_EQ(slice, nullptr);
    slice = bind(3, depths, albedos).release();
    check_ok(stratus_bsdf_build(&slice, &three));
    EXPECT_EQ(stratus_slice_channels(stratus_bsdf_slice(one)), 1);
    EXPECT_EQ(stratus_slice_channels(stratus_bsdf_slice(three)), 3);
    EXPECT_EQ(stratus_bsdf_bytes(three), cpp_three.bytes());

    const float wi[3] = {0.6f, 0, 0.8f}, random[3] = {0.3f, 0.7f, 0.2f};
    const Vector in{wi[0], wi[1], wi[2]};
    float wo[3], value[3], pdf = 0, same = 0, other[3];
    check_ok(stratus_bsdf_sample(one, wi, random, wo, value, &pdf));
    const Bsdf::Sample drawn = cpp_one.sample(in, random[0], random[1], random[2]);
    EXPECT_EQ(wo[0], drawn.wo.x);
    EXPECT_EQ(wo[1], drawn.wo.y);
    EXPECT_EQ(wo[2], drawn.wo.z);
    EXPECT_EQ(value[0], drawn.value);
    EXPECT_EQ(pdf, drawn.pdf);
    check_ok(stratus_bsdf_sample(three, wi, random, wo, value, &pdf));
    const RgbBsdf::Sample coloured = cpp_three.sample(in, random[0], random[1], random[2]);
    EXPECT_EQ(wo[2], coloured.wo.z);
    EXPECT_EQ(value[0], coloured.value.r);
    EXPECT_EQ(value[2], coloured.value.b);
    check_ok(stratus_bsdf_pdf(three, wi, wo, &same));
    EXPECT_EQ(same, cpp_three.pdf(in, coloured.wo));
    check_ok(stratus_slice_eval(stratus_bsdf_slice(three), wi, wo, other));
    EXPECT_EQ(other[1], cpp_three.eval(in, coloured.wo).g);
    check_ok(stratus_bsdf_albedo(three, wi, value, other));
    EXPECT_EQ(value[1], cpp_three.albedo(in).reflected.g);
    EXPECT_EQ(other[1], cpp_three.albedo(in).transmitted.g);

    expect_refused(stratus_bsdf_sample(nullptr, wi, random, wo, value, &pdf), "bsdf");
    expect_refused(stratus_bsdf_sample(one, wi, nullptr, wo, value, &pdf), "random");
    expect_refused(stratus_bsdf_sample(one, wi, random, wo, value, nullptr), "pdf");
    expect_refused(stratus_bsdf_pdf(one, wi, nullptr, &pdf), "wo");
    expect_refused(stratus_bsdf_albedo(one, wi, value, nullptr), "transmitted");
    stratus_bsdf_free(one);
    stratus_bsdf_free(three);
    expect_refused(stratus_bsdf_build(&slice, &one), "*slice must be given, got null");
    EXPECT_EQ(one, nullptr);
    EXPECT_EQ(stratus_bsdf_slice(nullptr), nullptr);
    EXPECT_EQ(stratus_bsdf_bytes(nullptr), 0u);
    stratus_bsdf_free(nullptr);
}

TEST(CDirections, AreThoseOfObservedAngles) {
    double mu_in = 0, mu_out = 0, azimuth = 0;
    int transmitted = 0;
    const auto seen = [&](double i, double e, double g) {
        return stratus_observed_direction(i, e, g, &mu_in, &mu_out, &azimuth, &transmitted);
    };
    check_ok(seen(60, 60, 0));
    EXPECT_NEAR(mu_in, 0.5, 1e-15);
    EXPECT_NEAR(azimuth, pi, 1e-15);
    EXPECT_EQ(transmitted, 0);
    check_ok(seen(0, 120, 120));
    EXPECT_NEAR(mu_out, 0.5, 1e-15);
    EXPECT_EQ(transmitted, 1);
    expect_refused(seen(60, 60, 121), "stratus_observed_direction: phase_deg must be in [0, 120]");
    expect_refused(stratus_observed_direction(0, 0, 0, &mu_in, &mu_out, nullptr, &transmitted),
                   "azimuth must be given");
}

TEST(CSingle, NeedsNoTable) {
    const double depth = 2, albedo = 0.8;
    stratus_slice* slice = nullptr;
    check_ok(
        stratus_slice_bind_single("henyey_greenstein:g=0.85", 1, &depth, &albedo, nullptr, &slice));
    const Slice same(PhaseFunction::henyey_greenstein(0.85), {{depth}, {albedo}});
    float value = 0;
    check_ok(stratus_slice_reflection(slice, 0.5f, 1, 0, &value));
    EXPECT_EQ(value, same.reflection(0.5f, 1, 0));
    check_ok(stratus_slice_background(slice, 1, &value));
    EXPECT_EQ(value, same.background(1));
    check_ok(stratus_slice_source_behind(slice, 1, &value));
    EXPECT_EQ(value, same.source_behind(1));
    stratus_slice_free(slice);
}

TEST_F(C, RefusesFilesThatAreNoTables) {
    stratus_table* table = handle_;
    expect_refused(stratus_table_open("absent.h5", &table), "absent.h5", STRATUS_FAILED);
    EXPECT_EQ(table, nullptr);
    expect_refused(stratus_table_open("table.txt", &table), ".exr");
    expect_refused(stratus_table_open(nullptr, &table),
                   "stratus_table_open: path must be given, got null");
    expect_refused(stratus_table_open("a.h5", nullptr), "table");
}

TEST_F(C, RefusesSizesOfAnotherVersion) {
    stratus_table_info info{};
    expect_refused(stratus_table_describe(handle_, &info),
                   "stratus_table_describe: info.size must be 160 or " +
                       std::to_string(sizeof info) + ", got 0");
    stratus_effects effects = default_effects();
    effects.size += 1;
    expect_refused(stratus_effects_default(&effects), "effects.size");
    const double one = 1;
    stratus_slice* slice = nullptr;
    expect_refused(stratus_slice_bind(handle_, 1, &one, &one, &effects, &slice),
                   "stratus_slice_bind: effects.size");
}

// Their structs end before `mixture` and `background`.
TEST_F(C, ServesProgramsBuiltAgainstTheFirstHeader) {
    stratus_table_info info{};
    info.size = 160;
    info.mixture.samples = 77;
    info.is_stack = 88;
    check_ok(stratus_table_describe(handle_, &info));
    EXPECT_EQ(info.size, 160u);
    EXPECT_EQ(info.measured_error, 8.1e-4);
    EXPECT_EQ(info.mixture.samples, 77u);
    EXPECT_EQ(info.is_stack, 88);
    stratus_effects effects{};
    effects.size = 56;
    effects.background = 99;
    check_ok(stratus_effects_default(&effects));
    EXPECT_EQ(effects.single, 1);
    EXPECT_EQ(effects.background, 99);
    const double depth = 1, albedo = 0.8;
    const BoundSlice old = bind(1, &depth, &albedo, &effects), usual = bind(1, &depth, &albedo);
    effects = default_effects();
    effects.background = 0;
    const BoundSlice beam_alone = bind(1, &depth, &albedo, &effects);
    float of_old = 0, of_usual = 0, beam = 0;
    check_ok(stratus_slice_background(old.get(), 0.5f, &of_old));
    check_ok(stratus_slice_background(usual.get(), 0.5f, &of_usual));
    check_ok(stratus_slice_background(beam_alone.get(), 0.5f, &beam));
    EXPECT_EQ(of_old, of_usual);
    EXPECT_NEAR(beam, std::exp(-2.0f), 1e-7f);
    EXPECT_LT(beam, of_usual);
}

TEST_F(C, RefusesToBindWhatIsOutOfRange) {
    const double one = 1, negative = -1e-9, more = 1.0000001, nan = NAN;
    stratus_slice* slice = nullptr;
    const auto refused = [&](int channels, const double* depth, const double* albedo,
                             const stratus_effects* effects, const char* part) {
        expect_refused(stratus_slice_bind(handle_, channels, depth, albedo, effects, &slice), part);
        EXPECT_EQ(slice, nullptr);
    };
    refused(2, &one, &one, nullptr, "channels must be 1 or 3, got 2");
    refused(1, &negative, &one, nullptr, "optical_depth must be in [0, inf], got -1e-09");
    refused(1, &nan, &one, nullptr, "optical_depth");
    refused(1, &one, &more, nullptr, "albedo must be in [0, 1], got 1.0000001");
    refused(1, nullptr, &one, nullptr, "optical_depth must be given");
    refused(1, &one, nullptr, nullptr, "albedo must be given");
    stratus_effects effects = default_effects();
    effects.density = 1;
    refused(1, &one, &one, &effects, "density must be in [0, 1), got 1");
    effects = default_effects();
    effects.opposition = 3;
    refused(1, &one, &one, &effects, "opposition must be one of the laws, 0 to 2, got 3");
    effects = default_effects();
    effects.opposition = STRATUS_BLINN_OPPOSITION;
    refused(1, &one, &one, &effects,
            "opposition.width must be in (0, inf), or 0 with a density above 0, got 0");
    effects = default_effects();
    effects.multiple = 2;
    refused(1, &one, &one, &effects, "multiple must be 0 or 1, got 2");
    expect_refused(stratus_slice_bind_single("rayleig", 1, &one, &one, nullptr, &slice), "rayleig");
    expect_refused(stratus_slice_bind_single(nullptr, 1, &one, &one, nullptr, &slice),
                   "phase_function must be given");
    expect_refused(stratus_slice_bind(nullptr, 1, &one, &one, nullptr, &slice),
                   "table must be given");
    expect_refused(stratus_slice_bind(handle_, 1, &one, &one, nullptr, nullptr),
                   "slice must be given");
}

TEST_F(C, RefusesLookupsOfNull) {
    const double one = 1;
    const BoundSlice slice = bind(1, &one, &one);
    const float v[3] = {0, 0, 1};
    const float* const arrays[3] = {v, v, v};
    const float* const gap[3] = {v, v, nullptr};
    float value = 7;
    const stratus_point point{1, 1, 1, 1, 0};
    stratus_scattered scattered;
    const auto* const no_slice = static_cast<const stratus_slice*>(nullptr);
    expect_refused(stratus_table_reflection(nullptr, 1, &point, &scattered), "table");
    expect_refused(stratus_table_transmission(handle_, 1, nullptr, &scattered), "points");
    expect_refused(stratus_table_transmission(handle_, 1, &point, nullptr), "values");
    expect_refused(stratus_slice_reflection(no_slice, 1, 1, 0, &value), "slice");
    expect_refused(stratus_slice_reflection(slice.get(), 1, 1, 0, nullptr), "value");
    expect_refused(stratus_slice_transmission(no_slice, 1, 1, 0, &value), "slice");
    expect_refused(stratus_slice_direct(no_slice, 1, &value), "slice");
    expect_refused(stratus_slice_background(no_slice, 1, &value), "slice");
    expect_refused(stratus_slice_eval(no_slice, v, v, &value), "slice");
    expect_refused(stratus_slice_eval(slice.get(), nullptr, v, &value), "wi");
    expect_refused(stratus_slice_eval(slice.get(), v, nullptr, &value), "wo");
    expect_refused(stratus_slice_reflection_many(slice.get(), 1, v, v, nullptr, &value),
                   "every array");
    expect_refused(stratus_slice_transmission_many(slice.get(), 1, nullptr, v, v, &value),
                   "every array");
    expect_refused(stratus_slice_eval_many(slice.get(), 1, arrays, gap, &value), "every array");
    expect_refused(stratus_slice_eval_many(slice.get(), 1, nullptr, arrays, &value), "wi");
    EXPECT_EQ(value, 7);
    EXPECT_EQ(stratus_slice_channels(nullptr), 0);
    EXPECT_EQ(stratus_slice_bytes(nullptr), 0u);
    EXPECT_EQ(stratus_table_text(nullptr, "title"), nullptr);
    stratus_table_close(nullptr);
    stratus_slice_free(nullptr);
    // No numbers, no arrays.
    check_ok(stratus_table_reflection(handle_, 0, nullptr, nullptr));
    check_ok(stratus_slice_reflection_many(slice.get(), 0, nullptr, nullptr, nullptr, nullptr));
}

TEST(CErrors, StayOnTheirThread) {
    stratus_table* table = nullptr;
    expect_refused(stratus_table_open("mine.h5", &table), "mine.h5", STRATUS_FAILED);
    std::thread([] {
        EXPECT_STREQ(stratus_last_error(), "");
        stratus_table* other = nullptr;
        expect_refused(stratus_table_open("theirs.h5", &other), "theirs.h5", STRATUS_FAILED);
    }).join();
    expect_holds(stratus_last_error(), "mine.h5");
}

}  // namespace
}  // namespace stratus::test
