// What tests of the C interface share.
#pragma once

#include <stratus/stratus.h>

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

/// Ends the test unless a call succeeded.
inline void check_ok(int status) {
    if (status != STRATUS_OK) throw std::runtime_error(stratus_last_error());
}

/// Expects a refusal whose text holds `part`.
inline void expect_refused(int status, const std::string& part,
                           int expected = STRATUS_INVALID_ARGUMENT) {
    EXPECT_EQ(status, expected);
    EXPECT_NE(std::string(stratus_last_error()).find(part), std::string::npos)
        << stratus_last_error();
}

inline stratus_table_info described(const stratus_table* table) {
    stratus_table_info info{};
    info.size = sizeof info;
    check_ok(stratus_table_describe(table, &info));
    return info;
}
