// The message of a refused argument: function, argument, allowed range and the value met.
//
// Whatever constructs or loads checks its arguments on entry and throws std::invalid_argument with
// such a line. Lookups throw nothing. What a message repeats of a file or of what somebody typed may
// be long and may hold anything; shown() makes it fit to be read.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace stratus {

/// Most bytes that a message shows of one name or value, and of everything together.
constexpr std::size_t max_shown = 400, max_message = 2000;

/// Bytes of the character of UTF-8 that begins at `at`; 0 where none does.
std::size_t character_length(const std::string& text, std::size_t at);

/// A text from outside as a message shows it: control characters and what is not UTF-8 are written
/// as bytes, "\x1b", and at most `most` bytes stay, " ... " standing for what was in the middle.
std::string shown(const std::string& text, std::size_t most = max_shown);

/// Throws std::invalid_argument "function: argument must be allowed, got value" unless `holds`;
/// argument and value as shown() has them.
template <class Value>
void require(bool holds, const char* function, const std::string& argument,
             const std::string& allowed, const Value& value) {
    if (holds) return;
    std::ostringstream line;
    line << function << ": " << shown(argument) << " must be " << allowed << ", got ";
    if constexpr (std::is_floating_point_v<Value>) {  // the shortest text that reads back the same
        char text[40];
        line.write(text, std::to_chars(text, text + sizeof text, value).ptr - text);
    } else {
        std::ostringstream text;
        text << value;
        const std::string met = text.str();
        line << (met.empty() ? "nothing" : shown(met));
    }
    throw std::invalid_argument(line.str());
}

/// The words with `between` between them: "red, green".
inline std::string joined(const std::vector<std::string>& words, const char* between = ", ") {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
    return text;
}

inline bool is_listed(const std::string& word, const std::vector<std::string>& words) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

/// The known name nearest to `given`, by letters changed, added or left out; empty when none is
/// known.
inline std::string nearest_name(const std::string& given, const std::vector<std::string>& known) {
    const std::string met = given.substr(0, max_shown);  // what follows is no slip of the pen
    std::string nearest;
    std::size_t least = 0;
    for (const std::string& name : known) {
        std::vector<std::size_t> edits(name.size() + 1);  // from the first i letters of `met`
        for (std::size_t j = 0; j <= name.size(); ++j) edits[j] = j;
        for (std::size_t i = 0; i < met.size(); ++i) {
            std::size_t diagonal = edits[0]++;
            for (std::size_t j = 0; j < name.size(); ++j) {
                const std::size_t change = diagonal + (met[i] == name[j] ? 0 : 1);
                diagonal = edits[j + 1];
                edits[j + 1] = std::min({change, edits[j] + 1, edits[j + 1] + 1});
            }
        }
        if (!nearest.empty() && edits.back() >= least) continue;
        nearest = name;
        least = edits.back();
    }
    return nearest;
}

}  // namespace stratus
