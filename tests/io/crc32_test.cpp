#include "crc32.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <random>
#include <string_view>
#include <vector>

#include <zlib.h>

namespace stratus::io {
namespace {

TEST(Crc32, HasItsCheckValue) {
    constexpr std::string_view digits = "123456789";  // the check of the Rocksoft model
    EXPECT_EQ(crc32(digits), 0xcbf43926u);
    EXPECT_EQ(crc32(std::span<const char>()), 0u);
}

TEST(Crc32, IsThatOfZlibAtEveryLengthAndAlignment) {
    std::mt19937 random(1);
    std::vector<char> bytes(5000);
    for (char& byte : bytes) byte = static_cast<char>(random());
    for (std::size_t first = 0; first < 17; ++first)
        for (std::size_t length = 0; length < 400; ++length) {
            const auto some = std::span<const char>(bytes).subspan(first, length);
            ASSERT_EQ(crc32(some), ::crc32(0, reinterpret_cast<const Bytef*>(some.data()),
                                           static_cast<uInt>(some.size())))
                << first << ' ' << length;
        }
    EXPECT_EQ(crc32(bytes), ::crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), uInt{5000}));
}

}  // namespace
}  // namespace stratus::io
