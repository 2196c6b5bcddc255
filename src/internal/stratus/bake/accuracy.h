// How accurate a table is: errors at random points between its samples, against the solver itself.
//
// The error of a value is taken relative to the total R (or T) there, single scattering included,
// but not to less than 1 % of the largest value that R (or T) takes at the same optical depth and
// albedo for cosines of at least 0.1 (of a narrow peak: at the azimuths of 90 and 180 degrees), nor
// to less than 1e-8, which shows in no picture or measurement. A table without azimuth holds means
// of the orders n >= 2 over all, and is compared with these.
#pragma once

#include <stratus/bake/bake.h>
#include <stratus/table/lookup.h>
#include <stratus/table/table.h>
#include <stratus/transfer/solver_options.h>

#include <functional>
#include <span>
#include <vector>

namespace stratus {

class LayerSolution;  // transfer/solution.h
class PackedTable;
class SampleFiles;

/// Largest R or T at one (optical_depth, albedo) times 0.01, the floor of relative errors; at least
/// 1e-8. `solution` must have been solved at cosines that include `floor_cosines()`.
double error_floor(const LayerSolution& solution, Side side);
const std::vector<double>& floor_cosines();

/// The purpose of a point. Evenly drawn ones are judged together; the others, which would be
/// rare among them, apart, and for peaked phase functions alone.
enum class PointKind {
    even,
    forward,  // scattering angle within forward_cone
    grazing,  // both cosines below grazing_cosine; with a path law one of them
};

constexpr double forward_cone = 10;  // degrees
constexpr double grazing_cosine = 0.15;

/// With a path law (path_law.h), even and forward points have cosines of at least this; what tables
/// miss at smaller ones is told, not judged.
constexpr double least_judged_cosine = least_path_cosine;

/// Whether points near forward and at grazing pairs are drawn: the phase function, or that of a
/// semi-infinite layer below, is at least 40 straight on (Henyey-Greenstein: g from 0.79 on).
bool is_peaked(const PhaseFunction& phase_function);

/// One compared value.
struct ErrorSample {
    Side side;
    double albedo, optical_depth;
    Geometry geometry;
    double scattering_angle;  // radians
    double expected, found;   // totals
    double error;             // relative, as above
    double floor = 0;         // errors are relative to no less
    FamilyPoint member{};     // point of the family
    PointKind kind = PointKind::even;
};

/// Error not exceeded by a share of all; 0 for none. Sorts the samples by error.
double error_quantile(std::vector<ErrorSample>& samples, double share);

struct VerifyOptions {
    /// Points, each of which compares every side that the table has; half as many near forward and
    /// a quarter as many at grazing pairs where the phase function is peaked, or the ground has a law.
    int samples = 2000;
    unsigned seed = 1;
    int threads = 0;     // 0: all
    bool bound = false;  // look up through slices (slice.h), one bound at every point
    bool fluxes = true;  // measure what the stored fluxes miss, too
    std::function<void(double done)> progress;
    WorkLog log;                         // pieces: the points of a ladder of depths each
    const SampleFiles* files = nullptr;  // with the samples of both sides; null: the table has them
    const PackedTable* packed =
        nullptr;  // looked up in place of the table, which may be its header
};

/// How many times its tolerance the largest error of a table may be.
constexpr double largest_over_tolerance = 5;

struct Verification {
    std::vector<ErrorSample> samples;           // evenly drawn, sorted by error
    std::vector<ErrorSample> forward, grazing;  // sorted; none where nothing is peaked
    int reference_nodes = 0;
    bool judges_forward = true;  // not where the ground's law alone has a peak, in tables' samples
    bool judges_grazing = true;  // neither there nor with a path law

    /// Largest |1 - plane albedo - transmittance| of the stored fluxes at w = 1; -1 without samples
    /// there, over a lower boundary, or where fluxes are not asked for.
    double energy_defect = -1;

    /// Largest |integral of looked-up R - stored plane albedo|, over some samples of depth and of
    /// mu_in >= 0.1, at the first and the last albedo; -1 without reflection or without all
    /// directions, or where fluxes are not asked for.
    double furnace_defect = -1;

    /// 99.9 % within tolerance and all within largest_over_tolerance times it; 99 % of `forward`
    /// and of `grazing` within it where these are judged; and the energy_defect.
    bool meets(double tolerance) const {
        return meets_between_peaks(tolerance) && meets_at_peaks(tolerance) &&
               energy_defect <= tolerance;
    }
    bool meets_between_peaks(double tolerance) const;  // of `samples`
    bool meets_at_peaks(double tolerance) const;       // of `forward` and `grazing`
};

/// The ranges that random points are drawn from, evenly over the cells of the axes.
struct PointRange {
    AxisView albedo, optical_depth, mu_in, mu_out;
    bool reflection, transmission;
    LowerBoundary lower_boundary;  // what the layer lies on
    FamilyAxes family{};           // none: a single phase function
    PhaseFunction second_phase_function{};
    bool has_path_law = false;
    bool all_kinds = false;  // of points, where something is peaked; even ones alone otherwise
    AxisView azimuth{};      // no samples, or one at 0: all azimuths
    StackLayers layers{};    // of a stack, top first
};

/// Returns the ranges of a table, of which `view` is one, and all kinds of points.
PointRange point_range(const Table& table, const TableView& view);

/// Whether the phase function is peaked, that of any layer, of the boundary or at a corner of a family.
bool has_peak(const PhaseFunction& phase_function, const PointRange& range);

/// About as many points as share one solved ladder of depths.
int points_of_ladder(const PointRange& range);

/// Nodes of the solutions that tables of so many are verified with: half as many again.
int reference_nodes(int nodes);

/// The solver that a table of so many nodes is verified with.
SolverOptions reference_solver(const Table& table, int nodes);

/// Random points of a range and their solved values; `look_up` fills in `found` and `error`.
std::vector<ErrorSample> solve_random_points(const PhaseFunction& phase_function,
                                             const PointRange& range, const SolverOptions& solver,
                                             const VerifyOptions& options);

/// Looks solved points up in a table, and fills in `found` and `error`.
void look_up(const TableView& table, std::span<ErrorSample> samples);

/// Solves again at random points, half as many nodes again as the bake used, and compares lookups
/// with that. With ranks, which all call it, rank 0 alone has the table and the comparison.
Verification verify(const Table& table, const VerifyOptions& options = {});

}  // namespace stratus
