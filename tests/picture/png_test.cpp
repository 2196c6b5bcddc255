#include <stratus/picture/png.h>

#include "refusal.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

TEST(Srgb, EncodesAndDecodes) {
    // [IEC 61966-2-1]: a number of 188 of 255 is half the light.
    EXPECT_NEAR(255 * srgb_encoded(0.5), 187.5, 0.1);
    EXPECT_EQ(srgb_encoded(-1), 0);
    EXPECT_EQ(srgb_encoded(NAN), 0);
    EXPECT_DOUBLE_EQ(srgb_encoded(3), 1);
    for (const double light : {0.0, 0.001, 0.0031308, 0.02, 0.7, 1.0})
        EXPECT_NEAR(srgb_decoded(srgb_encoded(light)), light,
                    1e-8);  // the mismatch of its two parts
}

TEST(Png, RoundTripsToEightBits) {
    const TemporaryFolder folder;
    Image image(3, 2);
    const float light[] = {0, 0.01f, 0.2f, 0.5f, 1, 2};
    for (int k = 0; k < 6; ++k)
        for (int c = 0; c < 3; ++c) image.pixel(k % 3, k / 3)[c] = light[(k + c) % 6];
    write_png(image, 0.5, {}, folder / "a.png");
    const Image read = read_png(folder / "a.png");
    ASSERT_EQ(read.width, 3);
    ASSERT_EQ(read.height, 2);
    for (int k = 0; k < 6; ++k)
        for (int c = 0; c < 3; ++c) {
            const double shown = std::min(1.0, 2 * double{light[(k + c) % 6]});
            // half a step of 255
            EXPECT_NEAR(srgb_encoded(double{read.pixel(k % 3, k / 3)[c]}), srgb_encoded(shown),
                        0.5 / 255 + 1e-6);
        }
}

TEST(Png, ReadsNumbersAsLightOrAsTheyAre) {
    const TemporaryFolder folder;
    Image image(1, 1);
    for (float& channel : image.rgb) channel = static_cast<float>(srgb_decoded(128 / 255.0));
    write_png(image, 1, {}, folder / "grey.png");
    EXPECT_FLOAT_EQ(read_png(folder / "grey.png").rgb[0], image.rgb[0]);
    EXPECT_FLOAT_EQ(read_png(folder / "grey.png", 0, PngEncoding::data).rgb[0], 128 / 255.0f);
}

TEST(Png, ShowsLabels) {
    const TemporaryFolder folder;
    const Image image(60, 30);
    write_png(image, 1, {{5, 20, 50, "words"}}, folder / "a.png");
    double sum = 0;
    for (const float value : read_png(folder / "a.png").rgb) sum += double{value};
    EXPECT_GT(sum, 10);
}

TEST(Png, TruncatesLabelsAndShowsThemInOneLine) {
    const TemporaryFolder folder;
    const auto shown = [&](const std::string& text) {
        write_png(Image(120, 30), 1, {{5, 20, 50, text}}, folder / "a.png");
        return read_png(folder / "a.png").rgb;
    };
    const std::vector<float> wide = shown("words that are wider than 50 pixels");
    for (int y = 0; y < 30; ++y)
        for (int x = 58; x < 120; ++x)  // 3 of the rim
            ASSERT_EQ(wide[static_cast<std::size_t>(3 * (120 * y + x))], 0) << x;
    EXPECT_EQ(shown("a\nb"), shown("a b"));
}

TEST(Png, NamesAFileThatIsNotOne) {
    const TemporaryFolder folder;
    set_content(folder / "a.png", "no picture");
    for (const char* const name : {"a.png", "b.png"})
        EXPECT_NE(refusal<std::runtime_error>([&] { read_png(folder / name); }).find(name),
                  std::string::npos);
}

TEST(Png, RespectsTheMemoryLimit) {
    const TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.png";
    write_png(Image(30, 20), 1, {}, path);
    constexpr std::uintmax_t needed = 30 * 20 * 20;
    const std::string message = refusal<std::runtime_error>([&] { read_png(path, needed - 1); });
    EXPECT_TRUE(message.starts_with(path.string() + ": reading the picture needs ")) << message;
    EXPECT_EQ(read_png(path, needed).width, 30);
}

TEST(Png, RefusesSidesAboveTheMaximum) {
    const TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.png";
    write_png(Image(3, 2), 1, {}, path);
    const std::string whole = content(path);
    for (const std::size_t side_at : {16U, 20U}) {
        set_content(path, std::string(whole).replace(side_at, 4, {0, 0, 0x40, 1}));
        EXPECT_EQ(refusal<std::runtime_error>([&] { read_png(path); }),
                  path.string() + ": a picture must have sides in [1, 16384]");
    }
}

}  // namespace
}  // namespace stratus::test
