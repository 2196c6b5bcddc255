// The lookup as one C++ header: compiled on its own, in a program that is run.
#include <stratus/bsdf/bsdf.h>
#include <stratus/shader/shader.h>
#include <stratus/table/member_and_ground.h>

#include "indices.h"
#include "kinds.h"
#include "lookups.h"
#include "refusal.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace stratus::test {
namespace {

/// The program of lookup_program.cpp, compiled once.
class LookupHeader : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        folder_ = new TemporaryFolder;
        set_content(*folder_ / "stratus_lookup.h", shader_text(ShaderLanguage::cpp));
        const std::string path = folder_->path().string(),
                          command = std::string(STRATUS_CXX_COMPILER) +
                                    " -std=c++17 -O1 -Wall -Wextra -Wconversion -Werror -I" + path +
                                    " " STRATUS_LOOKUP_PROGRAM " -o " + path + "/look_up";
        ASSERT_EQ(std::system(command.c_str()), 0);
    }
    static void TearDownTestSuite() { delete folder_; }

    /// What the program finds, or says.
    template <class Row>
    static std::vector<Row> found(const std::vector<char>& table,
                                  const std::vector<Lookup>& lookups,
                                  const std::string& layer = "") {
        set_content(*folder_ / "table.stratus", {table.begin(), table.end()});
        set_content(*folder_ / "rows", {reinterpret_cast<const char*>(lookups.data()),
                                        lookups.size() * sizeof(Lookup)});
        const int code = run("table.stratus rows found " + layer);
        EXPECT_EQ(code, 0) << content(*folder_ / "said");
        const std::string bytes = content(*folder_ / "found");
        std::vector<Row> all(bytes.size() / sizeof(Row));
        std::memcpy(all.data(), bytes.data(), all.size() * sizeof(Row));
        EXPECT_EQ(all.size(), lookups.size());
        all.resize(lookups.size());
        return all;
    }

    static std::string refusal(const std::string& bytes, const std::string& layer = "") {
        set_content(*folder_ / "table.stratus", bytes);
        set_content(*folder_ / "rows", "");
        EXPECT_EQ(run("table.stratus rows found " + layer), 1 << 8);
        return content(*folder_ / "said");
    }

  private:
    static int run(const std::string& words) {
        const std::string path = folder_->path().string();
        return std::system(("cd " + path + " && ./look_up " + words + " > said").c_str());
    }

    static TemporaryFolder* folder_;
};
TemporaryFolder* LookupHeader::folder_ = nullptr;

struct TableRow {
    Light light;
    float brdf, direct;
};

std::vector<Light> lights_of(const std::vector<TableRow>& rows) {
    std::vector<Light> all;
    for (const TableRow& row : rows) all.push_back(row.light);
    return all;
}

struct LayerRow {
    float r, t, direct, bsdf;
    Vector wo;
    float pdf, pdf_again, weight;
};

std::vector<Kind> readable_kinds() {
    std::vector<Kind> all = kinds();
    for (Kind stack : stacks()) {
        stack.layers[1].phase_function = PhaseFunction::henyey_greenstein(-0.4);  // a closed form
        all.push_back(stack);
    }
    all.push_back(droplets);
    Kind rounded = droplets;
    rounded.tolerance = 1e-2;  // lets the path law be stored as halves
    all.push_back(rounded);
    return all;
}

TEST_F(LookupHeader, HasAtMost1500Lines) {
    EXPECT_LE(std::ranges::count(shader_text(ShaderLanguage::cpp), '\n'), 1500);
}

TEST_F(LookupHeader, LooksUpAsTheRuntime) {
    for (const Kind& kind : readable_kinds()) {
        SCOPED_TRACE(kind.name);
        const std::vector<char> file = pack(table_of(kind));
        const PackedTable table(file);
        std::vector<Lookup> lookups = random_lookups(table, 2000);
        const AxisView &w = table.view().albedo, &tau = table.view().optical_depth;
        for (std::size_t n = 0; n < 200 && !table.view().is_stack(); ++n) {
            lookups[n].albedo = static_cast<float>(n % 2 == 0 ? w.highest : w.lowest);
            if (tau.ends_at_infinity && n % 3 == 0)
                lookups[n].optical_depth = std::numeric_limits<float>::infinity();
            if (n % 3 == 1) lookups[n].optical_depth *= 1e-4f;  // thin
        }
        const std::vector<TableRow> rows = found<TableRow>(file, lookups);
        const Differences off = differences(lights_of(rows), by_runtime(table, lookups));
        EXPECT_LE(off.median, 1e-6);
        EXPECT_LE(off.worst, std::string(kind.name) == "droplets" ? 1e-3 : 1e-4);
        for (const auto n : indices(rows)) {
            const double r = double{rows[n].light[0]} + double{rows[n].light[1]};
            EXPECT_NEAR(double{rows[n].brdf} * pi, r,
                        1e-3 * r + 1e-6);  // cosines near 1 are rounded
            EXPECT_NEAR(rows[n].direct,
                        table.view().has_lower_boundary()
                            ? 0
                            : direct_transmittance(double{lookups[n].optical_depth},
                                                   double{lookups[n].mu_out}),
                        1e-6);
        }
    }
}

TEST_F(LookupHeader, LooksUpAMemberOfAFamily) {
    Kind other = kind_of("rings");
    other.phase = "rayleigh";
    const Table family = mixed(table_of(kind_of("rings")), table_of(other));
    const std::vector<char> file = pack(table_at(family, {0.4})), whole = pack(family);
    const PackedTable table(file);
    const std::vector<Lookup> lookups = random_lookups(table, 500);
    const Differences off =
        differences(lights_of(found<TableRow>(file, lookups)), by_runtime(table, lookups));
    EXPECT_LE(off.worst, 1e-4);
    expect_holds(refusal({whole.begin(), whole.end()}), "features must be of stack and path_law");
}

TEST_F(LookupHeader, GivesNotANumberForOne) {
    std::vector<Lookup> lookups(5, {0.9f, 1, 0.5f, 0.6f, 1});
    lookups[0].albedo = lookups[1].optical_depth = lookups[2].mu_in = lookups[3].mu_out =
        lookups[4].azimuth = NAN;
    for (const Kind& kind : kinds_of({"rings", "sampled_phase", "over_surface"}))
        for (const TableRow& row : found<TableRow>(pack(table_of(kind)), lookups)) {
            for (const float one : row.light) EXPECT_TRUE(std::isnan(one));
            EXPECT_TRUE(std::isnan(row.brdf));
        }
}

TEST_F(LookupHeader, BindsALayerAndDrawsItsDirections) {
    for (const Kind& kind : readable_kinds()) {
        if (kind.narrowed || kind.one_side || std::string(kind.name) == "endless_stack") continue;
        SCOPED_TRACE(kind.name);
        const std::vector<char> file = pack(table_of(kind));
        const PackedTable table(file);
        const bool one_sided = table.view().is_stack() || table.view().has_lower_boundary();
        const double tau = table.view().is_stack() ? table.view().optical_depth.lowest : 1,
                     w = table.view().is_stack() ? table.view().albedo.lowest : 0.7;
        const std::vector<Lookup> lookups = random_lookups(table, 2000);
        // Directions of one cosine: what they weigh has the mean that the runtime's fluxes have.
        std::vector<Lookup> alike = lookups;
        for (Lookup& at : alike) at.mu_in = 0.6f;
        const std::string layer = "0.4 1 6 0.9 0.7 0.99";
        for (const LayerRow& row : found<LayerRow>(file, lookups, layer)) {
            if (!(row.pdf > 0)) continue;
            EXPECT_NEAR(row.pdf_again, row.pdf, 2e-3 * double{row.pdf});
            EXPECT_NEAR(double{row.weight} * double{row.pdf},
                        double{row.bsdf} * std::abs(double{row.wo.z}), 1e-5 * double{row.bsdf});
        }
        const std::vector<LayerRow> rows = found<LayerRow>(file, alike, layer);
        double sum = 0, squares = 0, sphere = 0, sphere_squares = 0;
        for (const auto n : indices(rows)) {
            const LayerRow& row = rows[n];
            const Lookup& at = alike[n];
            const double r = table.reflection(w, tau, at.geometry()).total(),
                         t = table.transmission(w, tau, at.geometry()).total();
            EXPECT_NEAR(row.r, r, 1e-4 * r + 1e-6);
            EXPECT_NEAR(row.t, t, 1e-4 * t + 1e-6);
            EXPECT_NEAR(row.direct,
                        table.view().has_lower_boundary()
                            ? 0
                            : direct_transmittance(tau, double{at.mu_out}),
                        1e-6);
            sum += double{row.weight};
            squares += double{row.weight} * double{row.weight};
            sphere += row.pdf > 0 ? 1 / double{row.pdf} : 0;
            sphere_squares += row.pdf > 0 ? 1 / (double{row.pdf} * double{row.pdf}) : 0;
        }
        const auto expect_mean = [&](double total, double of_squares, double expected) {
            const double count = static_cast<double>(rows.size()), mean = total / count;
            const double deviation = std::sqrt((of_squares / count - mean * mean) / count);
            EXPECT_NEAR(mean, expected, 5 * deviation + 1e-4 * expected);
        };
        const RgbBsdf bsdf(RgbSlice(table.view(), {{tau, tau, tau}, {w, w, w}}));
        const auto shares = bsdf.albedo(0.6f);
        expect_mean(sum, squares, double{shares.reflected.g} + double{shares.transmitted.g});
        if (!one_sided && std::string(kind.name) != "droplets")
            expect_mean(sphere, sphere_squares, 4 * pi);
    }
}

TEST_F(LookupHeader, RefusesLayersOutsideTheTable) {
    const std::vector<char> finite = pack(table_of(kind_of("finite")));
    const std::string bytes(finite.begin(), finite.end());
    expect_holds(refusal(bytes, "1 1 100 1 1 1"), "Layer: optical_depth must be in [0, 8");
    expect_holds(refusal(bytes, "1 1 1 1 1.5 1"), "Layer: albedo must be in [");
    expect_holds(refusal(bytes, "1 1 1 1 nan 1"), "got nan");
    // Over a layer without end or an ocean no law is known of thinner layers than the first.
    for (const Kind& over : kinds_of({"over_layer", "over_ocean"})) {
        const std::vector<char> thick = pack(table_of(over));
        expect_holds(refusal({thick.begin(), thick.end()}, "1 0.01 1 1 1 1"),
                     "Layer: optical_depth must be in [0.05, 8");
    }
    // Nor does a single depth tell one, nor do deep ones.
    for (const auto& [depths, first] : {std::pair{1, 1.0}, {2, 4.0}}) {
        Table few = empty_table({6, depths, 12, 12, 1}, {first, first * depths, false});
        few.reflection_multiple = tabulate(few, [](const SamplePoint&) { return 1; });
        prepare(few);
        const std::vector<char> bytes_of_few = pack(few);
        expect_holds(
            refusal({bytes_of_few.begin(), bytes_of_few.end()}, "1 0.5 1 1 1 1"),
            first == 1 ? "Layer: optical_depth must be in [1, 1], got 0.5" : "must be in [4, 8");
    }
    Table endless = empty_table({6, 1, 12, 12, 1}, {8, 8, true});
    endless.optical_depth.values = {infinity};
    endless.reflection_multiple = tabulate(endless, [](const SamplePoint&) { return 1; });
    prepare(endless);
    const std::vector<char> deep = pack(endless);
    expect_holds(refusal({deep.begin(), deep.end()}, "1 1 1 1 1 1"),
                 "Layer: optical_depth must be in [inf, inf], got 1");
    const std::vector<char> narrowed = pack(table_of(kind_of("narrowed")));
    expect_holds(refusal({narrowed.begin(), narrowed.end()}, "1 1 1 1 1 1"), "all directions");
}

TEST_F(LookupHeader, RefusesFilesThatAreNone) {
    const std::vector<char> packed = pack(table_of(kind_of("rings")));
    const std::string file(packed.begin(), packed.end());
    const auto changed = [&](const std::string& from, const std::string& to) {
        std::string bytes = file;
        bytes.replace(bytes.find(from), from.size(), to);
        return bytes;
    };
    const std::pair<std::string, const char*> rows[] = {
        {"", "the file must be a packed table"},
        {"\x89HDF\r\n\x1a\n and more bytes of a file that is none", "the file must be a packed"},
        {file.substr(0, 100), "the file must be a packed table"},
        {file.substr(0, file.size() - 64), "data_offsets of"},
        {changed("\"stratus-packed\"", "\"stratus-pocket\""), "format must be stratus-packed"},
        {changed("\"format_version\":\"6\"", "\"format_version\":\"7\""),
         "format_version must be 6"},
        {changed("\"dtype\"", "\"dtpye\""), "of the file must be '['"},
        {changed("\"F64\"", "\"F65\""), "must be F16, F32, F64 or I32, got F65"},
        {changed("\"logarithmic\"", "\"lagorithmic\""), "optical_depth_scale must be logarithmic"},
        {changed("henyey_greenstein:g", "henyey_greenstone:g"), "phase must be given"}};
    for (const auto& [bytes, sentence] : rows) expect_holds(refusal(bytes), sentence);
    // Blocks of other layers than those that they serve.
    const std::size_t at = file.find("\"reflection/blocks\""),
                      offsets = file.find('[', file.find("data_offsets", at)) + 1;
    std::uint64_t length = 0;
    std::memcpy(&length, file.data(), sizeof length);
    const std::size_t first = 8 + length + std::stoul(file.substr(offsets));
    for (std::size_t field = 0; field < 6; ++field) {
        std::string bytes = file;
        const std::int32_t wrong = field == 1 || field == 3 ? 1 : 1000000;
        std::memcpy(&bytes[first + 4 * field], &wrong, sizeof wrong);
        expect_holds(refusal(bytes), "must be one that holds its samples");
    }
}

}  // namespace
}  // namespace stratus::test
