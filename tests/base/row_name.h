// Names of the rows of parameterised tests.
#pragma once

#include <string>

/// The `name` of a row, for INSTANTIATE_TEST_SUITE_P.
inline constexpr auto row_name = [](const auto& row) { return std::string(row.param.name); };
