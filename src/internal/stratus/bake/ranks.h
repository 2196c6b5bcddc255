// Ranks: what they need of a library that passes messages, then the work that they share.
//
// The operations that ranks need of a library that passes messages; src/ranks has it from MPI, as a plugin that is
// loaded when the program was started by mpirun or srun.
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
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

// Processes that share one bake: ranks 0 .. count - 1, started together by mpirun or srun.
//
// All run the same program on the same recipe and come to the same decisions. Where the work is
// divided into pieces, each rank claims one from rank 0 whenever it is free, and sends back its
// result. Rank 0 has the checkpoint, the table and the file; the others hold the pieces that they
// work on. Results follow from the recipe alone, so that the table has the same bytes on any number
// of ranks.

struct RanksOptions {
    /// Seconds without a sign of life after which a rank counts as lost.
    double time_limit = 120;
    /// Asked by rank 0 all the time: the signal that ends all ranks; 0: none.
    std::function<int()> stop;
    /// Returns the sentence about the work that is left after a rank was lost; called on rank 0, which tells the others, so
    /// that they can say it when rank 0 is lost.
    std::function<std::string()> kept;
};

/// The work that one rank did.
struct RankTally {
    int pieces = 0;
    double seconds = 0;  // that processors worked for it
};

/// A part of the work in pieces 0 .. count - 1. Each is solved once, by any rank; all else is rank
/// 0's: what the solver is given, whether a piece needs no solving, what becomes of its result, the
/// number done so far.
///
/// Threads  all are called by several at once, but `progress`.
struct RankedStage {
    int count = 0;
    /// From what `give` gave; of other ranks, rank 0's bytes.
    std::function<std::vector<char>(int piece, std::span<const char> given)> solve;
    std::function<std::vector<char>(int piece)> give;  // may be empty: nothing
    /// A piece so far ahead of the first that is not done waits for it; 0: none waits.
    int most_ahead = 0;
    /// Pieces that each of the other ranks is given while it still works on those before.
    int claimed_ahead = 0;
    std::function<bool(int piece)> is_done;
    std::function<void(int piece, std::span<const char> result)> take;
    std::function<void(int done)> progress;
};

/// Threads  `share` and `gather` are called by all ranks in the same order, and not while a stage
///          runs; everything else by any thread.
class Ranks {
  public:
    /// Waits for all ranks.
    Ranks(std::unique_ptr<RankTransport> transport, RanksOptions options);
    ~Ranks();
    Ranks(const Ranks&) = delete;
    Ranks& operator=(const Ranks&) = delete;

    int rank() const;
    int count() const;
    bool is_first() const { return rank() == 0; }

    /// Rank 0's bytes, on all ranks.
    std::vector<char> share(std::vector<char> bytes);

    /// The bytes of the first so many ranks, by rank, on all ranks; the others' count for nothing.
    std::vector<std::vector<char>> gather(std::span<const char> bytes, int from_ranks);

    /// Has the pieces of a stage solved by all ranks, each on so many threads.
    void run(const RankedStage& stage, int threads);

    /// Ends in order, once rank 0 has all it needs; called by all ranks. By rank; on rank 0 alone.
    std::vector<RankTally> finish();
    bool is_finished() const;

    /// Ends all ranks at once: rank 0 says why on standard error and gives the exit code. Another
    /// rank tells rank 0 and waits for the end.
    [[noreturn]] void end_all(int exit_code, const std::string& reason);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace stratus
