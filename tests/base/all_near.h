// Lists of numbers beside one another.
#pragma once

#include "indices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>

/// Each number within `relative` of the expected one's size, and `absolute` more.
template <class Found, class Expected>
void expect_all_near(const Found& found, const Expected& expected, double relative,
                     double absolute = 0) {
    ASSERT_EQ(std::size(found), std::size(expected));
    for (const auto n : indices(found))
        ASSERT_NEAR(found[n], expected[n], relative * std::abs(expected[n]) + absolute) << n;
}
