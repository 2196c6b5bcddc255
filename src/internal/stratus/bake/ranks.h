// Processes that share one bake: ranks 0 .. count - 1, started together by mpirun or srun.
//
// All run the same program on the same recipe and come to the same decisions. Where the work is
// divided into pieces, each rank claims one from rank 0 whenever it is free, and sends back its
// result. Rank 0 has the checkpoint, the table and the file; the others hold the pieces that they
// work on. Results follow from the recipe alone, so that the table has the same bytes on any number
// of ranks.
#pragma once

#include <stratus/bake/rank_transport.h>

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace stratus {

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
