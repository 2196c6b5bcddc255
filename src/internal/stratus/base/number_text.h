// Numbers as text: in full, so that they can be read back, rounded for people, and back.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace stratus {

/// The shortest text that reads back as the same double.
std::string shortest_text(double value);

/// `digits` significant digits, as printf's %g writes them.
std::string short_number(double value, int digits = 2);

/// Reads the number at the front of `text` (decimal, `inf` allowed) into `value`, in the C locale
/// whatever the program's. Returns the number of characters read: 0 when there is no number, it
/// overflows, or is NaN.
std::size_t read_number(std::string_view text, double& value) noexcept;

}  // namespace stratus
