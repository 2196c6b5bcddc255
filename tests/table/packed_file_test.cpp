// Files of packed tables: what is written is read, and what was forged is refused or harmless.
#include <stratus/table/packed_table.h>

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/base/tensor_file.h>
#include <stratus/bsdf/slice.h>

#include "all_near.h"
#include "refusal.h"
#include "small_table.h"
#include "table/packed_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace stratus {
namespace {

/// What is left of samples once they are divided by all that lookups divide by.
double packed_shape(const SamplePoint& p) { return 2 + p.mu_in * p.mu_out * std::cos(p.azimuth); }

Table small(const char* phase = "henyey_greenstein:g=0.5") {
    Table table = empty_table({5, 6, 6, 6, 5}, {0.1, 8, true});
    table.phase_function = parse_phase_function(phase);
    table.tolerance = 1e-3;
    table.attributes["title"] = "small";
    fill(table, packed_shape);
    return table;
}

/// Lookups of every kind, whatever they give.
void look_up(const PackedTable& table) {
    for (const double albedo : {0.0, 0.8, 1.0})
        for (const double depth : {0.0, 1e-3, 2.0, 50.0, infinity})
            for (const Geometry& at : {Geometry{0.9, 0.2, 1}, Geometry{1e-4, 1, 3.1}}) {
                table.reflection(albedo, depth, at, 0.3);
                table.transmission(albedo, depth, at, 0.3);
            }
}

TEST(PackedFile, HoldsWhatTheTableSays) {
    const Table table = small("0.5*lambert_sphere + 0.5*rayleigh");
    const PackedTable packed(pack(table));
    const Table& header = packed.header();
    EXPECT_EQ(header.phase_function.text(), table.phase_function.text());
    EXPECT_EQ(header.optical_depth.values, table.optical_depth.values);
    EXPECT_EQ(header.mu_in.values, table.mu_in.values);
    EXPECT_EQ(header.diffusion_exponent, table.diffusion_exponent);
    EXPECT_EQ(header.attributes.at("title"), "small");
    EXPECT_EQ(header.tolerance, table.tolerance);
    expect_all_near(packed.unpacked().reflection_multiple, table.reflection_multiple, 1e-3);
}

/// A file with some of its strings or numbers changed.
class Forged {
  public:
    explicit Forged(const Table& table = small()) : original_(pack(table)) {
        const TensorFile file(aligned(original_), original_.size());
        for (const auto& [key, text] : file.strings()) strings_[key] = text;
        for (const auto& [name, tensor] : file.tensors()) {
            if (name.rfind("padding_", 0) == 0) continue;
            const std::size_t sizes[] = {2, 4, 8, 4};
            const auto* const first = static_cast<const char*>(tensor.data);
            tensors_[name] = {
                tensor.type,
                tensor.shape,
                {first, first + tensor.count() * sizes[static_cast<int>(tensor.type)]}};
        }
    }

    struct Held {
        TensorType type;
        std::vector<std::size_t> shape;
        std::vector<char> data;
    };
    std::map<std::string, std::string> strings_;
    std::map<std::string, Held> tensors_;

    template <class Number>
    void set(const std::string& name, std::size_t at, Number value) {
        std::memcpy(tensors_.at(name).data.data() + at * sizeof value, &value, sizeof value);
    }

    std::vector<char> bytes() const {
        TensorWriter file;
        for (const auto& [key, text] : strings_) file.set(key, text);
        for (const auto& [name, held] : tensors_)
            file.refer(name, held.type, held.shape, held.data.data());
        return file.finish();
    }

  private:
    const void* aligned(const std::vector<char>& bytes) {
        copy_.assign(bytes.size() / sizeof(double) + 1, 0);
        std::memcpy(copy_.data(), bytes.data(), bytes.size());
        return copy_.data();
    }

    std::vector<char> original_;
    std::vector<double> copy_;
};

TEST(PackedFile, KeepsWhatRoundingToHalvesLeaves) {
    const Table table = small();
    Forged file(table);
    for (const char* const side : {"reflection/functions", "transmission/functions"})
        EXPECT_EQ(file.tensors_.at(side).type, TensorType::f16);
    expect_all_near(PackedTable(file.bytes()).unpacked().reflection_multiple,
                    table.reflection_multiple, 1e-5);
}

TEST(PackedFile, IsRestatedWithTheSameNumbers) {
    Table table = small();
    const PackedTable before(pack(table));
    table.measured_error = 3e-4;
    table.attributes["title"] = "measured afterwards";
    EXPECT_EQ(restated(before.file(), table), pack(table));
    table.attributes["tolerance"] = "0";
    EXPECT_THROW(restated(before.file(), table), std::invalid_argument) << "a name of the format";
}

TEST(PackedFile, BindsAsTheTableDoes) {
    for (const char* const phase : {"isotropic", "henyey_greenstein:g=0.5"}) {
        const Table table = small(phase);
        const PackedTable packed(pack(table));
        for (const double depth : {0.02, 1.0, 30.0, infinity}) {
            const Slice expected = bind(table.view(), depth, 0.9),
                        found = bind(packed.view(), depth, 0.9);
            for (const float mu : {0.1f, 0.5f, 0.95f})
                for (const float azimuth : {0.0f, 1.0f, 3.0f}) {
                    const float R = expected.reflection(mu, 0.4f, azimuth);
                    EXPECT_NEAR(found.reflection(mu, 0.4f, azimuth), R, 1e-3f * R);
                    const float T = expected.transmission(mu, 0.4f, azimuth);
                    EXPECT_NEAR(found.transmission(mu, 0.4f, azimuth), T, 1e-3f * T);
                    EXPECT_EQ(found.direct(mu), expected.direct(mu));
                }
        }
    }
}

void expect_forgery_refused(const Forged& forged, const Fragments& fragments) {
    expect_refusal([&] { PackedTable{forged.bytes()}; }, fragments);
}

Table with_path_law(const char* phase) {
    Table table = small(phase);
    table.path_law = PathOrders::of(table.phase_function);
    return table;
}

TEST(PackedFile, LooksThePathLawUpNearForwardAtAnyDepth) {
    std::mt19937 random(1909);
    const auto between = [&](double from, double to) {
        return std::uniform_real_distribution(from, to)(random);
    };
    constexpr double deepest_slant = 150, faintest = 1e-5;
    for (const char* const phase :
         {"henyey_greenstein:g=0.85", "henyey_greenstein:g=0.95", "henyey_greenstein:g=0.985"}) {
        Table table = with_path_law(phase);  // and nothing else
        std::ranges::fill(table.transmission_multiple, 0.0f);
        const PackedTable packed(pack(table));
        std::vector<double> thin, deep;
        while (thin.size() < 2000 || deep.size() < 2000) {
            const double albedo = between(0.1, 1), depth = std::exp(between(-2.3, 5)),
                         mu = between(0.15, 0.99);
            const Geometry at{mu, std::clamp(mu + between(-0.05, 0.05), 0.15, 1.0),
                              between(0, 0.1)};
            const double slant = depth / std::min(at.mu_in, at.mu_out);
            const double T = transmission(table.view(), albedo, depth, at).total();
            if (slant > deepest_slant || T < faintest) continue;
            (slant < 8 ? thin : deep)
                .push_back(std::abs(packed.transmission(albedo, depth, at).total() - T) / T);
        }
        const auto share = [](std::vector<double>& errors, double part) {
            std::ranges::sort(errors);
            return errors[static_cast<std::size_t>(part * static_cast<double>(errors.size()))];
        };
        EXPECT_LT(share(thin, 0.5), 1e-5) << phase;
        EXPECT_LT(share(thin, 0.99), 2e-4) << phase;
        EXPECT_LT(share(deep, 0.5), 2e-4) << phase;
        EXPECT_LT(share(deep, 0.99), 7e-3) << phase;
    }
}

TEST(PackedFile, WithoutItsPhaseCurveIsRefusedBeforeOneIsSampled) {
    std::string text = "moments:chi=1";  // 4000 of them, which take long to sample
    for (int l = 1; l < 4000; ++l) text += " " + shortest_text(std::pow(0.99, l));
    Forged forged(small());
    forged.strings_.at("phase_function") = text;
    const auto seconds = [](const auto& work) {
        const auto start = std::chrono::steady_clock::now();
        work();
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    const double refusal =
        seconds([&] { expect_forgery_refused(forged, "phase must be given, got none"); });
    const double sampling = seconds([&] { PhaseCurve(parse_phase_function(text)); });
    EXPECT_LT(refusal, sampling / 2);
}

TEST(PackedFile, LooksThePathLawUpWhetherHeldOrWorkedOut) {
    for (const char* const phase :
         {"henyey_greenstein:g=0.85", "henyey_greenstein:g=0.95", "henyey_greenstein:g=0.98"}) {
        const Table table = with_path_law(phase);
        const bool held = table.path_law->order_count() - 2 > static_cast<int>(most_summed_orders);
        const Forged file(table);
        EXPECT_EQ(file.tensors_.count(path_sheet_name), held ? 1 : 0);
        const PackedTable packed(file.bytes());
        for (const Geometry& at : {Geometry{0.9, 0.8, 0.1}, Geometry{0.4, 0.4, 3}}) {
            const double R = reflection(table.view(), 0.95, 2, at).multiple;
            EXPECT_NEAR(packed.reflection(0.95, 2, at).multiple, R, 2e-3 * R);
            const double T = transmission(table.view(), 0.95, 2, at).multiple;
            EXPECT_NEAR(packed.transmission(0.95, 2, at).multiple, T, 2e-3 * T);
        }
    }
}

TEST(PackedFile, HoldsThePathSheetOfItsOwnAlbedosAlone) {
    Table table = with_path_law("henyey_greenstein:g=0.985");  // and nothing else
    for (std::vector<float>* const samples :
         {&table.reflection_multiple, &table.transmission_multiple})
        std::ranges::fill(*samples, 0.0f);
    const Forged whole(table);
    table.albedo = make_axis(AxisScale::square_root_of_complement, 0.9, 1, 5);
    prepare(table);
    const Forged part(table);
    EXPECT_EQ(whole.tensors_.at(path_sheet_name).shape[0], 26u);  // steps 1 to 26
    EXPECT_EQ(part.tensors_.at(path_sheet_name).shape[0], 6u);    // steps 21 to 26
    const PackedTable expected(whole.bytes()), found(part.bytes());
    for (const Side side : both_sides)
        for (const double albedo : {0.9, 0.93, 0.999, 1.0}) {
            const Geometry at{0.9, 0.8, 0.1};
            EXPECT_EQ(found.scattering(side, albedo, 2, at).multiple,
                      expected.scattering(side, albedo, 2, at).multiple);
        }
}

TEST(PackedFile, HoldsThePathLawInHalvesWhereTheToleranceIsWide) {
    Table table = with_path_law("henyey_greenstein:g=0.85");
    table.tolerance = 1e-2;
    const Forged file(table);
    EXPECT_EQ(file.tensors_.at("path_orders").type, TensorType::f16);
    const PackedTable packed(file.bytes());
    const PathOrders &exact = *table.path_law, &found = *packed.header().path_law;
    ASSERT_EQ(found.order_count(), exact.order_count());
    for (int angle = 0; angle < 2 * exact.angle_count(); ++angle)
        EXPECT_NEAR(found.of_angle(angle)[0], exact.of_angle(angle)[0],
                    std::abs(exact.of_angle(angle)[0]) / 2048 + 1e-7);
}

TEST(PackedFile, LooksUpThePathSheetOfFewOrdersWhereAFileHoldsIt) {
    const Table table = with_path_law("henyey_greenstein:g=0.85");
    Forged file(table);
    const PackedTable expected(file.bytes());
    const int first = first_path_step(*table.path_law, table.view());
    const PathSheet sheet = squared_path_sheet(*table.path_law, first, 0);
    const auto albedos = static_cast<std::size_t>(path_sheet_steps(*table.path_law) + 1 - first),
               angles = 2 * static_cast<std::size_t>(table.path_law->angle_count());
    const std::size_t count = sheet.sample_count();
    const auto* const samples = reinterpret_cast<const char*>(sheet.view().sample);
    file.tensors_[path_sheet_name] = {TensorType::f32,
                                      {albedos, count / albedos / angles / 2, angles, 2},
                                      {samples, samples + count * sizeof(float)}};
    const PackedTable packed(file.bytes());
    for (const Geometry& at : {Geometry{0.9, 0.8, 0.1}, Geometry{0.4, 0.4, 3}}) {
        EXPECT_EQ(packed.reflection(0.95, 2, at).multiple,
                  expected.reflection(0.95, 2, at).multiple);
        EXPECT_EQ(packed.transmission(0.95, 2, at).multiple,
                  expected.transmission(0.95, 2, at).multiple);
    }
}

TEST(PackedFile, RefusesManyOrdersWithoutTheirSheet) {
    Forged file(with_path_law("henyey_greenstein:g=0.95"));
    file.tensors_.erase(path_sheet_name);
    expect_forgery_refused(file, "path_sheet must be given for more than 64");
}

/// Two members whose samples are alike but for a factor: one set of functions serves both.
Table of_two_levels() {
    const Table first = small();
    Table second = first;
    for (std::vector<float>* const samples :
         {&second.reflection_multiple, &second.transmission_multiple})
        for (float& value : *samples) value *= 1.5f;
    return mixed(first, second);
}

TEST(PackedFile, SharesFunctionsAmongMembers) {
    Forged file(of_two_levels());
    for (const std::string side : {"reflection/", "transmission/"}) {
        const std::string first = "member_0/" + side, second = "member_1/" + side;
        ASSERT_EQ(file.tensors_.count(second + "functions"), 0u);
        ASSERT_EQ(file.tensors_.count(second + "functions_of"), 1u);
    }
    const PackedTable shared(file.bytes());
    // Each member with functions of its own.
    for (const std::string side : {"reflection/", "transmission/"}) {
        const std::string first = "member_0/" + side, second = "member_1/" + side;
        for (const char* const name : {"functions", "blocks", "block_of_cell"})
            file.tensors_[second + name] = file.tensors_.at(first + name);
        file.tensors_.erase(second + "functions_of");
    }
    const PackedTable separate(file.bytes());
    for (const double share : {0.0, 0.4, 1.0})
        for (const Geometry& at : {Geometry{0.9, 0.2, 1}, Geometry{0.3, 0.3, 3.1}}) {
            const double level = 1.5 - 0.5 * share;
            const SamplePoint point{0.8, 2, at.mu_in, at.mu_out, at.azimuth};
            const double expected =
                level * small_table_scale(Side::reflection, point) * packed_shape(point);
            const TableView view = shared.view().at({share});
            EXPECT_NEAR(reflection(view, 0.8, 2, at).multiple, expected, 1e-3 * expected);
            EXPECT_EQ(reflection(view, 0.8, 2, at).multiple,
                      reflection(separate.view().at({share}), 0.8, 2, at).multiple);
            EXPECT_EQ(transmission(view, 0.8, 2, at).multiple,
                      transmission(separate.view().at({share}), 0.8, 2, at).multiple);
        }
}

TEST(PackedFile, RefusesForgedOwnersOfFunctions) {
    for (const std::int32_t owner : {-1, 1, 2, INT32_MAX}) {
        Forged forged(of_two_levels());
        forged.set("member_1/reflection/functions_of", 0, owner);
        SCOPED_TRACE(owner);
        expect_forgery_refused(forged,
                               "member_1/reflection/functions_of must be an earlier member");
    }
    Forged without(of_two_levels());
    without.tensors_.erase("member_0/transmission/functions");
    expect_forgery_refused(without, {"member_1/transmission/functions_of", "functions of its own"});
}

TEST(PackedFile, RefusesForgedStrings) {
    PackedTable{Forged().bytes()};
    const std::vector<std::pair<const char*, const char*>> rows{
        {"format", "another"},
        {"format_version", "3"},
        {"tolerance", "-1"},
        {"highest_order", "1.5"},
        {"highest_order", "2147483647"},
        {"extrapolation_length", "0"},
        {"albedo_scale", "logarithmic"},
        {"mu_in_scale", "linear"},
        {"optical_depth_scale", "depth"},
        {"measured_error", "few"},
        {"phase_function", "moments:file=/etc/passwd"},
        {"phase_function", "nonsense"},
        {"below", "water"}};
    for (const auto& [key, text] : rows) {
        Forged forged;
        forged.strings_[key] = text;
        if (std::string(key) == "below") forged.strings_["below_albedo"] = "0.5";
        SCOPED_TRACE(key);
        expect_forgery_refused(forged, {});
    }
    Forged forged;
    forged.strings_.erase("phase_function");
    expect_forgery_refused(forged, "phase_function");
}

TEST(PackedFile, RefusesForgedBlocks) {
    const std::string side = "reflection/";
    for (int field = 0; field < 6; ++field)
        for (const std::int32_t value : {-1, 9, 1 << 30, INT32_MAX, INT32_MIN}) {
            Forged forged;
            forged.set(side + "blocks", static_cast<std::size_t>(field), value);
            SCOPED_TRACE(std::to_string(field) + " = " + std::to_string(value));
            expect_forgery_refused(forged, {side.c_str()});
        }
    Forged forged;
    forged.set(side + "blocks", 4, 0);  // not infinite, as its cells need
    expect_forgery_refused(forged, "packed table");
    for (const std::int32_t value : {-1, 1000}) {
        Forged other;
        other.set(side + "block_of_cell", 3, value);
        expect_forgery_refused(other, "block_of_cell");
    }
    for (const char* const name : {"functions", "coefficients", "block_of_cell", "blocks"}) {
        Forged other;
        auto& shape = other.tensors_.at(side + name).shape;
        if (shape.size() == 3)
            std::swap(shape[1], shape[2]);
        else
            std::swap(shape[0], shape[1]);
        SCOPED_TRACE(name);
        if (shape[0] != shape[1]) expect_forgery_refused(other, {name});
    }
    Forged without;
    without.tensors_.erase(side + "coefficients");
    expect_forgery_refused(without, "coefficients");
}

TEST(PackedFile, RefusesForgedAxesAndFluxes) {
    for (const char* const name : {"albedo", "optical_depth", "mu_in", "mu_out", "azimuth"})
        for (const double value : {-1.0, 1e300}) {
            Forged forged;
            forged.set(name, 1, value);
            SCOPED_TRACE(name);
            expect_forgery_refused(forged, {name});
        }
    Forged forged;
    forged.set("diffusion_exponent", 0, -1.0);
    expect_forgery_refused(forged, "diffusion_exponent");
    const auto nothing = [](const char* side) {
        Forged other;
        for (auto held = other.tensors_.begin(); held != other.tensors_.end();)
            held = held->first.rfind(side, 0) == 0 ? other.tensors_.erase(held) : std::next(held);
        return other;
    };
    EXPECT_FALSE(PackedTable(nothing("transmission/").bytes()).has_transmission());
    Forged neither = nothing("transmission/");
    for (const char* const name : {"functions", "coefficients", "blocks", "block_of_cell"})
        neither.tensors_.erase(std::string("reflection/") + name);
    expect_forgery_refused(neither, "neither");
}

TEST(PackedFile, ReadsTheSeedOfItsFuzzer) {
    const PackedTable seed(STRATUS_REFERENCE_FOLDER "/../fuzz/seeds/packed/tiny.stratus");
    EXPECT_TRUE(seed.is_intact());
}

TEST(PackedFile, SurvivesMutations) {
    const std::vector<char> original = pack(small("lambert_sphere"));
    std::mt19937 random(1);
    const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
    std::uint64_t header = 0;
    std::memcpy(&header, original.data(), sizeof header);
    int read = 0;
    constexpr int mutations = 5000;
    for (int n = 0; n < mutations; ++n) {
        std::vector<char> bytes = original;
        // Half of the changes within the header, which decides where numbers are read.
        for (std::size_t k = 0; k <= below(3); ++k) {
            const std::size_t at = below(n % 2 == 0 ? 8 + header : bytes.size());
            bytes[at] = static_cast<char>(random());
        }
        if (n % 16 == 0) bytes.resize(below(bytes.size()));
        try {
            const PackedTable table(bytes);
            ++read;
            if (n % 8 == 0) look_up(table);
        } catch (const std::invalid_argument&) {
        }
    }
    EXPECT_GT(read, mutations / 50) << "values of functions may be anything";
    EXPECT_LT(read, mutations * 9 / 10);
}

}  // namespace
}  // namespace stratus
