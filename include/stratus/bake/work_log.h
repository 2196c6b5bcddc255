// Finished pieces of a long computation, so that it can resume after an interruption.
//
// Every piece has a name; it is looked up before it is computed and kept after. Names and results
// follow from the recipe alone, so a resumed computation gives the bytes of an uninterrupted one,
// on any number of threads. All three functions may be left empty.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {

class Ranks;

/// Threads  all three are called from several at once.
struct WorkLog {
    /// The result of a finished piece; none of one that is still to do.
    std::function<std::optional<std::vector<char>>(const std::string& piece)> find;
    std::function<void(const std::string& piece, std::span<const char> result)> keep;
    /// Called before every piece: true ends the work with WorkStopped once all running pieces are
    /// kept.
    std::function<bool()> stop;
    /// The ranks that share the work (ranks.h); null: this process works alone. With ranks, `find`
    /// and `keep` are called on rank 0 alone.
    Ranks* ranks = nullptr;
};

class WorkStopped : public std::runtime_error {
  public:
    WorkStopped() : std::runtime_error("the work was stopped") {}
};

}  // namespace stratus
