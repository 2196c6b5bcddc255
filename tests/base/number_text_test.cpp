#include <stratus/base/number_text.h>

#include <stratus/base/constants.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

namespace stratus {
namespace {

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
