// The size and the cost of a table, before it is solved.
#pragma once

#include <stratus/bake/resolve.h>

#include <string>
#include <vector>

namespace stratus {

/// An axis on which even the last candidate misses its share of the tolerance.
struct Shortfall {
    std::string name;      // as in recipes
    double value;          // its cap
    double error;          // relative, that it alone leaves
    double allowed;        // its share of the tolerance
    double needed;         // what would do, extrapolated; 0: unknown
    double needed_bytes;   // of a table that has that many
    double times_as_long;  // solving it takes; 1 but for nodes
};

/// The work of a bake that threads and ranks can share, in seconds of one thread.
struct ShareableWork {
    double choosing_seconds = 0;
    int probed_albedos = 1;            // that choosing is shared by
    std::vector<double> unit_seconds;  // of the table's pieces
    int ladders = 0;                   // pieces of the check
    double ladder_seconds = 0;
    double flops = 0;  // of solving, an estimate
};

struct Forecast {
    Recipe resolved;
    double samples_a_side = 0;
    double bytes = 0;  // samples and fluxes, in memory and uncompressed
    double bake_seconds = 0, check_seconds = 0;
    double timed_seconds = 0;  // that they are derived from
    ShareableWork work;
    std::vector<Shortfall> shortfalls;

    /// Whether an axis alone misses the tolerance.
    bool misses(double tolerance) const;
};

/// The size of a table.
struct TableSize {
    double layers, samples_a_side, bytes;
};

TableSize size_of(const Recipe& resolved);

/// The forecast of a resolved recipe; with ranks, which would wait for it, without times.
Forecast forecast_of(const Resolution& resolution, const BakeOptions& options);

/// Resolves a recipe and times a piece of its table and a layer of its check, on one thread; the
/// rest is taken to be alike.
Forecast forecast(const Recipe& recipe, const BakeOptions& options = {});

/// One sentence on an axis that is at its cap: by how much it misses, what would do and cost.
std::string sentence_of(const Shortfall& axis);

/// One line on size and time.
std::string sentence_of_cost(const Forecast& forecast);

/// Seconds of a bake on some ranks of some threads each.
struct RankedTime {
    int ranks;
    double choosing, solving, checking, writing;
    std::string limit;  // what keeps more ranks from making it faster

    double total() const { return choosing + solving + checking + writing; }
};

/// The times of one bake on ranks: pieces go to whoever is free; rank 0 receives every result, and
/// gives what is deflated.
RankedTime predict_on_ranks(const Forecast& forecast, int ranks, int threads);

/// A table of them, with what they assume.
std::string text_of_ranks(const Forecast& forecast, const std::vector<int>& ranks, int threads);

}  // namespace stratus
