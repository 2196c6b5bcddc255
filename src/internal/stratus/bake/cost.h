// The cost of accuracy: time of the solver, bytes and lookup time of a table, over the error that is
// left. Errors are as in accuracy.h, at random points of a recipe's ranges. Three kinds of points are
// measured, and what tolerances choose among them:
//
//   solver  numbers of nodes, against a solution that more nodes do not change; of a family its most
//           peaked member at an end of its axes, which needs the most
//   table   how finely each axis is sampled, those of a family too; lookups
//   packed  what `pack` makes of the tables that tolerances chose
//
// The frontier of a kind consists of the points that no other undercuts in error and in cost: seconds
// of one solve, bytes of a table's samples or of a packed file.
#pragma once

#include <stratus/bake/recipe.h>

#include <array>
#include <functional>
#include <iosfwd>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace stratus {

struct CostPoint {
    enum class Kind { solver, table, packed };
    Kind kind = Kind::solver;
    /// "tolerance", or what the sweep changed: "nodes", an axis, "all".
    std::string varied;
    double tolerance = 0;                              // that chose the point; 0: none did
    SolverOptions solver;                              // what is timed, or what solved the table
    Discretisation discretisation;                     // of tables
    std::array<int, all_parameters.size()> members{};  // along the axes of a family; 0: no axis

    double error_median = 0, error_99_9 = 0, error_largest = 0;  // 99_9: 99.9 % are within
    double solve_seconds = 0;  // of the processor, the deepest and brightest layer
    /// Seconds of all threads: with choosing and checking where tolerance did; packed: of packing.
    double bake_seconds = 0;
    double bytes = 0;      // samples of both sides in memory; packed: the file
    double lookup_ns = 0;  // at random points, one thread, mean of the sides

    bool on_frontier = false;
    double times_frontier = 1;  // cost over that of the cheapest point that is as accurate

    /// Returns the cost that the frontier compares.
    double cost() const { return kind == Kind::solver ? solve_seconds : bytes; }
};

struct CostStudy {
    std::vector<CostPoint> points;  // by kind, each as it was measured
    int reference_nodes = 0;        // of the converged solution
    double reference_change = 0;    // largest error of fewer nodes against it
};

struct CostOptions {
    double seconds = 120;  // after which no measurement starts; sweeps go from cheap to expensive
    int threads = 0;       // 0: all; what is timed runs alone on one
    std::function<void(const std::string& line)> note;
    std::function<void(double done, const std::string& stage)> progress;
};

/// Measures a recipe's points. The recipe's own tolerance is always among them, with coarser ones
/// and a finer one as far as the seconds reach; what its discretisation fixes stays fixed under
/// every tolerance, and is varied like the rest.
///
/// Errors   std::invalid_argument for seconds that are not above 0 and for stacks.
CostStudy measure_cost(const Recipe& recipe, const CostOptions& options = {});

/// Sets on_frontier and times_frontier of points of one kind. On the frontier are those that no other
/// undercuts (as cheap and as accurate, one of them strictly); the first of equals.
void compare_with_frontier(std::span<CostPoint> points);

/// Writes a CSV with a row for each point; what does not belong to a point's kind is left empty.
void write_cost(std::ostream& out, const std::vector<CostPoint>& points);

/// Returns the names of the CSV's columns and what each holds.
std::vector<std::pair<std::string, std::string>> cost_columns();

}  // namespace stratus
