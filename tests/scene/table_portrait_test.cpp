// The portrait of every kind of table is written, has the stated size, and shows something in each
// part of it. Its looks are checked visually.
#include <stratus/base/constants.h>
#include <stratus/picture/png.h>
#include <stratus/scene/render.h>

#include "refusal.h"
#include "row_name.h"
#include "synthetic_table.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

/// Fontconfig never frees its cache, in any test of the program.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libfontconfig"; }

namespace stratus::test {
namespace {

class TablePortrait : public ::testing::Test {
  protected:
    TemporaryFolder folder;
};

/// Number of different colours in a rectangle.
std::size_t colours(const Image& image, int x0, int y0, int x1, int y1) {
    std::set<std::vector<float>> seen;
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) seen.emplace(image.pixel(x, y), image.pixel(x, y) + 3);
    return seen.size();
}

/// True when the outermost pixels are all alike: nothing is clipped by the picture's edge.
bool has_clean_border(const Image& image) {
    const int right = image.width - 1, bottom = image.height - 1;
    return colours(image, 0, 0, image.width, 1) == 1 &&
           colours(image, 0, bottom, image.width, image.height) == 1 &&
           colours(image, 0, 0, 1, image.height) == 1 &&
           colours(image, right, 0, image.width, image.height) == 1;
}

struct Kind {
    const char* name;
    SyntheticOptions options;
};

class EveryTable : public TablePortrait, public ::testing::WithParamInterface<Kind> {};

TEST_P(EveryTable, IsDrawnAtTheStatedSizeWithinTheFrame) {
    const Table table = make_synthetic_table(GetParam().options);
    const Portrait portrait = make_portrait(table, table.view());
    draw_portrait(portrait, folder / "portrait.png");

    const Image image = read_png(folder / "portrait.png");
    EXPECT_EQ(image.width, 1600);
    EXPECT_EQ(image.width, portrait_size(portrait).width);
    EXPECT_EQ(image.height, portrait_size(portrait).height);
    EXPECT_TRUE(has_clean_border(image));
    constexpr std::size_t not_blank = 10;
    EXPECT_GT(colours(image, 0, 0, 1600, 140), not_blank) << "title";
    EXPECT_GT(colours(image, 0, 140, 1600, image.height - 120), not_blank) << "lobes, spheres";
    EXPECT_GT(colours(image, 0, image.height - 110, 1600, image.height), not_blank) << "legend";
}

const Kind kinds[] = {
    {"Rings", {}},
    {"Endless", {.and_infinity = true}},
    {"OnlyEndlessIsotropicOneAlbedo",
     {.phase_function = "isotropic",
      .finite_depths = 0,
      .and_infinity = true,
      .lowest_albedo = 0.9,
      .highest_albedo = 0.9,
      .albedos = 1,
      .azimuths = 1,
      .transmission = false}},
    {"OneDepth", {.lowest_depth = 2, .highest_depth = 2, .finite_depths = 1}},
    {"OneDepthAndEndless",
     {.lowest_depth = 2, .highest_depth = 2, .finite_depths = 1, .and_infinity = true}},
    {"NarrowDepths", {.lowest_depth = 1, .highest_depth = 1.01, .finite_depths = 4}},
    {"VeryThin", {.lowest_depth = 1e-6, .highest_depth = 1e-3, .finite_depths = 11}},
    {"VeryDeep", {.lowest_depth = 100, .highest_depth = 1e6, .finite_depths = 14}},
    {"OnlyReflection", {.transmission = false}},
    {"OnlyTransmission", {.reflection = false}},
    {"Peaked", {.phase_function = "henyey_greenstein:g=0.95", .and_infinity = true}},
    {"Black", {.lowest_albedo = 0, .highest_albedo = 0, .albedos = 1}},
};
INSTANTIATE_TEST_SUITE_P(TablePortrait, EveryTable, ::testing::ValuesIn(kinds), row_name);

TEST_F(TablePortrait, ShowsALowerBoundary) {
    Table bare = make_synthetic_table({.transmission = false});
    Table table = bare;
    table.lower_boundary = LowerBoundary::surface(0.3);
    prepare(table);
    draw_portrait(make_portrait(bare, bare.view()), folder / "bare.png");
    draw_portrait(make_portrait(table, table.view()), folder / "ground.png");
    EXPECT_NE(content(folder / "bare.png"), content(folder / "ground.png"));
}

/// The law for a layer that scatters once: I/F = w phi / 4 mu0 / (mu + mu0) where tau = inf.
TEST_F(TablePortrait, SphereShowsSingleScatteringInClosedForm) {
    const Table table = make_synthetic_table(
        {.phase_function = "isotropic", .finite_depths = 0, .and_infinity = true});
    const PortraitColumn column = make_portrait(table, table.view()).columns.at(0);
    const Image& sphere = column.single_sphere;
    const double mu_in = std::cos(radians(40));
    EXPECT_NEAR(sphere.pixel(sphere.width / 2, sphere.height / 2)[0], 0.25 * mu_in / (1 + mu_in),
                1e-3);
    EXPECT_GT(column.sphere.pixel(sphere.width / 2, sphere.height / 2)[0],
              sphere.pixel(sphere.width / 2, sphere.height / 2)[0]);
}

TEST_F(TablePortrait, IsReproducible) {
    const Table table = make_synthetic_table();
    draw_portrait(make_portrait(table, table.view()), folder / "first.png");
    draw_portrait(make_portrait(table, table.view()), folder / "second.png");
    EXPECT_EQ(content(folder / "first.png"), content(folder / "second.png"));
}

TEST_F(TablePortrait, TruncatesLongText) {
    SyntheticOptions options;
    options.phase_function = "rayleigh";
    for (int k = 1; k < 20; ++k)
        options.phase_function += " + henyey_greenstein:g=0." + std::to_string(k);
    Table table = make_synthetic_table(options);
    for (int k = 0; k < 40; ++k) table.attributes["title"] += " g\u00f6\u00f6d title";
    draw_portrait(make_portrait(table, table.view()), folder / "portrait.png");
    EXPECT_TRUE(has_clean_border(read_png(folder / "portrait.png")));
}

TEST_F(TablePortrait, NeedsNoTitle) {
    Table table = make_synthetic_table();
    table.attributes.clear();
    draw_portrait(make_portrait(table, table.view()), folder / "portrait.png");
    EXPECT_EQ(read_png(folder / "portrait.png").width, 1600);
}

TEST_F(TablePortrait, RefusesAPathThatCannotBeWritten) {
    const Table table = make_synthetic_table();
    const std::filesystem::path png = folder / "absent" / "portrait.png";
    const std::string said = refusal<std::runtime_error>(
        [&] { draw_portrait(make_portrait(table, table.view()), png); });
    EXPECT_EQ(said, png.string() + ": No such file or directory");
}

TEST_F(TablePortrait, ReportsAFullDisk) {
    if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
    const Table table = make_synthetic_table();
    EXPECT_THROW(draw_portrait(make_portrait(table, table.view()), "/dev/full"),
                 std::runtime_error);
}

}  // namespace
}  // namespace stratus::test
