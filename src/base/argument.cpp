#include <stratus/base/argument.h>

#include <cstdint>

namespace stratus {

std::size_t character_length(const std::string& text, std::size_t at) {
    constexpr std::uint32_t least[] = {0, 0x80, 0x800, 0x10000};  // by bytes after the first
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const std::uint32_t first = byte(at);
    if (first < 0x80) return 1;
    if (first < 0xc0 || first >= 0xf8) return 0;
    const std::size_t more = first < 0xe0 ? 1 : first < 0xf0 ? 2 : 3;
    if (more >= text.size() - at) return 0;
    std::uint32_t character = first & (0x3fu >> more);
    for (std::size_t k = 1; k <= more; ++k) {
        if ((byte(at + k) & 0xc0) != 0x80) return 0;
        character = character << 6 | (byte(at + k) & 0x3fu);
    }
    const bool is_surrogate = character >= 0xd800 && character < 0xe000;
    return character < least[more] || character > 0x10ffff || is_surrogate ? 0 : more + 1;
}

namespace {

/// The control characters of ASCII and of Latin 1, which terminals obey.
bool is_control(const std::string& text, std::size_t at) {
    const auto first = static_cast<unsigned char>(text[at]);
    return first < 0x20 || first == 0x7f ||
           (first == 0xc2 && static_cast<unsigned char>(text[at + 1]) < 0xa0);
}

std::string escaped(const std::string& text) {
    constexpr char hex[] = "0123456789abcdef";
    std::string readable;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t length = character_length(text, at);
        const std::size_t end = at + std::max<std::size_t>(length, 1);
        if (length != 0 && !is_control(text, at)) {
            readable.append(text, at, length);
        } else {
            for (std::size_t i = at; i < end; ++i) {
                const auto byte = static_cast<unsigned char>(text[i]);
                readable += {'\\', 'x', hex[byte >> 4], hex[byte & 15]};
            }
        }
        at = end;
    }
    return readable;
}

bool is_inside_character(char byte) { return (byte & 0xc0) == 0x80; }

}  // namespace

std::string shown(const std::string& text, std::size_t most) {
    constexpr char gap[] = " ... ";
    constexpr std::size_t gap_size = sizeof gap - 1;
    // Escapes only lengthen it: beyond `most` bytes at either end nothing will be shown.
    const bool is_long = text.size() > 2 * most + 8;
    std::string readable = is_long ? escaped(text.substr(0, most + 4)) : escaped(text);
    if (readable.size() <= most) return readable;
    const std::string back = is_long ? escaped(text.substr(text.size() - most)) : readable;
    std::size_t end = most <= gap_size ? 0 : (most - gap_size) * 3 / 4;
    std::size_t begin = back.size() - (most <= gap_size ? 0 : most - gap_size - end);
    while (end > 0 && is_inside_character(readable[end])) --end;
    while (begin < back.size() && is_inside_character(back[begin])) ++begin;
    return readable.substr(0, end) + gap + back.substr(begin);
}

}  // namespace stratus
