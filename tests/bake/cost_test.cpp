#include <stratus/bake/cost.h>

#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>

#include "cost_study.h"
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

namespace stratus {
namespace {

using Kind = CostPoint::Kind;
using Indices = std::vector<std::size_t>;

TEST(Frontier, LeavesOutDominatedTrades) {
    EXPECT_EQ(find_frontier({{1, 0.5}, {2, 0.6}, {3, 0.1}, {4, 0.2}}), (Indices{0, 2}));
    EXPECT_EQ(find_frontier({{4, 0.2}, {3, 0.1}, {1, 0.5}}), (Indices{2, 1})) << "in any order";
}

TEST(Frontier, KeepsTheBetterOfAPartialTie) {
    EXPECT_EQ(find_frontier({{1, 0.5}, {1, 0.4}}), Indices{1}) << "as cheap";
    EXPECT_EQ(find_frontier({{2, 0.5}, {1, 0.5}}), Indices{1}) << "as accurate";
}

TEST(Frontier, KeepsTheFirstOfEquals) {
    EXPECT_EQ(find_frontier({{3, 0.9}, {1, 0.5}, {1, 0.5}, {2, 0.3}, {2, 0.3}}), (Indices{1, 3}));
}

TEST(Frontier, HandlesOneAndNoTrade) {
    EXPECT_EQ(find_frontier({{1, 1}}), Indices{0});
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
            const bool is_undercut =
                std::any_of(trades.begin(), trades.end(),
                            [&](const Trade& other) { return undercuts(other, trade); });
            const bool is_met = std::any_of(frontier.begin(), frontier.end(), [&](std::size_t at) {
                return trades[at].cost == trade.cost && trades[at].error == trade.error;
            });
            EXPECT_NE(is_undercut, is_met);
        }
    }
}

Recipe recipe() {
    Recipe small = test::rayleigh_recipe();
    small.tolerance = 0.03;
    small.transmission = false;
    return small;
}

struct Measured {
    CostStudy study;
    std::vector<std::string> notes;
};

/// Measured to the end of the sweeps. The times are in no test's interest: one round of them.
const Measured& measured() {
    static const Measured all = [] {
        Measured one;
        CostOptions options;
        options.seconds = 1e6;
        options.rounds = 1;
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

TEST(Cost, ReferenceIsConverged) {
    EXPECT_LE(measured().study.reference_change, 1e-9);
    for (const CostPoint& point : points_of(Kind::solver))
        EXPECT_LE(2 * point.solver.nodes, measured().study.reference_nodes);
}

TEST(Cost, ErrorsFallWithNodes) {
    for (const Scheme scheme : {Scheme::harmonic, Scheme::classic}) {
        double last = 1;
        for (const int nodes : {4, 8, 12}) {
            double smallest = 1;  // of all numbers of modes
            for (const CostPoint& point : points_of(Kind::solver))
                if (point.solver.nodes == nodes && point.solver.scheme == scheme)
                    smallest = std::min(smallest, point.error_largest);
            EXPECT_LT(smallest, 0.5 * last) << nodes;
            last = smallest;
        }
    }
}

TEST(Cost, ErrorsFallWithModes) {
    double one = 0, three = 0;  // Rayleigh scattering has three
    for (const CostPoint& point : points_of(Kind::solver)) {
        if (point.solver.nodes != 12 || point.solver.scheme != Scheme::harmonic) continue;
        if (point.solver.modes == 1) one = point.error_99_9;
        if (point.solver.modes == 3) three = point.error_99_9;
    }
    EXPECT_GT(three, 0);
    EXPECT_GT(one, 10 * three);
}

TEST(Cost, SolverErrorsBoundASingleLayer) {
    const auto solve = [](int nodes) {
        SolverOptions solver;
        solver.nodes = nodes;
        return solve_layer(recipe().phase_function, 1, 2, floor_cosines(), solver);
    };
    const LayerSolution coarse = solve(6), fine = solve(64);
    double largest = 0;
    for (int i = 0; i < coarse.mu.size(); ++i)
        for (int j = 0; j < coarse.mu.size(); ++j) {
            const double expected = fine.reflection(i, j, 1.2).total;
            largest = std::max(largest, std::abs(coarse.reflection(i, j, 1.2).total - expected) /
                                            std::max(expected, reflection_floor(fine)));
        }
    double stated = 1;
    for (const CostPoint& point : points_of(Kind::solver))
        if (point.solver.nodes == 6 && point.solver.scheme == Scheme::harmonic)
            stated = std::min(stated, point.error_largest);
    EXPECT_GT(largest, 1e-9);
    EXPECT_LE(largest, 1.01 * stated);  // modes that add less than a thousandth are left out
}

TEST(Cost, MeasuresNeighbouringTolerances) {
    for (const Kind kind : {Kind::solver, Kind::table}) {
        std::vector<double> chosen;
        for (const CostPoint& point : points_of(kind))
            if (point.tolerance > 0) {
                chosen.push_back(point.tolerance);
                EXPECT_EQ(point.varied, "tolerance");
            }
        EXPECT_EQ(chosen, (std::vector<double>{0.1, 0.03, 0.01}));
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

TEST(Cost, TableErrorsAgreeWithVerify) {
    VerifyOptions options;
    options.samples = 30000;  // in as many layers as the 6000 of the study
    Verification verification = verify(bake(recipe()), options);
    const CostPoint own = own_table();
    // two samples of one distribution, whose tail is steep
    EXPECT_NEAR(own.error_median / error_quantile(verification.samples, 0.5), 1, 0.1);
    EXPECT_NEAR(own.error_99_9 / error_quantile(verification.samples, 0.999), 1, 0.3);
}

TEST(Cost, VariesEveryAxisAndAllTogether) {
    const std::vector<CostPoint> tables = points_of(Kind::table);
    for (const char* const varied : {"mu_samples", "azimuth_samples", "albedo_samples",
                                     "optical_depth_samples_per_octave", "all"}) {
        const auto count = std::count_if(tables.begin(), tables.end(), [&](const CostPoint& point) {
            return point.varied == varied;
        });
        EXPECT_GE(count, 1) << varied;
    }
    const auto [smallest, largest] = std::minmax_element(
        tables.begin(), tables.end(),
        [](const CostPoint& a, const CostPoint& b) { return a.bytes < b.bytes; });
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
    std::sort(sampled.begin(), sampled.end());
    EXPECT_EQ(std::adjacent_find(sampled.begin(), sampled.end()), sampled.end());
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
        EXPECT_EQ(std::count_if(measured().notes.begin(), measured().notes.end(),
                                [&](const std::string& note) {
                                    return note.rfind("tolerance ", 0) == 0 &&
                                           note.find(what) != std::string::npos &&
                                           note.find(" times the ") != std::string::npos;
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
        for (std::size_t c = 0; c < header.size(); ++c) {
            EXPECT_EQ(header[c], cost_columns()[c].first);
            const bool is_tables =
                std::find(of_tables.begin(), of_tables.end(), header[c]) != of_tables.end();
            const bool is_of_family =  // the recipe is of one phase function
                std::ranges::find(of_family, header[c]) != of_family.end();
            const bool is_starts = header[c] == "start" || header[c] == "start_depth";
            const bool is_table = point.kind == Kind::table || point.kind == Kind::packed;
            const bool belongs = header[c] == "tolerance"        ? point.tolerance > 0
                                 : header[c] == "nodes"          ? point.photons == 0
                                 : header[c] == "modes"          ? point.solver.modes > 0
                                 : header[c] == "orders"         ? point.kind == Kind::orders
                                 : header[c] == "sublayers"      ? point.sublayers > 0
                                 : header[c] == "photons"        ? point.photons > 0
                                 : header[c] == "size_parameter" ? point.kind == Kind::droplets
                                 : is_of_family                  ? false
                                 : is_starts ? point.solver.scheme == Scheme::classic
                                 : header[c] == "solve_seconds" ? !is_table
                                                                : !is_tables || is_table;
            EXPECT_EQ(!fields[c].empty(), belongs) << header[c] << " of " << line;
        }
    }
    EXPECT_EQ(rows, measured().study.points.size());
}

/// The smallest error with that many nodes.
double min_error(const CostStudy& study, int nodes, Scheme scheme,
                 ClassicStart start = ClassicStart::diamond, double start_depth = 0) {
    double smallest = INFINITY;
    for (const CostPoint& point : study.points)
        if (point.kind == Kind::solver && point.solver.nodes == nodes &&
            point.solver.scheme == scheme && point.solver.start == start &&
            point.solver.start_depth == start_depth)
            smallest = std::min(smallest, point.error_largest);
    return smallest;
}

TEST(Cost, SweepsEveryStartOfClassicDoubling) {
    const CostStudy& study = measured().study;
    constexpr int nodes = 16;
    const auto classic = [&](ClassicStart start, double start_depth) {
        return min_error(study, nodes, Scheme::classic, start, start_depth);
    };
    const double harmonic = min_error(study, nodes, Scheme::harmonic);
    for (const ClassicStart start : {ClassicStart::diamond, ClassicStart::single}) {
        // what 16 nodes leave is left by both schemes; a start at 3e-8 adds less than 1e-6: the
        // error is of the first order, and 3e-5 at 1e-6
        EXPECT_NEAR(classic(start, 0), harmonic, 1e-6);
        EXPECT_LT(10 * classic(start, 1e-6), classic(start, 1e-3));
        EXPECT_LT(10 * harmonic, classic(start, 1e-3));
    }
    EXPECT_LT(classic(ClassicStart::diamond, 1e-3), classic(ClassicStart::single, 1e-3));
}

TEST(Cost, ErrorsFallWithOrdersToWhatTheNodesLeave) {
    const std::vector<CostPoint> orders = points_of(Kind::orders);
    ASSERT_GE(orders.size(), 4u);
    for (std::size_t n = 1; n < orders.size(); ++n) {
        EXPECT_GT(orders[n].solver.orders, orders[n - 1].solver.orders);
        EXPECT_LT(orders[n].error_99_9, orders[n - 1].error_99_9);
    }
    EXPECT_EQ(orders.front().solver.orders, 2);
    // at w = 1 and a depth of 2 orders fall off as 0.6^n or so
    EXPECT_GT(orders.front().error_99_9, 0.05);
    const int nodes = orders.back().solver.nodes;
    double all = 1;
    for (const CostPoint& point : points_of(Kind::solver))
        if (point.solver.nodes == nodes && point.solver.scheme == Scheme::harmonic)
            all = std::min(all, point.error_99_9);
    EXPECT_LE(orders.back().error_99_9, 1.1 * all);
}

TEST(Cost, ReferencesConverge) {
    std::vector<std::pair<double, double>> markov, photons;  // error over size
    for (const CostPoint& point : points_of(Kind::reference))
        if (point.sublayers > 0)
            markov.push_back({point.sublayers, point.error_median});
        else
            photons.push_back({point.photons, point.error_median});
    ASSERT_GE(markov.size(), 3u);
    ASSERT_GE(photons.size(), 3u);
    // markov.h: eight times better with each doubling, as far as its nodes let it
    EXPECT_LT(fit_power_law({markov.begin(), markov.begin() + 3}).exponent, -2);
    EXPECT_NEAR(fit_power_law(photons).exponent, -0.5, 0.25);  // the spread of one draw of 24
    EXPECT_LT(markov.back().second, 1e-3);
    EXPECT_LT(photons.back().second, 2e-2);
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

TEST(Cost, FitsPowerLaws) {
    const PowerLaw exact =
        fit_power_law({{1, 3}, {2, 3 * std::exp2(1.5)}, {8, 3 * std::exp2(4.5)}});
    EXPECT_NEAR(exact.exponent, 1.5, 1e-14);
    EXPECT_NEAR(exact.standard_error, 0, 1e-14);
    EXPECT_EQ(exact.from, 1);
    EXPECT_EQ(exact.to, 8);
    // y = x^2 with logarithms off by 1, -2, 1: the slope stays, its variance is 6 / (3 - 2) / 2
    const double e = std::exp(1.0);
    const PowerLaw off = fit_power_law({{1 / e, e / (e * e)}, {1, 1 / (e * e)}, {e, e * e * e}});
    EXPECT_NEAR(off.exponent, 2, 1e-14);
    EXPECT_NEAR(off.standard_error, std::sqrt(3.0), 1e-14);
    EXPECT_EQ(sentence_of({"time", "nodes", off}),
              "time grows as nodes^2 +- 1.7 (3 points, 0.37 to 2.7)");
    EXPECT_THROW(fit_power_law({{1, 1}, {2, 2}}), std::invalid_argument);
    EXPECT_THROW(fit_power_law({{1, 1}, {2, 0}, {3, 1}}), std::invalid_argument);
    EXPECT_THROW(fit_power_law({{1, 1}, {-2, 1}, {3, 1}}), std::invalid_argument);
    EXPECT_THROW(fit_power_law({{2, 1}, {2, 2}, {2, 3}}), std::invalid_argument);
}

TEST(Cost, TellsWhatGrows) {
    for (const char* const what : {"nodes^", "optical depth^", "ranks^", "tolerance^", "time^"})
        EXPECT_TRUE(std::any_of(measured().notes.begin(), measured().notes.end(),
                                [&](const std::string& note) {
                                    return note.find(" grows as ") != std::string::npos &&
                                           note.find(what) != std::string::npos;
                                }))
            << what;
    for (const GrowthLaw& growth : measured().study.growth)
        if (growth.what.rfind("size of ", 0) == 0) {
            EXPECT_LT(growth.law.exponent, 0) << growth.what;
        } else if (growth.of == "ranks") {  // never faster than their number
            EXPECT_GT(growth.law.exponent, -1);
        }
}

TEST(Cost, VariesTheSizeOfDroplets) {
    const CostStudy study = study_of("", "mie:radius=0.2um,wavelength=0.55um");
    std::vector<double> sizes;
    for (const CostPoint& point : study.points) {
        if (point.kind != Kind::droplets) continue;
        if (sizes.empty() || sizes.back() != point.size_parameter)
            sizes.push_back(point.size_parameter);
        EXPECT_LT(point.error_99_9, 1e-3) << point.size_parameter;  // x = 9 is no peak yet
    }
    ASSERT_EQ(sizes.size(), 5u);
    EXPECT_NEAR(sizes[2], 2 * 3.14159265358979 * 0.2 / 0.55, 1e-9);
    EXPECT_NEAR(sizes[4] / sizes[0], 16, 1e-9);
}

TEST(Cost, RespectsOrdersAndLowerBoundary) {
    const double plain = min_error(study_of(""), 4, Scheme::harmonic);
    for (const char* const lines : {"orders = 3\n", "[below]\nlambert_albedo = 0.8\n",
                                    "[below]\nphase_function = 'rayleigh'\nalbedo = 0.7\n"}) {
        const CostStudy study = study_of(lines);
        EXPECT_TRUE(std::isfinite(min_error(study, 4, Scheme::harmonic)));
        EXPECT_NE(min_error(study, 4, Scheme::harmonic), plain) << lines;
        int chosen = 0;
        for (const CostPoint& point : study.points) {
            EXPECT_EQ(point.solver.scheme, Scheme::harmonic) << lines;
            EXPECT_EQ(point.solver.orders, lines[0] == 'o' ? 3 : 0);
            if (point.tolerance != 0.1) continue;
            ++chosen;
            EXPECT_LE(point.error_99_9, 0.1) << lines;
        }
        EXPECT_EQ(chosen, 3) << "a solver, a table and that packed";
        EXPECT_EQ(std::any_of(study.points.begin(), study.points.end(),
                              [](const CostPoint& p) { return p.varied == "azimuth_samples"; }),
                  std::string(lines).find("rayleigh") != std::string::npos)
            << "the azimuth matters where either phase function asks for it";
    }
}

TEST(Cost, AlwaysMeasuresTheRecipesTolerance) {
    CostOptions options;
    options.seconds = 1e-6;
    const CostStudy study = measure_cost(recipe(), options);
    for (const Kind kind : {Kind::solver, Kind::table})
        EXPECT_TRUE(
            std::any_of(study.points.begin(), study.points.end(), [&](const CostPoint& point) {
                return point.kind == kind && point.tolerance == 0.03 && point.on_frontier;
            }));
}

TEST(Cost, MeasuresASingleSemiInfiniteLayer) {
    Recipe single = recipe();
    single.albedo = {0.9, 0.9};
    single.optical_depth = {INFINITY, INFINITY};
    CostOptions options;
    options.seconds = 0.5;
    const CostStudy study = measure_cost(single, options);
    for (const CostPoint& point : study.points) {
        EXPECT_NE(point.varied, "albedo_samples");
        EXPECT_NE(point.varied, "optical_depth_samples_per_octave");
    }
    EXPECT_GE(study.points.size(), 2u);
}

TEST(Cost, RefusesZeroSeconds) {
    CostOptions options;
    options.seconds = 0;
    expect_refusal<std::invalid_argument>([&] { measure_cost(recipe(), options); },
                                          {"measure_cost", "seconds", "above 0", "got 0"});
}

TEST(Cost, RefusesZeroRounds) {
    CostOptions options;
    options.rounds = 0;
    expect_refusal<std::invalid_argument>([&] { measure_cost(recipe(), options); },
                                          {"measure_cost", "rounds", ">= 1", "got 0"});
}

TEST(SolveTable, HoldsTheSamplesOfTheBake) {
    const Table solved = solve_table(test::explicit_recipe());
    const Table baked = bake(test::explicit_recipe());
    EXPECT_EQ(solved.reflection_multiple, baked.reflection_multiple);
    EXPECT_EQ(solved.transmission_multiple, baked.transmission_multiple);
}

TEST(SolveTable, RefusesAnOpenChoice) {
    Recipe open = test::explicit_recipe();
    open.discretisation.mu_samples = 0;
    expect_refusal<std::invalid_argument>([&] { solve_table(open); },
                                          {"solve_table", "mu_samples", "resolved", "got 0"});
}

}  // namespace
}  // namespace stratus
