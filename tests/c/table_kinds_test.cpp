// The C interface: packed tables, textured lookups, mixtures and stacks, beside the C++ functions.
#include <stratus/bsdf/slice.h>
#include <stratus/io/table_file.h>
#include <stratus/stratus.h>
#include <stratus/table/lookup.h>
#include <stratus/table/packed_table.h>

#include "expect_refused.h"
#include "../io/temporary_folder.h"
#include "../picture/synthetic_table.h"
#include "../table/small_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

using Handle = std::unique_ptr<stratus_table, decltype(&stratus_table_close)>;

Handle opened(const std::filesystem::path& path) {
    stratus_table* table = nullptr;
    check_ok(stratus_table_open(path.c_str(), &table));
    return {table, &stratus_table_close};
}

/// Layers and directions within the synthetic table, one array each.
struct Points {
    static constexpr std::size_t count = 200;
    std::vector<float> optical_depth, albedo, mu_in, mu_out, azimuth;

    Points() {
        std::mt19937 random(7);
        const auto draw = [&](float low, float high) {
            return std::uniform_real_distribution<float>(low, high)(random);
        };
        for (std::size_t i = 0; i < count; ++i) {
            optical_depth.push_back(draw(0.01f, 8));
            albedo.push_back(draw(0, 1));
            mu_in.push_back(draw(0.01f, 1));
            mu_out.push_back(draw(0.01f, 1));
            azimuth.push_back(draw(0, 3));
        }
    }

    stratus_point at(std::size_t i) const {
        return {optical_depth[i], albedo[i], mu_in[i], mu_out[i], azimuth[i]};
    }
};

constexpr stratus_point usual_point{0.8, 1, 0.5, 0.7, 1};

class PackedInC : public testing::Test {
  protected:
    PackedInC() : bytes_(pack(make_synthetic_table())), same_(bytes_) {
        set_content(path_, {bytes_.begin(), bytes_.end()});
    }

    const TemporaryFolder folder_;
    const std::filesystem::path path_ = folder_ / "table.stratus";
    const std::vector<char> bytes_;
    const PackedTable same_;
};

TEST_F(PackedInC, AreMappedAndBound) {
    const Handle packed = opened(path_);
    EXPECT_EQ(stratus_table_text(packed.get(), "phase_function"),
              same_.header().phase_function.text());
    const stratus_table_info info = described(packed.get());
    EXPECT_EQ(info.is_packed, 1);
    EXPECT_EQ(info.has_transmission, 1);
    stratus_scattered value{};
    check_ok(stratus_table_reflection(packed.get(), 1, &usual_point, &value));
    const Scattered expected = reflection(same_.view(), 1, 0.8, {0.5, 0.7, 1});
    EXPECT_EQ(value.single, expected.single);
    EXPECT_EQ(value.multiple, expected.multiple);
    const double depth = 1, albedo = 0.8;
    stratus_slice* slice = nullptr;
    check_ok(stratus_slice_bind(packed.get(), 1, &depth, &albedo, nullptr, &slice));
    float bound = 0;
    check_ok(stratus_slice_reflection(slice, 0.5f, 0.7f, 1, &bound));
    EXPECT_EQ(bound, bind(same_.view(), depth, albedo).reflection(0.5f, 0.7f, 1));
    stratus_slice_free(slice);
}

TEST_F(PackedInC, AreLookedUpManyAtOnce) {
    const Handle packed = opened(path_);
    const Points points;
    std::vector<float> met(points.count), expected(points.count);
    const PackedPoints in_cpp{points.albedo.data(),  points.optical_depth.data(),
                              points.mu_in.data(),   points.mu_out.data(),
                              points.azimuth.data(), points.count};
    for (const Side side : both_sides) {
        const bool lit = side == Side::reflection;
        const auto look_up = lit ? stratus_table_reflection : stratus_table_transmission;
        const auto look_up_many =
            lit ? stratus_table_reflection_many : stratus_table_transmission_many;
        check_ok(look_up_many(packed.get(), points.count, points.optical_depth.data(),
                              points.albedo.data(), points.mu_in.data(), points.mu_out.data(),
                              points.azimuth.data(), met.data()));
        same_.scattering(side, in_cpp, expected.data());
        EXPECT_EQ(met, expected);
        for (std::size_t i = 0; i < points.count; ++i) {
            const stratus_point at = points.at(i);
            stratus_scattered one{};
            check_ok(look_up(packed.get(), 1, &at, &one));
            EXPECT_NEAR(static_cast<double>(met[i]) / (one.single + one.multiple), 1, 1e-5) << i;
        }
    }
}

TEST_F(PackedInC, AreReadWhereTheyLieInMemory) {
    // A place that is aligned, and one that is not.
    std::vector<char> room(bytes_.size() + 128);
    void* place = room.data();
    std::size_t left = room.size();
    ASSERT_NE(std::align(64, bytes_.size(), place, left), nullptr);
    std::memcpy(place, bytes_.data(), bytes_.size());
    stratus_table* table = nullptr;
    check_ok(stratus_table_open_memory(place, bytes_.size(), &table));
    const Handle handle(table, &stratus_table_close);
    stratus_scattered value{};
    check_ok(stratus_table_transmission(table, 1, &usual_point, &value));
    EXPECT_EQ(value.multiple, same_.transmission(1, 0.8, {0.5, 0.7, 1}).multiple);

    stratus_table* none = table;
    expect_refused(stratus_table_open_memory(place, bytes_.size() - 1, &none), "data");
    EXPECT_EQ(none, nullptr);
    expect_refused(stratus_table_open_memory(nullptr, 10, &none), "data must be given");
    std::vector<char> beside(bytes_.size() + 128);
    place = beside.data();
    left = beside.size();
    ASSERT_NE(std::align(64, bytes_.size() + 8, place, left), nullptr);
    char* const odd = static_cast<char*>(place) + 8;
    std::memcpy(odd, bytes_.data(), bytes_.size());
    expect_refused(stratus_table_open_memory(odd, bytes_.size(), &none), "a multiple of 64 bytes");
}

TEST_F(PackedInC, AreRefusedInWords) {
    stratus_table* table = nullptr;
    const std::filesystem::path no_table = folder_ / "no_table.stratus";
    set_content(no_table, "no table");
    expect_refused(stratus_table_open(no_table.c_str(), &table), "no_table.stratus",
                   STRATUS_FAILED);
    EXPECT_EQ(table, nullptr);

    const float x = 0.5f;
    float total = 0;
    const Handle packed = opened(path_);
    const auto refused = [&](const stratus_table* of, const float* depth, float* to,
                             const char* part) {
        expect_refused(stratus_table_reflection_many(of, 1, depth, &x, &x, &x, &x, to), part);
        expect_refused(stratus_table_transmission_many(of, 1, depth, &x, &x, &x, &x, to), part);
    };
    refused(nullptr, &x, &total, "table must be given");
    refused(packed.get(), nullptr, &total, "every array must be given");
    refused(packed.get(), &x, nullptr, "every array must be given");
    check_ok(stratus_table_reflection_many(packed.get(), 0, nullptr, nullptr, nullptr, nullptr,
                                           nullptr, nullptr));
    write_table(make_synthetic_table(), folder_ / "table.h5");
    const Handle dense = opened(folder_ / "table.h5");
    refused(dense.get(), &x, &total, "table must be a packed one, got one with samples");
    EXPECT_EQ(total, 0);
}

/// Tables that mix the synthetic one with another phase function, as a file and packed.
class MixedInC : public testing::TestWithParam<const char*> {
  protected:
    MixedInC() {
        SyntheticOptions other;
        other.phase_function = "henyey_greenstein:g=0.3";
        table_ = mixed(make_synthetic_table(), make_synthetic_table(other));
        const std::filesystem::path path = folder_ / GetParam();
        if (path.extension() == ".h5")
            write_table(table_, path);
        else {
            const std::vector<char> bytes = pack(table_);
            set_content(path, {bytes.begin(), bytes.end()});
            packed_ = std::make_unique<PackedTable>(bytes);
        }
        all_ = opened(path);
    }

    TableView view() const { return packed_ ? packed_->view() : table_.view(); }

    const TemporaryFolder folder_;
    Table table_;
    std::unique_ptr<PackedTable> packed_;
    Handle all_{nullptr, &stratus_table_close};
};

INSTANTIATE_TEST_SUITE_P(Files, MixedInC, testing::Values("mixed.h5", "mixed.stratus"),
                         [](const auto& file) {
                             return std::string(file.index == 0 ? "Dense" : "Packed");
                         });

TEST_P(MixedInC, AreLookedUpAtOneMixture) {
    const stratus_table_info info = described(all_.get());
    EXPECT_EQ(info.mixture.lowest, 0);
    EXPECT_EQ(info.mixture.highest, 1);
    EXPECT_EQ(info.mixture.samples, 2u);
    EXPECT_STREQ(stratus_table_text(all_.get(), "second_phase_function"),
                 "henyey_greenstein:g=0.3");
    stratus_table* one = nullptr;
    const double share = 0.3;
    check_ok(stratus_table_at(all_.get(), 1, &share, &one));
    const Handle mixed(one, &stratus_table_close);
    all_.reset();  // samples are shared
    stratus_scattered r{}, t{};
    check_ok(stratus_table_reflection(one, 1, &usual_point, &r));
    check_ok(stratus_table_transmission(one, 1, &usual_point, &t));
    const TableView same = view().at({0.3});
    EXPECT_EQ(r.single, reflection(same, 1, 0.8, {0.5, 0.7, 1}).single);
    EXPECT_EQ(r.multiple, reflection(same, 1, 0.8, {0.5, 0.7, 1}).multiple);
    EXPECT_EQ(t.multiple, transmission(same, 1, 0.8, {0.5, 0.7, 1}).multiple);
    const double depths[3] = {0.5, 1, 2}, albedos[3] = {0.7, 0.8, 0.9};
    stratus_slice* slice = nullptr;
    check_ok(stratus_slice_bind(one, 3, depths, albedos, nullptr, &slice));
    float value[3] = {};
    check_ok(stratus_slice_reflection(slice, 0.5f, 0.7f, 1, value));
    EXPECT_EQ(value[2], bind_rgb(same, depths, albedos).reflection(0.5f, 0.7f, 1).b);
    stratus_slice_free(slice);
    if (!packed_) return;
    const float depth = 0.8f, w = 1, mu = 0.5f, mu_out = 0.7f, azimuth = 1;
    float total = 0, expected = 0;
    check_ok(stratus_table_reflection_many(one, 1, &depth, &w, &mu, &mu_out, &azimuth, &total));
    packed_->reflection({&w, &depth, &mu, &mu_out, &azimuth, 1}, &expected, 0.3);
    EXPECT_EQ(total, expected);
}

TEST_P(MixedInC, TellTheirFamily) {
    const char* name = nullptr;
    stratus_range range{};
    check_ok(stratus_table_family(all_.get(), 0, &name, &range));
    EXPECT_STREQ(name, "mixture");
    EXPECT_EQ(range.highest, 1);
    EXPECT_EQ(range.samples, 2u);
    expect_refused(stratus_table_family(all_.get(), 1, &name, &range),
                   "axis must be below 1, got 1");
    const double two[] = {0.3, 0.4};
    stratus_table* chosen = nullptr;
    expect_refused(stratus_table_at(all_.get(), 2, two, &chosen), "got 2");
    EXPECT_EQ(chosen, nullptr);
}

TEST_P(MixedInC, AreRefusedAtNone) {
    stratus_scattered value{};
    expect_refused(stratus_table_reflection(all_.get(), 1, &usual_point, &value),
                   "table must be of one point of its family, by stratus_table_at()");
    const double one = 1;
    stratus_slice* slice = nullptr;
    expect_refused(stratus_slice_bind(all_.get(), 1, &one, &one, nullptr, &slice),
                   "stratus_table_at");
    stratus_table* mixed = nullptr;
    for (const double share : {1.5, -0.1, double{NAN}})
        expect_refused(stratus_table_at(all_.get(), 1, &share, &mixed),
                       "mixture must be in [0, 1]");
    expect_refused(stratus_table_at(nullptr, 1, &one, &mixed), "table must be given");
    EXPECT_EQ(mixed, nullptr);
}

TEST(StacksInC, ScatterOnce) {
    const stratus_layer layers[2] = {{"rayleigh", 1, 0.1}, {"henyey_greenstein:g=0.7", 0.9, 0.4}};
    const std::vector<StackLayer> same = {
        {parse_phase_function("rayleigh"), 1, 0.1},
        {parse_phase_function("henyey_greenstein:g=0.7"), 0.9, 0.4}};
    stratus_slice* slice = nullptr;
    check_ok(stratus_slice_bind_single_stack(2, layers, 1, nullptr, &slice));
    float r = 0, t = 0;
    check_ok(stratus_slice_reflection(slice, 0.5f, 0.7f, 1, &r));
    check_ok(stratus_slice_transmission(slice, 0.5f, 0.7f, 1, &t));
    const double single = stack_single_scattering(Side::reflection, same, {0.5, 0.7, 1});
    EXPECT_NEAR(static_cast<double>(r), single, 1e-5 * single);  // single precision
    const double through = stack_single_scattering(Side::transmission, same, {0.5, 0.7, 1});
    EXPECT_NEAR(static_cast<double>(t), through, 1e-5 * through);
    stratus_slice_free(slice);

    const auto refused = [&](std::size_t count, const stratus_layer* of, const char* part) {
        expect_refused(stratus_slice_bind_single_stack(count, of, 1, nullptr, &slice), part);
        EXPECT_EQ(slice, nullptr);
    };
    refused(0, layers, "layer_count must be at least 1, got 0");
    refused(1, nullptr, "layers must be given");
    const stratus_layer nameless{nullptr, 1, 1}, white{"rayleigh", 1.5, 1};
    refused(1, &nameless, "phase_function of every layer must be given");
    refused(1, &white, "got 1.5");
    std::size_t count = 5;
    EXPECT_EQ(stratus_table_layers(nullptr, &count), nullptr);
    EXPECT_EQ(count, 0u);
}

}  // namespace
}  // namespace stratus::test
