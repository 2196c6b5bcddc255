// What the value of an option may be, told in the words of every other refusal: the option, the
// allowed range and the value met.
//
// CLI11 alone would read an empty value as zero and 010 as eight.
#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace stratus {

/// A number for which `holds`; never nan. `allowed` names its range: "in [0, 1]".
CLI::Validator number(const std::string& allowed, bool (*holds)(double value));

/// A decimal whole number in [least, most].
CLI::Validator whole_number(long long least, long long most);

/// Anything but an empty text, which a script passes when its variable is not set.
CLI::Validator file_name();

/// The option --threads; `more` ends the words of its help.
void add_threads(CLI::App& command, int& threads, const std::string& more = "");

}  // namespace stratus
