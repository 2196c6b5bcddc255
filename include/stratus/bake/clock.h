// How long things took, for notes and for what is measured as a cost.
#pragma once

#include <chrono>

namespace stratus {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace stratus
