// Numbers as text: in full, so that they can be read back, rounded for people, and back.
#pragma once

#include <stratus/base/argument.h>

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

/// The numbers between two ends, which a square bracket includes and a round one does not: "[0, 1)",
/// "[1e-6, 1e9] or inf".
struct NumberRange {
    /// Errors   std::logic_error for another text.
    NumberRange(const char* range);

    /// False of nan.
    bool holds(double value) const;

    std::string text;
    double min, max;
    bool min_open, max_open, or_infinity;
};

/// Requires (argument.h) a value in a range, which more words may follow: "[0, 50] m/s".
template <class Value>
void require_in(const NumberRange& range, const char* function, const std::string& argument,
                const Value& value) {
    require(range.holds(static_cast<double>(value)), function, argument, "in " + range.text, value);
}

}  // namespace stratus
