// The portrait of every kind of table is written, has the stated size, and shows something in each
// part of it. How good it looks is for eyes.
#include <stratus/picture/portrait.h>

#include "synthetic_table.h"
#include "temporary_folder.h"

#include <cairo.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>

/// Fontconfig keeps its cache to the end; a leak sanitizer that asks is told that it is no leak of
/// ours.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libfontconfig"; }

namespace stratus {
namespace {

using test::make_synthetic_table;
using test::SyntheticOptions;

class Portrait : public ::testing::Test {
  protected:
    test::TemporaryFolder folder;
};

/// A picture read back.
class Image {
  public:
    explicit Image(const std::filesystem::path& png)
        : surface_(cairo_image_surface_create_from_png(png.c_str()), &cairo_surface_destroy) {}

    bool is_valid() const { return cairo_surface_status(surface_.get()) == CAIRO_STATUS_SUCCESS; }
    int width() const { return cairo_image_surface_get_width(surface_.get()); }
    int height() const { return cairo_image_surface_get_height(surface_.get()); }

    /// Number of different colours in a rectangle.
    std::size_t colours(int x0, int y0, int x1, int y1) const {
        std::set<std::uint32_t> seen;
        for (int y = y0; y < y1; ++y)
            for (int x = x0; x < x1; ++x) seen.insert(pixel(x, y));
        return seen.size();
    }

    /// True when the outermost pixels are all alike: nothing is clipped by the picture's edge.
    bool has_clean_border() const {
        const std::uint32_t background = pixel(0, 0);
        for (int x = 0; x < width(); ++x)
            if (pixel(x, 0) != background || pixel(x, height() - 1) != background) return false;
        for (int y = 0; y < height(); ++y)
            if (pixel(0, y) != background || pixel(width() - 1, y) != background) return false;
        return true;
    }

  private:
    std::uint32_t pixel(int x, int y) const {
        std::uint32_t value;
        std::memcpy(&value,
                    cairo_image_surface_get_data(surface_.get()) +
                        y * cairo_image_surface_get_stride(surface_.get()) + 4 * x,
                    sizeof value);
        return value & 0xffffff;
    }

    std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface_;
};

struct Kind {
    const char* name;
    SyntheticOptions options;
};

class EveryTable : public Portrait, public ::testing::WithParamInterface<Kind> {};

TEST_P(EveryTable, IsDrawnAtTheStatedSizeAndWithinTheFrame) {
    const Table table = make_synthetic_table(GetParam().options);
    draw_portrait(table, folder / "portrait.png");

    const Image image(folder / "portrait.png");
    ASSERT_TRUE(image.is_valid());
    EXPECT_EQ(image.width(), 1600);
    EXPECT_EQ(image.width(), portrait_size(table).width);
    EXPECT_EQ(image.height(), portrait_size(table).height);
    EXPECT_TRUE(image.has_clean_border());
    constexpr std::size_t not_blank = 10;
    EXPECT_GT(image.colours(0, 0, 1600, 140), not_blank) << "title";
    EXPECT_GT(image.colours(0, 140, 1600, image.height() - 120), not_blank) << "lobes, spheres";
    EXPECT_GT(image.colours(0, image.height() - 110, 1600, image.height()), not_blank) << "legend";
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
INSTANTIATE_TEST_SUITE_P(Portrait, EveryTable, ::testing::ValuesIn(kinds),
                         [](const auto& row) { return row.param.name; });

TEST_F(Portrait, IsDrawnOfLayersOverGround) {
    Table bare = make_synthetic_table({.transmission = false});
    Table table = bare;
    table.lower_boundary = LowerBoundary::surface(0.3);
    prepare(table);
    draw_portrait(bare, folder / "bare.png");
    draw_portrait(table, folder / "ground.png");
    EXPECT_NE(test::content(folder / "bare.png"), test::content(folder / "ground.png"));
}

TEST_F(Portrait, IsTheSameEveryTime) {
    const Table table = make_synthetic_table();
    draw_portrait(table, folder / "first.png");
    draw_portrait(table, folder / "second.png");
    EXPECT_EQ(test::content(folder / "first.png"), test::content(folder / "second.png"));
}

TEST_F(Portrait, StaysInTheFrameWithLongWords) {
    SyntheticOptions options;
    options.phase_function = "rayleigh";
    for (int k = 1; k < 20; ++k)
        options.phase_function += " + henyey_greenstein:g=0." + std::to_string(k);
    Table table = make_synthetic_table(options);
    for (int k = 0; k < 40; ++k) table.attributes["title"] += " g\u00f6\u00f6d title";
    draw_portrait(table, folder / "portrait.png");
    EXPECT_TRUE(Image(folder / "portrait.png").has_clean_border());
}

TEST_F(Portrait, NeedsNoTitle) {
    Table table = make_synthetic_table();
    table.attributes.clear();
    draw_portrait(table, folder / "portrait.png");
    EXPECT_TRUE(Image(folder / "portrait.png").is_valid());
}

TEST_F(Portrait, RefusesAPathThatCannotBeWritten) {
    const std::filesystem::path png = folder / "absent" / "portrait.png";
    const std::string refusal =
        test::refusal<std::runtime_error>([&] { draw_portrait(make_synthetic_table(), png); });
    EXPECT_EQ(refusal, png.string() + ": No such file or directory");
}

TEST_F(Portrait, SaysWhenTheDiskIsFull) {
    if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
    EXPECT_THROW(draw_portrait(make_synthetic_table(), "/dev/full"), std::runtime_error);
}

}  // namespace
}  // namespace stratus
