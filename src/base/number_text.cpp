#include <stratus/base/number_text.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <system_error>

namespace stratus {

std::string shortest_text(double value) {
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string short_number(double value, int digits) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    return text;
}

std::size_t read_number(std::string_view text, double& value) noexcept {
    const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
    const char* const begin = text.data() + (plus ? 1 : 0);
    const std::from_chars_result read = std::from_chars(begin, text.data() + text.size(), value);
    if (read.ec != std::errc() || std::isnan(value)) return 0;
    return static_cast<std::size_t>(read.ptr - text.data());
}

}  // namespace stratus
