// What a refused call says, for tests of refusals.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

/// A text that must be refused, for parameterised tests.
struct Refusal {
    const char* name;
    const char* text;
    std::vector<const char*> fragments;
};

/// Fails unless `call` throws an `Error` whose message holds every fragment.
template <class Error, class Call>
void expect_refusal(const Call& call, const std::vector<const char*>& fragments) {
    try {
        call();
        ADD_FAILURE() << "nothing was refused";
    } catch (const Error& error) {
        const std::string message = error.what();
        for (const char* const fragment : fragments)
            EXPECT_NE(message.find(fragment), std::string::npos)
                << "no '" << fragment << "' in '" << message << "'";
    }
}
