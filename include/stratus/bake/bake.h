// Recipe in, table out; interrupted work is kept and resumed.
#pragma once

#include <stratus/bake/recipe.h>
#include <stratus/table/table.h>

#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {

class Ranks;
class SampleFiles;

/// Finished pieces of a long computation, so that it can resume after an interruption.
///
/// Every piece has a name; it is looked up before it is computed and kept after. Names and results
/// follow from the recipe alone, so a resumed computation gives the bytes of an uninterrupted one,
/// on any number of threads. All three functions may be left empty.
///
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

struct BakeOptions {
    int threads = 0;            // 0: all
    int checked_points = 2000;  // at random, by the bake's own check
    /// One line on what was chosen and why.
    std::function<void(const std::string& line)> note;
    /// Share of the stage done, and what the stage is; called from one thread at a time.
    std::function<void(double done, const std::string& stage)> progress;
    /// Told once, by `bake`, where the table misses its tolerance: by how much, and which axes are
    /// at their caps. Left empty, it goes to `note`.
    std::function<void(const std::string& sentence)> missed;
    WorkLog log;  // what an interrupted bake has finished already
    /// Where there is room in them (write_options.h), the samples of both sides go there. In the table
    /// one sample stands for those of each side: for `verify` and `write_table` with these files.
    SampleFiles* samples = nullptr;
    /// Where to put the packed table (packed_table.h); all ranks ask for it, rank 0 gets it. The check
    /// is then of its lookups, and the table has no samples, unless they are to be kept: one stands
    /// for those of each side.
    std::vector<char>* packed = nullptr;
    bool keeps_samples = false;
};

/// Names a program whose tables may differ from those of others in their last bits: its version,
/// what compiled it and the instruction set that it solves with.
std::string baking_program();

/// Fills in what the recipe's discretisation left open, by measuring: solver nodes and modes
/// against finer ones, then each axis against the solver between its samples, for the fewest
/// samples that meet the tolerance.
Recipe resolve(const Recipe& recipe, const BakeOptions& options = {});

/// Solves all samples of a resolved recipe: a table ready for lookups that states no accuracy.
///
/// Errors   std::invalid_argument for a choice left open.
/// Threads  the same bits on any number of them.
Table solve_table(const Recipe& resolved, const BakeOptions& options = {});

/// Bakes a table: resolves the recipe, solves all samples, checks the table at random points. Where
/// the check misses the tolerance and the recipe left the sampling open, it is made finer and baked
/// again, twice at most; not where an axis at its cap alone keeps the table from meeting it.
///
/// Pieces   of the log: every choice that is made, eight albedos of all octaves of depth, eight
///          points of the check; each of them in every attempt.
/// Ranks    all call it alike; the table of rank 0 is the one that counts.
/// Threads  the same bits on any number of them.
Table bake(const Recipe& recipe, const BakeOptions& options = {});

}  // namespace stratus
