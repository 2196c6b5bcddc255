// What a refused call says, for tests of refusals.
#pragma once

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

/// A text that must be refused, for parameterised tests.
struct Refusal {
    const char* name;
    const char* text;
    std::vector<const char*> fragments;
};

/// The message of the Error that `call` throws; empty if it throws none.
template <class Error = std::invalid_argument, class Call>
std::string refusal(const Call& call) {
    try {
        call();
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

/// Fails unless `call` throws an `Error` whose message holds every fragment.
template <class Error = std::invalid_argument, class Call>
void expect_refusal(const Call& call, const std::vector<const char*>& fragments) {
    const std::string message = refusal<Error>(call);
    EXPECT_FALSE(message.empty()) << "nothing was refused";
    for (const char* const fragment : fragments)
        EXPECT_NE(message.find(fragment), std::string::npos)
            << "no '" << fragment << "' in '" << message << "'";
}
