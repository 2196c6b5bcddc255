#include <stratus/base/number_text.h>

#include <stratus/base/constants.h>

#include <charconv>
#include <cmath>
#include <stdexcept>
#include <system_error>

namespace stratus {

std::string shortest_text(double value) {
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string short_number(double value, int digits) {
    char text[32];
    return {text,
            std::to_chars(text, text + sizeof text, value, std::chars_format::general, digits).ptr};
}

std::size_t read_number(std::string_view text, double& value) noexcept {
    const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
    const char* const begin = text.data() + (plus ? 1 : 0);
    const std::from_chars_result read = std::from_chars(begin, text.data() + text.size(), value);
    if (read.ec != std::errc() || std::isnan(value)) return 0;
    return static_cast<std::size_t>(read.ptr - text.data());
}

namespace {

double number_in(const std::string& text) {
    double value = 0;
    if (text.empty() || read_number(text, value) != text.size())
        throw std::logic_error("no number in a range: " + text);
    return value;
}

}  // namespace

NumberRange::NumberRange(const char* range) : text(range) {
    const std::size_t comma = text.find(", "), end = text.find_first_of("])");
    if ((text[0] != '[' && text[0] != '(') || comma == text.npos || end == text.npos || end < comma)
        throw std::logic_error("not a range of numbers: " + text);
    min = number_in(text.substr(1, comma - 1));
    max = number_in(text.substr(comma + 2, end - comma - 2));
    min_open = text[0] == '(';
    max_open = text[end] == ')';
    or_infinity = text.substr(end + 1) == " or inf";
}

bool NumberRange::holds(double value) const {
    return (value >= min && value <= max && !(min_open && value == min) &&
            !(max_open && value == max)) ||
           (or_infinity && value == infinity);
}

}  // namespace stratus
