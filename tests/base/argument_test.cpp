#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include "refusal.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <string>

namespace stratus {
namespace {

TEST(Require, AcceptsAConditionThatHolds) {
    EXPECT_NO_THROW(require(true, "doubling", "albedo", "in [0, 1]", 0.5));
}

TEST(Require, NamesFunctionArgumentRangeAndValue) {
    EXPECT_EQ(refusal([] { require(false, "doubling", "albedo", "in [0, 1]", 1.25); }),
              "doubling: albedo must be in [0, 1], got 1.25");
}

TEST(Require, SaysThatAnEmptyValueIsNothing) {
    EXPECT_EQ(
        refusal([] { require(false, "scene", "encoding", "\"srgb\" or \"data\"", std::string()); }),
        "scene: encoding must be \"srgb\" or \"data\", got nothing");
}

TEST(Require, ShowsNoMoreOfAValueThanPeopleRead) {
    const std::string much(4'000'000, 'x');
    const std::string said = refusal([&] { require(false, "doubling", much, "in [0, 1]", much); });
    EXPECT_LT(said.size(), 2 * max_shown + 60);
    expect_holds(said, "x must be in [0, 1], got x");
}

TEST(Shown, KeepsReadableText) {
    const std::string text = "d\u00e9j\u00e0 \u4e91 \U0001f327 'a'\\";
    EXPECT_EQ(shown(text), text);
    EXPECT_EQ(shown(""), "");
}

TEST(Shown, EscapesWhatATerminalObeys) {
    EXPECT_EQ(shown("a\x1b[2Jb\n\t\x7f"), "a\\x1b[2Jb\\x0a\\x09\\x7f");
    EXPECT_EQ(shown(std::string("\0", 1)), "\\x00");
    EXPECT_EQ(shown("\xc2\x9b\xc2\xa0"), "\\xc2\\x9b\xc2\xa0");  // C1, and a space
}

TEST(Shown, EscapesWhatIsNotUtf8) {
    EXPECT_EQ(shown("\xff"), "\\xff");
    EXPECT_EQ(shown("\xc3"), "\\xc3");                    // cut off
    EXPECT_EQ(shown("\xc0\x9b"), "\\xc0\\x9b");           // too long
    EXPECT_EQ(shown("\xed\xa0\x80"), "\\xed\\xa0\\x80");  // a surrogate
    EXPECT_EQ(shown("\x9b"), "\\x9b");
}

TEST(Shown, CutsTheMiddle) {
    EXPECT_EQ(shown("abcdefghijklmnopqrst", 20), "abcdefghijklmnopqrst");
    EXPECT_EQ(shown("abcdefghijklmnopqrstu", 20), "abcdefghijk ... rstu");
}

TEST(Shown, CutsBetweenCharactersOnly) {
    for (std::size_t most = 5; most < 40; ++most)
        for (const std::size_t count : {30u, 300u}) {
            std::string text(most % 2, 'a');
            for (std::size_t i = 0; i < count; ++i) text += "\u4e91";
            const std::string cut = shown(text, most);
            EXPECT_LE(cut.size(), most);
            EXPECT_EQ(cut.find('\\'), std::string::npos);
            EXPECT_EQ(shown(cut), cut);  // still UTF-8
        }
}

TEST(NearestName, IsSoonFoundForALongName) {  // ten million letters took seconds
    EXPECT_EQ(nearest_name("moments" + std::string(10'000'000, 'x'), {"x", "moments"}), "moments");
}

TEST(NearestName, IsTheOneWithTheFewestEdits) {
    const std::vector<std::string> known = {"isotropic", "rayleigh", "moments"};
    EXPECT_EQ(nearest_name("raleigh", known), "rayleigh");      // a letter is missing
    EXPECT_EQ(nearest_name("isotropiic", known), "isotropic");  // one is added
    EXPECT_EQ(nearest_name("nomemts", known), "moments");       // two are changed
}

TEST(NearestName, IsTheFirstOfEquallyNearOnes) { EXPECT_EQ(nearest_name("b", {"a", "c"}), "a"); }

TEST(NearestName, IsEmptyWithoutKnownNames) { EXPECT_EQ(nearest_name("x", {}), ""); }

TEST(ShortestText, ReadsBackAsTheSameNumber) {
    constexpr double largest = std::numeric_limits<double>::max(),
                     smallest = std::numeric_limits<double>::denorm_min();
    for (const double value : {1.0 / 3, 0.1 + 0.2, 1e22, -largest, -smallest})
        EXPECT_EQ(std::strtod(shortest_text(value).c_str(), nullptr), value);
}

TEST(ShortestText, IsTheShortest) {
    EXPECT_EQ(shortest_text(0.1), "0.1");
    EXPECT_EQ(shortest_text(2), "2");
    EXPECT_EQ(shortest_text(-infinity), "-inf");
}

TEST(ShortNumber, RoundsToItsDigits) {
    EXPECT_EQ(short_number(0.0123456), "0.012");
    EXPECT_EQ(short_number(-123456.7, 3), "-1.23e+05");
    EXPECT_EQ(short_number(0.5, 6), "0.5");
}

TEST(ReadNumber, ReturnsTheNumberOfCharactersRead) {
    double value = 0;
    EXPECT_EQ(read_number("0.25*next", value), 4u);
    EXPECT_EQ(value, 0.25);
    EXPECT_EQ(read_number("-1e-3", value), 5u);
    EXPECT_EQ(value, -1e-3);
    EXPECT_EQ(read_number("+7", value), 2u);
    EXPECT_EQ(value, 7);
    EXPECT_EQ(read_number("+-7", value), 0u);
    EXPECT_EQ(read_number("seven", value), 0u);
    EXPECT_EQ(read_number("", value), 0u);
}

}  // namespace
}  // namespace stratus
