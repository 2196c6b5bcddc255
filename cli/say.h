// Lines on stderr: refusals, notes, warnings. What they repeat of files is made fit for a terminal.
#pragma once

#include <stratus/base/argument.h>

#include <algorithm>
#include <iostream>
#include <string>

namespace stratus {

/// Writes the line "stratus: MESSAGE" on stderr, as shown() has it, at most `max_message` bytes.
inline void say(std::string message) {
    std::replace(message.begin(), message.end(), '\n', ' ');
    std::cerr << "stratus: " + shown(message, max_message) + '\n';
}

}  // namespace stratus
