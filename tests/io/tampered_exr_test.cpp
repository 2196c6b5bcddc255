// OpenEXR tables with changed headers are refused with the reason.
#include <stratus/io/table_file.h>

#include "refusal_of_reading.h"
#include "sample_table.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <string>

namespace stratus::test {
namespace {

namespace fs = std::filesystem;

/// Overwrites the value of the n-th attribute of this name, counted from 0.
std::string with_attribute(std::string bytes, const std::string& name, const std::string& type,
                           const std::string& value, int n = 0) {
    const std::string start = name + '\0' + type + '\0';
    std::size_t at = bytes.find(start);
    while (n-- > 0) at = bytes.find(start, at + 1);
    return bytes.replace(at + start.size() + sizeof(std::int32_t), value.size(), value);
}

std::string integers(std::initializer_list<std::int32_t> values) {
    std::string bytes;
    for (const std::int32_t value : values)
        bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    return bytes;
}

class TamperedExr : public testing::Test {
  protected:
    void SetUp() override {
        write_table(sample_table(), path);
        whole = content(path);
    }

    void expect_refusal(const std::string& bytes, const std::string& reason) {
        ASSERT_NE(bytes, whole);
        set_content(path, bytes);
        EXPECT_EQ(refusal_of_reading(path), path.string() + ": " + reason);
    }

    TemporaryFolder folder;
    const fs::path path = folder / "table.exr";
    std::string whole;
};

TEST_F(TamperedExr, RefusesHugeDataWindows) {
    const auto window = [&](std::int32_t x, std::int32_t y) {
        return with_attribute(whole, "dataWindow", "box2i", integers({0, 0, x, y}));
    };
    constexpr std::int32_t largest = std::numeric_limits<std::int32_t>::max();
    expect_refusal(window(largest, largest),
                   "a data window must not be larger than 16777216 on a side");
    expect_refusal(window(1 << 20, 1 << 20), "a data window is larger than 8 GiB");
    expect_refusal(window(1 << 15, 1 << 13), "a data window is larger than what the file holds");
    expect_refusal(window(-1, 3), "a data window must begin at 0, 0");
}

TEST_F(TamperedExr, RefusesADataWindowThatDoesNotMatchTheAxes) {
    expect_refusal(with_attribute(whole, "dataWindow", "box2i", integers({0, 0, 49, 7})),
                   "data window of reflection_multiple does not match its axes");
}

TEST_F(TamperedExr, RefusesAnotherCompression) {
    expect_refusal(with_attribute(whole, "compression", "compression", "\x03"),
                   "reflection_multiple must have PIZ compression");
}

TEST_F(TamperedExr, RefusesOtherChannels) {
    const std::string reason = "reflection_multiple must have one channel, Y, of 32-bit floats";
    expect_refusal(with_attribute(whole, "channels", "chlist", "Z"), reason);
}

TEST_F(TamperedExr, RefusesDuplicateAttributes) {
    const std::string twice = "stratus:format_version";
    std::string doubled = whole;
    doubled.replace(doubled.find("stratus:measured_error"), twice.size(), twice);
    expect_refusal(doubled, "duplicate attribute \"stratus:format_version\"");
}

TEST_F(TamperedExr, RefusesARenamedPart) {
    expect_refusal(with_attribute(whole, "name", "string", "plane_albed0", 2),
                   "part plane_albedo is missing");
}

TEST_F(TamperedExr, RefusesAttributesOfOtherTypes) {
    std::string bytes = whole;
    bytes.replace(bytes.find("v2f"), 3, "m33");
    expect_refusal(bytes, "a header has an attribute of an unsupported type");
}

TEST_F(TamperedExr, RefusesAttributesOfTheWrongLength) {
    std::string bytes = whole;
    const std::string start("screenWindowCenter\0v2f\0", 23);
    bytes.replace(bytes.find(start) + start.size(), 4, integers({30}));
    expect_refusal(bytes, "a header has an attribute of the wrong length");
}

TEST_F(TamperedExr, RefusesSeveralChannels) {
    std::string bytes = whole;
    const std::string start("channels\0chlist\0", 16);
    const std::size_t at = bytes.find(start) + start.size();
    const std::string channel = bytes.substr(at + 4, 18);
    bytes.replace(at, 4 + 18, integers({2 * 18 + 1}) + channel + channel);
    expect_refusal(bytes, "a part must have one channel, Y, of 32-bit floats");
}

TEST_F(TamperedExr, RefusesChannelsThatEndElsewhere) {
    expect_refusal(with_attribute(whole, "channels", "chlist", "YY"),
                   "a header has an attribute of the wrong length");
}

TEST_F(TamperedExr, RefusesAttributesBeyondTheEndOfTheFile) {
    std::string bytes = whole;
    const std::string start("stratus:title\0string\0", 21);
    bytes.replace(bytes.find(start) + start.size(), 4, integers({1 << 30}));
    expect_refusal(bytes, "a header is truncated or damaged");
}

TEST_F(TamperedExr, RefusesChangedAxes) {
    std::string bytes = whole;
    const std::string start("dataset:diffusion_exponent\0string\0", 34);
    bytes[bytes.find(start) + start.size() + 8] = '4';
    set_content(path, bytes);
    EXPECT_TRUE(refusal_of_reading(path).starts_with(path.string() +
                                                     ": the metadata was changed or damaged"));
}

}  // namespace
}  // namespace stratus::test
