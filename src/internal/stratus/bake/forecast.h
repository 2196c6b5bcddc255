// Choices resolved, and the size and the cost of a table, before it is solved.
#pragma once

#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>

#include <string>
#include <vector>

namespace stratus {

/// An axis whose last candidate still misses its share of the tolerance.
struct AxisAtCap {
    std::string name;  // as in recipes
    double value;
    double error;   // relative error that it alone leaves
    double needed;  // what would do, extrapolated; 0: unknown
};

/// A resolved recipe.
struct Resolution {
    Recipe recipe;
    std::vector<AxisAtCap> at_cap;
    double max_error = 0;  // that every choice was allowed
};

/// Resolves with every choice measured against `strictness` times the tolerance.
Resolution resolve_to(const Recipe& recipe, double strictness, const BakeOptions& options);

/// The choices of a bake's first attempt, found in the bake's log and kept there.
Resolution resolve_as_first(const Recipe& recipe, const BakeOptions& options);

/// The check that a bake makes of its first attempt, whose points it finds in its log, too.
VerifyOptions check_of_first(const BakeOptions& options);

/// An axis on which even the last candidate misses its share of the tolerance.
struct Shortfall : AxisAtCap {
    double allowed;            // its share of the tolerance
    double needed_bytes = 0;   // of a table that has that many
    double times_as_long = 1;  // solving it takes; 1 but for nodes
};

struct Forecast {
    Recipe resolved;
    double samples_a_side = 0;
    double bytes = 0;  // samples and fluxes, in memory and uncompressed
    double bake_seconds = 0, check_seconds = 0;
    double timed_seconds = 0;          // that they are derived from
    std::vector<double> unit_seconds;  // of one thread, for the pieces of the table
    std::vector<Shortfall> shortfalls;

    /// Whether an axis alone misses the tolerance.
    bool misses(double tolerance) const;
};

/// The size of a table.
struct TableSize {
    double layers, samples_a_side, bytes;
};

TableSize table_size(const Recipe& resolved);

/// The forecast of a resolved recipe; with ranks, which would wait for it, without times.
Forecast forecast(const Resolution& resolution, const BakeOptions& options);

/// Resolves a recipe and times a piece of its table and a layer of its check, on one thread; the
/// rest is taken to be alike.
Forecast forecast(const Recipe& recipe, const BakeOptions& options = {});

/// One sentence on an axis that is at its cap: by how much it misses, what would do and cost.
std::string describe(const Shortfall& axis);

/// One line on size and time.
std::string sentence_of_cost(const Forecast& forecast);

}  // namespace stratus
