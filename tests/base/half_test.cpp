#include <stratus/base/half.h>

#include "instruction_sets.h"
#include "uniform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace stratus {
namespace {

constexpr unsigned first_infinite = 0x7c00;  // exponent all ones

float half_value(unsigned bits) { return to_float(Half{static_cast<std::uint16_t>(bits)}); }

TEST(Half, IsWhatIeeeSays) {
    for (const unsigned sign : {0u, 0x8000u})
        for (unsigned bits = 0; bits < first_infinite; ++bits) {
            const int exponent = static_cast<int>(bits >> 10), fraction = bits & 0x3ff;
            const double magnitude = exponent == 0 ? std::ldexp(fraction, -24)
                                                   : std::ldexp(1024 + fraction, exponent - 25);
            const float value = half_value(sign | bits);
            ASSERT_EQ(std::abs(value), magnitude) << bits;
            ASSERT_EQ(std::signbit(value), sign != 0) << bits;
        }
    EXPECT_EQ(half_value(first_infinite - 1), largest_half);
    EXPECT_EQ(half_value(0x400), 0x1p-14f);
}

void expect_round_trips() {
    for (const unsigned sign : {0u, 0x8000u})
        for (unsigned bits = 0; bits < first_infinite; ++bits)
            ASSERT_EQ(to_half(half_value(sign | bits)).bits, sign | bits);
}

TEST(Half, ComesBackFromItsFloat) { expect_round_trips(); }

TEST(Half, KeepsItsSubnormalsWhereFloatsLoseTheirs) {
    const SubnormalsAsZero mode;
    expect_round_trips();
    EXPECT_EQ(half_value(1), 0x1p-24f);
}

TEST(Half, IsTheNearestToANumber) {
    Uniform<float> uniform(1, 1, 2);
    for (int i = 0; i < 100000; ++i) {
        const float number = std::ldexp(uniform(), i % 29 - 14) * (i % 2 == 0 ? 1.f : -1.f);
        // Half a step of 2^-10 at the front of each octave.
        EXPECT_LE(std::abs(to_float(to_half(number)) - number),
                  std::ldexp(0.5f, std::ilogb(number) - 10));
    }
}

TEST(Half, IsEvenWhereTwoAreEquallyNear) {
    EXPECT_EQ(to_float(to_half(1 + 1.f / 2048)), 1);
    EXPECT_EQ(to_float(to_half(1 + 3.f / 2048)), 1 + 4.f / 2048);
    EXPECT_EQ(to_float(to_half(-1 - 1.f / 2048)), -1);
}

TEST(Half, IsClampedBeyondItsRange) {
    EXPECT_EQ(to_float(to_half(1e30f)), largest_half);
    EXPECT_EQ(to_float(to_half(-65519.f)), -largest_half);
    EXPECT_EQ(to_float(to_half(1e-9f)), 0);
    EXPECT_EQ(to_float(to_half(0x1p-25f)), 0);  // even
    EXPECT_EQ(to_float(to_half(0x1.8p-24f)), 0x1p-23f);
    EXPECT_EQ(to_float(to_half(0x1.ffep-15f)), 0x1p-14f);
}

}  // namespace
}  // namespace stratus
