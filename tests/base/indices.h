// Loops over indices, and comparisons of as many numbers.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <iterator>

/// 0 to a count less one, in a loop over a range.
class IndicesBelow {
  public:
    explicit IndicesBelow(std::size_t count) : count_(count) {}

    struct Index {
        std::size_t n;

        std::size_t operator*() const { return n; }
        Index& operator++() { return ++n, *this; }
        bool operator!=(const Index& other) const { return n != other.n; }
    };
    Index begin() const { return {0}; }
    Index end() const { return {count_}; }

  private:
    std::size_t count_;
};

/// Those of a container or an array, whose size must not change meanwhile.
auto indices(const auto& of) { return IndicesBelow(std::size(of)); }

/// Each number within `relative` of the expected one's size, and `absolute` more.
template <class Found, class Expected>
void expect_all_near(const Found& found, const Expected& expected, double relative,
                     double absolute = 0) {
    ASSERT_EQ(std::size(found), std::size(expected));
    for (const auto n : indices(found))
        ASSERT_NEAR(found[n], expected[n], relative * std::abs(expected[n]) + absolute) << n;
}

/// Those of red, green and blue.
inline const IndicesBelow three_channels(3);
