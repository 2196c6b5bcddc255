#include <stratus/bake/cost.h>

#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>
#include <stratus/transfer/solve.h>

#include "indices.h"
#include "refusal.h"
#include "small_recipe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

using Kind = CostPoint::Kind;
using Indices = std::vector<std::size_t>;

struct Trade {
    double cost, error;
};

/// Returns which tables of these bytes and errors are on the frontier, ascending in cost.
Indices find_frontier(const std::vector<Trade>& trades) {
    std::vector<CostPoint> points(trades.size());
    for (const auto n : indices(trades)) {
        points[n].kind = Kind::table;
        points[n].bytes = trades[n].cost;
        points[n].error_99_9 = trades[n].error;
    }
    compare_with_frontier(points);
    Indices frontier;
    for (const auto n : indices(points))
        if (points[n].on_frontier) frontier.push_back(n);
    std::ranges::sort(frontier, {}, [&](std::size_t n) { return trades[n].cost; });
    return frontier;
}

TEST(Frontier, LeavesOutDominatedTradesAndKeepsTheFirstOfEquals) {
    EXPECT_EQ(find_frontier({{3, 0.9}, {1, 0.5}, {1, 0.5}, {2, 0.3}, {2, 0.3}}), (Indices{1, 3}));
    EXPECT_TRUE(find_frontier({}).empty());
}

bool undercuts(const Trade& a, const Trade& b) {
    return a.cost <= b.cost && a.error <= b.error && (a.cost < b.cost || a.error < b.error);
}

TEST(Frontier, IsMonotoneAndComplete) {
    std::mt19937 random(1);
    std::uniform_int_distribution<int> value(1, 12);  // few values: many ties
    for (int round = 0; round < 200; ++round) {
        std::vector<Trade> trades;
        for (int n = 0; n < 30; ++n)
            trades.push_back({static_cast<double>(value(random)), 0.1 * value(random)});
        const Indices frontier = find_frontier(trades);
        for (std::size_t n = 1; n < frontier.size(); ++n) {
            EXPECT_LT(trades[frontier[n - 1]].cost, trades[frontier[n]].cost);
            EXPECT_GT(trades[frontier[n - 1]].error, trades[frontier[n]].error);
        }
        for (const Trade& trade : trades) {
            const bool is_undercut = std::ranges::any_of(
                trades, [&](const Trade& other) { return undercuts(other, trade); });
            const bool is_met = std::ranges::any_of(frontier, [&](std::size_t at) {
                return trades[at].cost == trade.cost && trades[at].error == trade.error;
            });
            EXPECT_NE(is_undercut, is_met);
        }
    }
}

Recipe recipe() {
    Recipe small = rayleigh_recipe();
    small.tolerance = 0.03;
    small.transmission = false;
    return small;
}

struct Measured {
    CostStudy study;
    std::vector<std::string> notes;
};

/// Measured to the end of the sweeps.
const Measured& measured() {
    static const Measured all = [] {
        Measured one;
        CostOptions options;
        options.seconds = 1e6;
        options.note = [&](const std::string& line) { one.notes.push_back(line); };
        one.study = measure_cost(recipe(), options);
        return one;
    }();
    return all;
}

std::vector<CostPoint> points_of(Kind kind) {
    std::vector<CostPoint> points;
    for (const CostPoint& point : measured().study.points)
        if (point.kind == kind) points.push_back(point);
    return points;
}

/// Returns the smallest error with that many nodes.
double min_error(const CostStudy& study, int nodes) {
    double smallest = INFINITY;
    for (const CostPoint& point : study.points)
        if (point.kind == Kind::solver && point.solver.nodes == nodes)
            smallest = std::min(smallest, point.error_largest);
    return smallest;
}

TEST(Cost, ReferenceIsConverged) {
    EXPECT_LE(measured().study.reference_change, 1e-9);
    for (const CostPoint& point : points_of(Kind::solver))
        EXPECT_LE(2 * point.solver.nodes, measured().study.reference_nodes);
}

TEST(Cost, ErrorsFallWithNodes) {
    double last = 1;
    for (const int nodes : {4, 8, 12}) {
        const double error = min_error(measured().study, nodes);
        EXPECT_LT(error, 0.5 * last) << nodes;
        last = error;
    }
}

TEST(Cost, SolverErrorsBoundASingleLayer) {
    const auto solve = [](int nodes) {
        return solve_layer(recipe().phase_function, 1, 2, floor_cosines(), {.nodes = nodes});
    };
    const LayerSolution coarse = solve(6), fine = solve(64);
    double largest = 0;
    for (int i = 0; i < coarse.mu.size(); ++i)
        for (int j = 0; j < coarse.mu.size(); ++j) {
            const double expected = fine.reflection(i, j, 1.2).total;
            largest =
                std::max(largest, std::abs(coarse.reflection(i, j, 1.2).total - expected) /
                                      std::max(expected, error_floor(fine, Side::reflection)));
        }
    EXPECT_GT(largest, 1e-9);
    EXPECT_LE(largest, 1.5 * min_error(measured().study, 6));  // which is of other directions
}

TEST(Cost, MeasuresNeighbouringTolerances) {
    for (const Kind kind : {Kind::solver, Kind::table}) {
        std::vector<double> chosen;
        for (const CostPoint& point : points_of(kind))
            if (point.tolerance > 0) {
                chosen.push_back(point.tolerance);
                EXPECT_EQ(point.varied, "tolerance");
            }
        EXPECT_EQ(chosen, (std::vector<double>{0.03, 0.1, 0.01})) << "the recipe's own first";
    }
}

/// The table that the recipe's tolerance chose.
CostPoint own_table() {
    for (const CostPoint& point : points_of(Kind::table))
        if (point.tolerance == 0.03) return point;
    throw std::runtime_error("there is none");
}

TEST(Cost, BytesAreThoseOfTheSamples) {
    const CostPoint own = own_table();
    Recipe resolved = recipe();
    resolved.discretisation = own.discretisation;
    EXPECT_EQ(own.bytes, 4.0 * static_cast<double>(solve_table(resolved).sample_count()));
}

/// Two samples of one distribution, whose tail is steep: in as many layers as those of the study.
void expect_errors_of(const CostPoint& point, const Table& table) {
    VerifyOptions options;
    options.samples = 30000;
    Verification verification = verify(table, options);
    EXPECT_NEAR(point.error_median / error_quantile(verification.samples, 0.5), 1, 0.1);
    EXPECT_NEAR(point.error_99_9 / error_quantile(verification.samples, 0.999), 1, 0.3);
}

TEST(Cost, TableErrorsAgreeWithVerify) { expect_errors_of(own_table(), bake(recipe())); }

TEST(Cost, VariesEveryAxisAndAllTogether) {
    const std::vector<CostPoint> tables = points_of(Kind::table);
    for (const char* const varied : {"mu_samples", "azimuth_samples", "albedo_samples",
                                     "optical_depth_samples_per_octave", "all"}) {
        EXPECT_GE(std::ranges::count(tables, varied, &CostPoint::varied), 1) << varied;
    }
    const auto [smallest, largest] = std::ranges::minmax_element(tables, {}, &CostPoint::bytes);
    EXPECT_GT(smallest->error_99_9, largest->error_99_9);
}

TEST(Cost, MeasuresNoTableTwice) {
    std::vector<std::vector<int>> sampled;
    for (const CostPoint& point : points_of(Kind::table)) {
        const Discretisation& d = point.discretisation;
        if (point.tolerance == 0)
            sampled.push_back({d.mu_samples, d.azimuth_samples, d.optical_depth_samples_per_octave,
                               d.albedo_samples});
    }
    std::ranges::sort(sampled);
    EXPECT_EQ(std::ranges::adjacent_find(sampled), sampled.end());
}

TEST(Cost, ComparesEveryPointWithTheFrontier) {
    for (const Kind kind : {Kind::solver, Kind::table}) {
        const std::vector<CostPoint> points = points_of(kind);
        for (const CostPoint& point : points) {
            EXPECT_GT(point.cost(), 0);
            double cheapest = point.cost();
            for (const CostPoint& other : points)
                if (other.error_99_9 <= point.error_99_9)
                    cheapest = std::min(cheapest, other.cost());
            EXPECT_EQ(point.times_frontier, point.cost() / cheapest);
            if (point.on_frontier) {
                EXPECT_EQ(point.times_frontier, 1);
            }
        }
    }
    for (const char* const what : {"solver error", "table error"})
        EXPECT_EQ(std::ranges::count_if(measured().notes,
                                        [&](const std::string& note) {
                                            return note.starts_with("tolerance ") &&
                                                   note.find(what) != note.npos &&
                                                   note.find(" times the ") != note.npos;
                                        }),
                  3);
}

std::vector<std::string> fields_of(const std::string& line) {
    std::vector<std::string> fields;
    std::istringstream stream(line + ",");
    for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
    return fields;
}

TEST(Cost, FillsTheColumnsOfEachKind) {
    std::ostringstream csv;
    write_cost(csv, measured().study.points);
    std::istringstream lines(csv.str());
    std::string line;
    std::getline(lines, line);
    const std::vector<std::string> header = fields_of(line);
    ASSERT_EQ(header.size(), cost_columns().size());
    const std::vector<std::string> of_tables{
        "mu_samples",     "azimuth_samples", "optical_depth_samples_per_octave",
        "albedo_samples", "bake_seconds",    "bytes",
        "lookup_ns"};
    const std::vector<std::string> of_family{"mixture_samples", "g_samples", "radius_samples",
                                             "wavelength_samples", "variance_samples"};
    std::size_t rows = 0;
    for (; std::getline(lines, line); ++rows) {
        const std::vector<std::string> fields = fields_of(line);
        ASSERT_EQ(fields.size(), header.size()) << line;
        const CostPoint& point = measured().study.points[rows];
        for (const auto c : indices(header)) {
            EXPECT_EQ(header[c], cost_columns()[c].first);
            const bool is_tables = std::ranges::find(of_tables, header[c]) != of_tables.end();
            const bool is_of_family =  // the recipe is of one phase function
                std::ranges::find(of_family, header[c]) != of_family.end();
            const bool is_table = point.kind != Kind::solver;
            const bool belongs = header[c] == "tolerance"       ? point.tolerance > 0
                                 : is_of_family                 ? false
                                 : header[c] == "solve_seconds" ? !is_table
                                                                : !is_tables || is_table;
            EXPECT_EQ(!fields[c].empty(), belongs) << header[c] << " of " << line;
        }
    }
    EXPECT_EQ(rows, measured().study.points.size());
}

TEST(Cost, PacksWhatTolerancesChose) {
    const std::vector<CostPoint> packed = points_of(Kind::packed);
    EXPECT_EQ(packed.size(), 3u);
    for (const CostPoint& point : packed) {
        // packed_table.h: packing adds at most 0.4 of the tolerance
        EXPECT_LT(point.error_99_9, 1.4 * point.tolerance);
        EXPECT_GT(point.lookup_ns, 0);
        EXPECT_GT(point.bytes, 1000);
    }
}

/// Returns one layer with these lines added.
Recipe one_layer(const std::string& lines, const std::string& phase_function) {
    return parse_recipe("phase_function = '" + phase_function +
                        "'\n"
                        "tolerance = 0.1\n"
                        "optical_depth = { min = 1.0, max = 1.0 }\n"
                        "albedo = { min = 0.9, max = 0.9 }\n"
                        "sides = ['reflection']\n" +
                        lines);
}

CostStudy study_of(const std::string& lines, const std::string& phase_function = "isotropic") {
    return measure_cost(one_layer(lines, phase_function), {.seconds = 1e6});
}

TEST(Cost, RespectsOrdersAndLowerBoundary) {
    const double plain = min_error(study_of(""), 4);
    for (const char* const lines : {"orders = 3\n", "[below]\nlambert_albedo = 0.8\n",
                                    "[below]\nphase_function = 'rayleigh'\nalbedo = 0.7\n"}) {
        const CostStudy study = study_of(lines);
        EXPECT_TRUE(std::isfinite(min_error(study, 4)));
        EXPECT_NE(min_error(study, 4), plain) << lines;
        int chosen = 0;
        for (const CostPoint& point : study.points) {
            EXPECT_EQ(point.solver.orders, lines[0] == 'o' ? 3 : 0);
            if (point.tolerance != 0.1) continue;
            ++chosen;
            EXPECT_LE(point.error_99_9, 0.1) << lines;
        }
        EXPECT_EQ(chosen, 3) << "a solver, a table and that packed";
        EXPECT_EQ(std::ranges::count(study.points, "azimuth_samples", &CostPoint::varied) > 0,
                  std::string_view(lines).find("rayleigh") != std::string_view::npos)
            << "the azimuth matters where either phase function asks for it";
    }
}

TEST(Cost, AlwaysMeasuresTheRecipesTolerance) {
    const CostStudy study = measure_cost(recipe(), {.seconds = 1e-6});
    for (const Kind kind : {Kind::solver, Kind::table})
        EXPECT_TRUE(std::ranges::any_of(study.points, [&](const CostPoint& point) {
            return point.kind == kind && point.tolerance == 0.03;
        }));
}

TEST(Cost, MeasuresASingleSemiInfiniteLayer) {
    Recipe single = recipe();
    single.albedo = {0.9, 0.9};
    single.optical_depth = {INFINITY, INFINITY};
    const CostStudy study = measure_cost(single, {.seconds = 0.5});
    for (const CostPoint& point : study.points) {
        EXPECT_NE(point.varied, "albedo_samples");
        EXPECT_NE(point.varied, "optical_depth_samples_per_octave");
    }
    EXPECT_GE(study.points.size(), 2u);
}

TEST(Cost, RefusesZeroSecondsAndStacks) {
    expect_refusal([&] { measure_cost(recipe(), {.seconds = 0}); },
                   {"measure_cost", "seconds", "above 0", "got 0"});
    Recipe stack = recipe();
    stack.layers.resize(2);
    expect_refusal([&] { measure_cost(stack); }, {"measure_cost", "layers", "one layer", "got 2"});
}

// Directions are sampled so finely that the family alone leaves an error.
const std::string lobe_family =
    "[family]\ng = [0.0, 0.7]\n[discretisation]\nmu_samples = 40\nazimuth_samples = 30\n";

int members_along(const CostPoint& point, PhaseParameter parameter) {
    return point.members[static_cast<std::size_t>(parameter)];
}

/// Returns the tables that tolerances chose, and those with more or fewer members along an axis of
/// the family, ascending; the recipe fixes the other axes.
std::vector<CostPoint> points_along(const CostStudy& study, PhaseParameter parameter) {
    const std::string varied = std::string(parameter_name(parameter)) + "_samples";
    std::vector<CostPoint> along;
    for (const CostPoint& point : study.points)
        if (point.kind == Kind::table && (point.tolerance > 0 || point.varied == varied))
            along.push_back(point);
    std::ranges::sort(along, {},
                      [&](const CostPoint& point) { return members_along(point, parameter); });
    return along;
}

const CostStudy& study_of_lobes() {
    static const CostStudy study = study_of(lobe_family, "henyey_greenstein:g=0.5");
    return study;
}

TEST(CostOfFamily, VariesTheMembersOfAFamily) {
    const CostStudy& study = study_of_lobes();
    const std::vector<CostPoint> along = points_along(study, PhaseParameter::g);
    ASSERT_GE(along.size(), 3u);
    for (const auto n : indices(along)) {
        EXPECT_EQ(along[n].discretisation.family_samples[0],
                  members_along(along[n], PhaseParameter::g));
        EXPECT_GT(along[n].lookup_ns, 0);
        if (n == 0) continue;
        EXPECT_GE(members_along(along[n], PhaseParameter::g),
                  members_along(along[n - 1], PhaseParameter::g));
    }
    EXPECT_GT(along.front().error_99_9, 4 * along.back().error_99_9);
    int chosen = 0;
    for (const CostPoint& point : study.points) {
        if (point.tolerance != 0.1) continue;
        ++chosen;
        EXPECT_LE(point.error_99_9, 0.1);
        EXPECT_EQ(members_along(point, PhaseParameter::g) >= 2, point.kind != Kind::solver);
    }
    EXPECT_EQ(chosen, 3) << "a solver, a table and that packed";
}

TEST(CostOfFamily, ErrorsAlongAFamilyAgreeWithVerify) {
    const CostPoint coarse = points_along(study_of_lobes(), PhaseParameter::g).front();
    Recipe resolved = one_layer(lobe_family, "henyey_greenstein:g=0.5");
    resolved.discretisation = coarse.discretisation;
    Table table = solve_table(resolved);
    table.attributes["nodes"] = std::to_string(resolved.discretisation.nodes);
    expect_errors_of(coarse, table);
}

TEST(CostOfFamily, SweepsMixturesAndDroplets) {
    const CostStudy mixed = study_of("second_phase_function = 'rayleigh'\n", "isotropic");
    EXPECT_GE(points_along(mixed, PhaseParameter::mixture).size(), 2u);
    const CostStudy droplets = study_of(
        "[family]\nradius = ['0.1um', '0.2um']\nwavelength = { values = ['450nm', '650nm'] }\n",
        "mie:radius=0.2um,wavelength=0.55um,variance=0.1");
    const std::vector<CostPoint> along = points_along(droplets, PhaseParameter::radius);
    EXPECT_GE(along.size(), 2u);
    for (const CostPoint& point : along)
        EXPECT_EQ(members_along(point, PhaseParameter::wavelength), 2);
    for (const CostPoint& point : droplets.points)
        EXPECT_NE(point.varied, "wavelength_samples") << "its values are given";
}

TEST(SolveTable, HoldsTheSamplesOfTheBake) {
    const Table solved = solve_table(explicit_recipe());
    const Table baked = bake(explicit_recipe());
    EXPECT_EQ(solved.reflection_multiple, baked.reflection_multiple);
    EXPECT_EQ(solved.transmission_multiple, baked.transmission_multiple);
}

TEST(SolveTable, RefusesAnOpenChoice) {
    Recipe open = explicit_recipe();
    open.discretisation.mu_samples = 0;
    expect_refusal([&] { solve_table(open); }, {"solve_table", "mu_samples", "resolved", "got 0"});
}

}  // namespace
}  // namespace stratus::test
