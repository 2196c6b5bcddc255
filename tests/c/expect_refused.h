// What tests of the C interface share.
#pragma once

#include <stratus/stratus.h>

#include <gtest/gtest.h>

#include <string>

/// Expects a refusal whose text holds `part`.
inline void expect_refused(int status, int expected, const std::string& part) {
    EXPECT_EQ(status, expected);
    EXPECT_NE(std::string(stratus_last_error()).find(part), std::string::npos)
        << stratus_last_error();
}
