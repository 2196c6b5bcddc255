#include <stratus/io/image.h>

#include "indices.h"
#include "refusal.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace stratus::test {
namespace {

Image ramp() {
    Image image(5, 3);
    for (const auto k : indices(image.rgb)) image.rgb[k] = 0.1f * static_cast<float>(k) - 1;
    return image;
}

TEST(ExrImage, RoundTripIsExact) {
    const TemporaryFolder folder;
    const Image image = ramp();
    write_exr_image(image, {{"scene", "title = 'x'"}}, folder / "a.exr");
    const Image read = read_exr_image(folder / "a.exr");
    EXPECT_EQ(read.width, 5);
    EXPECT_EQ(read.height, 3);
    EXPECT_EQ(read.rgb, image.rgb);
    expect_holds(content(folder / "a.exr"), "title = 'x'");
}

TEST(ExrImage, RefusesFilesThatNeedMoreMemoryThanAllowed) {
    const TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.exr";
    write_exr_image(ramp(), {}, path);
    const std::uintmax_t file = std::filesystem::file_size(path);
    const std::uintmax_t pixels = ramp().rgb.size() * sizeof(float);
    const auto refusal_of = [&](std::uintmax_t max_memory) {
        return refusal<std::runtime_error>([&] { read_exr_image(path, max_memory); });
    };
    const auto starts = [&](const std::string& message, const std::string& reason) {
        EXPECT_TRUE(message.starts_with(path.string() + ": " + reason)) << message;
        expect_holds(message, "more than the limit of ");
    };
    starts(refusal_of(file - 1), "reading the file needs ");
    const std::uintmax_t block = 3 * 256 * 5 * 3 * sizeof(float);
    starts(refusal_of(file + block - 1), "reading a block of the picture needs ");
    starts(refusal_of(file + block + pixels - 1), "reading the picture needs ");
    EXPECT_EQ(read_exr_image(path, file + block + pixels).rgb, ramp().rgb);
}

// OpenEXR takes memory for lines as long as a header says when it opens a file.
void expect_refused(const std::filesystem::path& path, const char* sentence) {
    expect_refusal<std::runtime_error>([&] { read_exr_image(path); }, sentence);
}

TEST(ExrImage, RefusesSizesBeforeItOpensAFile) {
    using namespace std::string_literals;
    const TemporaryFolder folder;
    write_exr_image(ramp(), {}, folder / "a.exr");
    const std::string picture = content(folder / "a.exr");
    const std::string window = "dataWindow\0box2i\0\x10\0\0\0"s;
    const std::size_t at = picture.find(window) + window.size();
    std::string wide = picture, high = picture, empty = picture;
    wide[at + 10] = '\x7f';
    high[at + 14] = '\x7f';
    empty[at + 3] = '\x7f';
    for (const std::string& damaged : {wide, high, empty}) {
        set_content(folder / "a.exr", damaged);
        expect_refused(folder / "a.exr",
                       "width and height of a picture and of its tiles must be in [1, 16384]");
    }
    std::string deep = picture;
    deep[5] = '\x08';
    set_content(folder / "a.exr", deep);
    expect_refused(folder / "a.exr", "a picture must not be deep");
}

TEST(ExrImage, RefusesAttributesLongerThanTheFile) {
    using namespace std::string_literals;
    const TemporaryFolder folder;
    set_content(folder / "a.exr", "\x76\x2f\x31\x01\x02\0\0\0name\0kind\0\0\0\0\x40"s);  // 1 GiB
    expect_refused(folder / "a.exr", "a header is truncated or damaged");
}

// OpenEXR goes by the type: it would read on before or after the attribute's end.
TEST(ExrImage, RefusesAttributesOfALengthThatIsNotTheirOwn) {
    using namespace std::string_literals;
    const TemporaryFolder folder;
    const std::string longer = "\x09\0\0\0"s + std::string(9, '\0');
    const std::string end = "\0name\0kind\0\0\0\0\x40"s;  // 1 GiB
    for (const char* const type :
         {"float", "v2f", "chlist", "preview", "stringvector", "floatvector"}) {
        set_content(folder / "a.exr",
                    "\x76\x2f\x31\x01\x02\0\0\0name\0"s + type + "\0"s + longer + end);
        expect_refused(folder / "a.exr", "a header has an attribute of the wrong length");
    }
}

TEST(ExrImage, NamesAnUnreadableFile) {
    const TemporaryFolder folder;
    set_content(folder / "a.exr", "no picture");
    expect_refused(folder / "a.exr", "a.exr");
    expect_refused(folder / "b.exr", "b.exr");
}

}  // namespace
}  // namespace stratus::test
