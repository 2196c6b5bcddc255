#pragma once

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

namespace stratus {

/// Sleeps longer and longer while nothing happens.
class Nap {
  public:
    static constexpr std::chrono::microseconds shortest{20};

    explicit Nap(std::chrono::microseconds longest) : longest_(longest) {}

    void rest() { std::this_thread::sleep_for(next()); }
    /// How long the next nap is, for who takes it otherwise.
    std::chrono::microseconds next() { return std::exchange(next_, std::min(2 * next_, longest_)); }
    void reset() { next_ = shortest; }

  private:
    const std::chrono::microseconds longest_;
    std::chrono::microseconds next_ = shortest;
};

}  // namespace stratus
