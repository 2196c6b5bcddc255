// The text of a phase function, read from left to right (parse_phase_function.cpp).
#pragma once

#include <stratus/phase/phase_function.h>

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace stratus {

struct PhaseText {
    std::string_view text;
    std::size_t at = 0;         // the next character
    PhaseFileReader read_file;  // empty where no files are read
    const char* caller = "phase function";

    /// Throws std::invalid_argument: the text, and what is wrong with it.
    [[noreturn]] void refuse(const std::string& what) const;

    /// Returns the text that has not been read yet.
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
    /// Reads the name of a file up to its ending `.csv`, which must be followed by a ',', a '+' or
    /// nothing; empty, and nothing read, where there is no such name before `,NAME=`, NAME one of
    /// `parameters`, or before a '+' between blanks.
    std::string csv_name(const std::vector<std::string>& parameters);
    /// Reads `NAME=`, NAME one of the parameters that `owner` allows.
    std::string parameter(const std::string& owner, const std::vector<std::string>& allowed);
    /// Reads `NAME=NUMBER`, commas between, up to the end; each name once.
    std::map<std::string, double> numbers(const std::string& owner,
                                          const std::vector<std::string>& allowed);
};

}  // namespace stratus
