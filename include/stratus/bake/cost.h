// The cost of accuracy: time of the solver, bytes and lookup time of a table, over the error that is
// left.
//
// Points of several kinds are measured for a recipe, errors relative as in accuracy.h. What
// `tolerance` chooses is measured among them.
//
//   solver     nodes x modes x scheme x start, at representative albedos, depths and directions,
//              against a solution that doubling its nodes does not change
//   orders     the same with the Neumann series cut off after order n
//   reference  Markov chains over sublayers and photons over their number, of the deepest finite and
//              brightest layer at twelve geometries
//   droplets   the solver over the size of a recipe's droplets, against 96 nodes
//   table      how finely each axis is sampled, lookups at random points
//   packed     what `pack` makes of the tables that tolerances chose
//
// For a family of phase functions, solvers, orders and references take the most peaked member at an end
// of its axes, which needs the most nodes; tables, lookups and packed files are of
// the whole family, whose own axes are swept like the rest.
//
// The frontier of a kind are the points that no other undercuts in error and in cost: seconds of
// one solve, bytes of a table's samples or of a packed file.
#pragma once

#include <stratus/bake/recipe.h>

#include <array>
#include <cstddef>
#include <functional>
#include <iosfwd>
#include <string>
#include <utility>
#include <vector>

namespace stratus {

struct CostPoint {
    enum class Kind { solver, orders, reference, droplets, table, packed };
    Kind kind = Kind::solver;
    std::string
        varied;  // "tolerance", or what the sweep changed: "nodes and modes", an axis, "all"
    double tolerance = 0;           // that chose the point; 0: none did
    SolverOptions solver;           // what is timed, or what solved the table
    Discretisation discretisation;  // table: how it is sampled

    double error_median = 0, error_99_9 = 0, error_largest = 0;  // 99_9: 99.9 % are within
    double solve_seconds = 0;                                    // of the processor, one layer
    double bake_seconds = 0;  // table: all threads; with choosing and checking where tolerance did;
                              // packed: of packing
    double bytes = 0;         // table: samples of both sides in memory; packed: the file
    double lookup_ns = 0;     // of both: random points, one thread, mean of the sides

    int sublayers = 0;          // reference: of a Markov chain
    double photons = 0;         // reference
    double size_parameter = 0;  // droplets: 2 pi radius / wavelength

    // table: members along the axes of a family, by PhaseParameter; 0: not an axis of it.
    std::array<int, all_parameters.size()> members{};

    bool on_frontier = false;
    double times_frontier = 1;  // cost over that of the cheapest point that is as accurate

    /// Returns the cost that the frontier compares: solve_seconds or bytes.
    double cost() const {
        return kind == Kind::table || kind == Kind::packed ? bytes : solve_seconds;
    }
};

/// y = c x^exponent through measured points.
struct PowerLaw {
    double exponent, standard_error;
    std::size_t points;
    double from, to;  // x of the points
};

/// One quantity as a power of another.
struct GrowthLaw {
    std::string what, of;
    PowerLaw law;
};

struct CostStudy {
    std::vector<CostPoint> points;  // by kind, in the order above; each as it was measured
    std::vector<GrowthLaw> growth;
    int reference_nodes = 0;      // of the converged solution
    double reference_change = 0;  // largest error of half as many nodes against it
};

struct CostOptions {
    double seconds = 120;  // after which no measurement starts; sweeps go from cheap to expensive
    int rounds = 6;        // of timing; the best counts
    int threads = 0;       // 0: all; what is timed runs alone on one
    std::function<void(const std::string& line)> note;
    std::function<void(double done, const std::string& stage)> progress;
};

/// Measures a recipe's points. The recipe's own tolerance is always among them, with coarser ones
/// and a finer one as far as the seconds reach; what its discretisation fixes stays fixed under
/// every tolerance, and is varied like the rest.
///
/// Errors   std::invalid_argument for seconds that are not above 0 and for fewer rounds than one.
CostStudy measure_cost(const Recipe& recipe, const CostOptions& options = {});

/// A point of a trade of cost against error.
struct Trade {
    double cost;
    double error;
};

/// Indices of the trades that no other undercuts (as cheap and as accurate, one of them strictly),
/// ascending in cost and so descending in error; the first of equals.
std::vector<std::size_t> find_frontier(const std::vector<Trade>& trades);

/// The tables that differ in how many members lie along one axis of the family alone, all else being as
/// the recipe's tolerance chose, ascending; none without such an axis that is swept.
std::vector<CostPoint> points_along(const std::vector<CostPoint>& points, PhaseParameter parameter);

/// Least squares in the logarithms of x and y; the standard error is that of the slope, from the
/// scatter of the points about the line.
///
/// Errors   std::invalid_argument for fewer than three points, for an x or y that is not above 0 and
///          finite, and where all x are the same.
PowerLaw fit_power_law(const std::vector<std::pair<double, double>>& points);

/// "time of a solve grows as nodes^2.7 +- 0.05 (6 points, 16 to 96)".
std::string sentence_of(const GrowthLaw& growth);

/// CSV, a row a point; what does not belong to a point's kind is left empty.
void write_cost(std::ostream& out, const std::vector<CostPoint>& points);

/// The CSV's columns and what each holds, a line each.
const std::vector<std::pair<const char*, const char*>>& cost_columns();

}  // namespace stratus
