// Threads and clocks: parallel loops, then how long they took.
//
// Parallel loops.
#pragma once

#include <chrono>
#include <ctime>
#include <functional>

namespace stratus {

/// Threads meant by `requested`: itself, or one for each processor when 0.
int thread_count(int requested);

/// Calls body(i) for i = 0 .. count - 1 on `threads` threads (0: all), or as many as the system
/// grants, each i once, in no set order; each i must write only to its own slot. `finished`, if any,
/// receives the number done so far; calls to it are serialised. The first exception is rethrown.
/// Within the body of another loop it works on that loop's threads.
void parallel_for(int count, int threads, const std::function<void(int)>& body,
                  const std::function<void(int)>& finished = nullptr);

/// Counterpart for bodies that call parallel_for themselves: each i has a thread of its own, and where
/// no i is left all threads help with the loops within. A single call stays on the calling thread.
///
/// Threads  loops within that ask for one thread keep to their own.
void nested_parallel_for(int count, int threads, const std::function<void(int)>& body);

// How long things took, for notes and for what is measured as a cost.

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Seconds that processors have worked for this process: what else the machine does adds nothing.
inline double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace stratus
