// What a refused call says, for tests of refusals.
#pragma once

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

/// Parts of a message, or one.
struct Fragments : std::vector<std::string> {
    using std::vector<std::string>::vector;
    Fragments(const char* one) : vector{one} {}
};

/// A text that must be refused, for parameterised tests.
struct Refusal {
    const char* name;
    const char* text;
    Fragments fragments;
};

/// Fails unless a text holds every fragment.
inline void expect_holds(const std::string& text, const Fragments& fragments) {
    for (const std::string& fragment : fragments)
        EXPECT_NE(text.find(fragment), std::string::npos)
            << "no '" << fragment << "' in '" << text << "'";
}

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
void expect_refusal(const Call& call, const Fragments& fragments) {
    const std::string message = refusal<Error>(call);
    EXPECT_FALSE(message.empty()) << "nothing was refused";
    expect_holds(message, fragments);
}
