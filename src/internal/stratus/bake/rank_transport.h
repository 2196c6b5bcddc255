// The operations that ranks need of a library that passes messages; src/ranks has it from MPI, as a plugin that is
// loaded when the program was started by mpirun or srun.
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>
#include <span>
#include <thread>
#include <utility>
#include <vector>

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

struct RankMessage {
    int from;
    std::vector<char> bytes;
};

/// Threads  any number. No function keeps a processor busy while it waits.
class RankTransport {
  public:
    virtual ~RankTransport() = default;

    virtual int rank() const = 0;
    virtual int count() const = 0;
    virtual int count_on_this_machine() const = 0;

    /// Returns when `bytes` may be used again.
    virtual void send(int to, int tag, std::span<const char> bytes) = 0;

    /// A message that has come from a rank, or from any (-1); none if there is none. Messages from
    /// one rank with one tag come in the order in which they were sent.
    virtual std::optional<RankMessage> receive(int from, int tag) = 0;

    /// Fills in rank 0's bytes on all others, whose spans are as long; called by all.
    virtual void broadcast(std::span<char> bytes) = 0;

    /// Ends all ranks.
    [[noreturn]] virtual void abort(int exit_code) = 0;
};

/// The plugin's only function, under this name.
using StartRanks = RankTransport*();
constexpr const char* start_ranks_name = "stratus_start_ranks";

}  // namespace stratus
