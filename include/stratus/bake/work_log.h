// What a long piece of work has finished, so that it need not start over after an interruption.
//
// Work is cut into pieces with names. A piece is looked for before it is done and kept after;
// names and results follow from the recipe alone, so work that goes on with a log ends with the
// bytes of work that was never interrupted, on any number of threads. All three functions may be
// left empty.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {

/// Threads  all three are called from several at once.
struct WorkLog {
    /// What came of a piece; nothing where it is still to be done.
    std::function<std::optional<std::vector<char>>(const std::string& piece)> find;
    std::function<void(const std::string& piece, std::span<const char> result)> keep;
    /// Asked before every piece: true ends the work with WorkStopped once all pieces at work are
    /// finished and kept.
    std::function<bool()> stop;
};

class WorkStopped : public std::runtime_error {
  public:
    WorkStopped() : std::runtime_error("the work was stopped") {}
};

}  // namespace stratus
