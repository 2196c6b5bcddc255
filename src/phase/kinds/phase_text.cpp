#include "phase_text.h"

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>

#include <algorithm>
#include <stdexcept>

namespace stratus {
namespace {

bool is_name_letter(char letter) {
    return (letter >= 'a' && letter <= 'z') || (letter >= 'A' && letter <= 'Z') ||
           (letter >= '0' && letter <= '9') || letter == '_' || letter == '-';
}

}  // namespace

void PhaseText::refuse(const std::string& what) const {
    throw std::invalid_argument(std::string(caller) + ": in '" + shown(std::string(text)) +
                                "': " + shown(what, max_message - 2 * max_shown));
}

bool PhaseText::at_end() {
    while (at < text.size() && (text[at] == ' ' || text[at] == '\t')) ++at;
    return at == text.size();
}

bool PhaseText::next_is(char letter) { return !at_end() && text[at] == letter; }

bool PhaseText::accept(char letter) {
    if (!next_is(letter)) return false;
    ++at;
    return true;
}

bool PhaseText::accept_number(double& value) {
    if (at_end()) return false;
    const std::size_t length = read_number(text.substr(at), value);
    at += length;
    return length > 0;
}

double PhaseText::number(const std::string& meaning) {
    double value = 0;
    if (!accept_number(value)) refuse(meaning + " must be a number, got '" + rest() + "'");
    return value;
}

std::string PhaseText::name() {
    at_end();
    const std::size_t begin = at;
    while (at < text.size() && is_name_letter(text[at])) ++at;
    return std::string(text.substr(begin, at - begin));
}

std::string PhaseText::csv_name(const std::vector<std::string>& parameters) {
    at_end();
    const std::size_t begin = at;
    const auto begins_parameter = [&](std::size_t comma) {
        PhaseText ahead{text, comma + 1, {}};
        const std::string name = ahead.name();
        return std::find(parameters.begin(), parameters.end(), name) != parameters.end() &&
               ahead.accept('=');
    };
    for (std::size_t end = begin; end < text.size(); ++end) {
        if (text[end] == ',' && begins_parameter(end)) break;
        if (text.compare(end, 3, " + ") == 0) break;
        if (end == begin || text.compare(end, 4, ".csv") != 0) continue;
        PhaseText behind{text, end + 4, {}};
        if (!behind.at_end() && !behind.next_is(',') && !behind.next_is('+')) continue;
        at = end + 4;
        return std::string(text.substr(begin, at - begin));
    }
    return "";
}

std::string PhaseText::parameter(const std::string& owner,
                                 const std::vector<std::string>& allowed) {
    const std::size_t begin = at;
    std::string met = name();
    if (std::find(allowed.begin(), allowed.end(), met) == allowed.end()) {
        if (!accept('='))
            refuse("parameter of " + owner + " must be written " + joined(allowed, "=... or ") +
                   "=..., got '" +
                   std::string(text.substr(begin, text.find_first_of(" \t", begin) - begin)) + "'");
        refuse("parameter of " + owner + " must be " + joined(allowed, " or ") + ", got '" + met +
               "'; did you mean '" + nearest_name(met, allowed) + "'?");
    }
    if (!accept('=')) refuse(owner + ": '=' must follow " + met + ", got '" + rest() + "'");
    return met;
}

}  // namespace stratus
