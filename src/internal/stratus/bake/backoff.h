#pragma once

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

namespace stratus {

/// Sleeps of a polling loop, each twice as long as the one before while nothing happens.
class Backoff {
  public:
    static constexpr std::chrono::microseconds shortest{20};

    explicit Backoff(std::chrono::microseconds longest) : longest_(longest) {}

    void sleep() { std::this_thread::sleep_for(next()); }
    /// Returns the length of the next sleep, for callers that wait on something else meanwhile.
    std::chrono::microseconds next() { return std::exchange(next_, std::min(2 * next_, longest_)); }
    void reset() { next_ = shortest; }

  private:
    const std::chrono::microseconds longest_;
    std::chrono::microseconds next_ = shortest;
};

}  // namespace stratus
