// The text of a phase function, read from left to right.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace stratus {

struct PhaseText {
    std::string_view text;
    std::size_t at = 0;  // the next character

    /// Throws std::invalid_argument: the text, and what is wrong with it.
    [[noreturn]] void refuse(const std::string& what) const;

    /// What is left.
    std::string rest() const { return std::string(text.substr(at)); }

    // Each of these skips blanks first.
    bool at_end();
    bool next_is(char letter);
    /// Skips `letter` if it is next.
    bool accept(char letter);
    /// Reads a number if one is next.
    bool accept_number(double& value);
    /// Reads a number; refuses anything else, `meaning` being what the number is.
    double number(const std::string& meaning);
    /// Reads letters, digits, '_' and '-'; may be empty.
    std::string name();
    /// Reads `NAME=`, NAME one of the parameters that `owner` allows.
    std::string parameter(const std::string& owner, const std::vector<std::string>& allowed);
};

}  // namespace stratus
