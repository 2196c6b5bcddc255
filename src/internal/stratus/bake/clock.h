// How long things took, for notes and for what is measured as a cost.
#pragma once

#include <chrono>
#include <ctime>

namespace stratus {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Seconds that processors have worked for this process: what else the machine does adds nothing.
inline double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace stratus
