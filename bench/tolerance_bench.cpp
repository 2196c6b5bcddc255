// Whether estimated errors are the true ones: random layers and stacks are solved to a tolerance,
// and compared with two and three times as many nodes. Columns: all values, and those whose
// reference is surer than their estimate; of these in per cent, errors below 1.5 estimates; the
// error that 99 % of them are within; errors beyond the tolerance, in per cent, and said to be;
// the median of estimate over error, of how many errors above a hundredth of the tolerance; the
// median of nodes, and of the time over that of the last solution alone, either the faster of two
// (the first computes Gauss nodes and coefficients of droplets). Grazing: a cosine below 0.15.
//
// usage: tolerance_bench [COUNT [TOLERANCE [FIRST SEED [LARGEST COSINE]]]]; with --references in place
// of TOLERANCE, it prints tests/reference/random_layers.csv: values by four times the nodes that 1e-3
// needs.
#include <stratus/transfer/solve_to_tolerance.h>
#include <stratus/transfer/stack.h>

#include "random_problems.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

namespace {

using namespace stratus;
using test::RandomProblem;

constexpr int most_nodes = 240;       // of references
constexpr double most_seconds = 0.7;  // that one solution may take: references take 30 times that

struct Value {
    double estimate, error, uncertainty;  // relative; of the reference
};

struct Class {
    std::vector<Value> values;
    std::vector<double> nodes, cost;  // cost: over that of the last solution alone
    int missed = 0;                   // values beyond the tolerance, as they say
};

template <class Run>
double fastest_seconds(const Run& run) {
    double fastest = infinity;
    for (int k = 0; k < 2; ++k) {
        const auto start = std::chrono::steady_clock::now();
        run();
        const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
        fastest = std::min(fastest, passed.count());
    }
    return fastest;
}

std::vector<double> values_of(const SolvedGeometries& solved) {
    std::vector<double> values;
    for (const SolvedGeometry& at : solved.at) {
        values.push_back(at.reflection.total);
        values.push_back(at.transmission.total);
    }
    return values;
}

std::vector<double> solve_with(const RandomProblem& problem, int nodes) {
    SolverOptions options;
    options.nodes = nodes;
    std::vector<double> mu, values;
    for (const Geometry& at : problem.geometries) {
        mu.push_back(at.mu_in);
        mu.push_back(at.mu_out);
    }
    const StackSolution solution = solve_stack(problem.layers, problem.boundary, mu, options);
    for (int i = 0; i < std::ssize(problem.geometries); ++i)
        for (const Side side : both_sides)
            values.push_back(solution
                                 .values(side, 2 * i, 2 * i + 1,
                                         {problem.geometries[static_cast<std::size_t>(i)].azimuth})
                                 .front()
                                 .total);
    return values;
}

double median(std::vector<double> values) {
    if (values.empty()) return 0;
    std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
    return values[values.size() / 2];
}

/// The value that 99 of 100 do not exceed.
double most(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto at = values.begin() + (std::ssize(values) * 99 - 1) / 100;
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

void print(const std::string& name, const Class& all, double tolerance) {
    int honest = 0, beyond = 0;
    std::vector<double> errors, ratios;
    for (const Value& value : all.values) {
        const double least = std::min(value.estimate, std::max(value.error, 1e-13));
        if (value.uncertainty > 0.2 * least && value.uncertainty > 0.1 * value.estimate) continue;
        honest += value.error < 1.5 * value.estimate;
        beyond += value.error > tolerance;
        errors.push_back(value.error);
        if (value.error > tolerance / 100) ratios.push_back(value.estimate / value.error);
    }
    const double known = std::max(1.0, static_cast<double>(errors.size())),
                 count = std::max(1.0, static_cast<double>(all.values.size()));
    std::printf("%-18s %5zu %5zu %8.2f %8.1e %8.2f %8.1f %6.1f %5zu %6.0f %6.2f\n", name.c_str(),
                all.values.size(), errors.size(), 100 * honest / known, most(errors),
                100 * beyond / known, 100 * all.missed / count, median(ratios), ratios.size(),
                median(all.nodes), median(all.cost));
}

}  // namespace

int main(int argc, char** argv) {
    const int count = argc > 1 ? std::atoi(argv[1]) : 250;
    const bool references = argc > 2 && std::string(argv[2]) == "--references";
    SolverOptions options;
    options.tolerance = references ? 1e-3 : argc > 2 ? std::atof(argv[2]) : 1e-4;
    const int first = argc > 3 ? std::atoi(argv[3]) : 1;
    const double most = argc > 4 ? std::atof(argv[4]) : 1;
    if (references)
        std::printf(
            "# R and T of the layers and geometries of tests/transfer/random_problems.h, printed "
            "by\n"
            "# tolerance_bench %d --references\nseed,geometry,reflection,transmission\n",
            count);
    std::map<std::string, Class> classes;
    for (int seed = first; seed < first + count; ++seed) {
        const RandomProblem problem = test::random_problem(static_cast<std::uint64_t>(seed), most);
        SolvedGeometries solved;
        const double together = fastest_seconds([&] {
            solved =
                solve_geometries(problem.layers, problem.boundary, problem.geometries, options);
        });
        const double alone = fastest_seconds([&] { solve_with(problem, solved.nodes); });
        if (alone > (references ? most_seconds / 7 : most_seconds)) {
            std::fprintf(stderr, "seed %d, %s: left out, %d nodes took %.1f s\n", seed,
                         problem.kind.c_str(), solved.nodes, alone);
            continue;
        }
        const std::vector<double> found = values_of(solved),
                                  finer = solve_with(
                                      problem, std::min(2 * solved.nodes, most_nodes * 2 / 3)),
                                  finest = solve_with(
                                      problem,
                                      std::min((references ? 4 : 3) * solved.nodes, most_nodes));
        if (references) {
            for (std::size_t i = 0; i < solved.at.size(); ++i)
                std::printf("%d,%zu,%.15g,%.15g\n", seed, i, finest[2 * i], finest[2 * i + 1]);
            std::fflush(stdout);
            continue;
        }
        for (const std::string& name : {problem.kind, std::string("all")}) {
            classes[name].nodes.push_back(solved.nodes);
            classes[name].cost.push_back(together / alone);
        }
        for (std::size_t i = 0; i < found.size(); ++i) {
            if (finest[i] == 0) continue;  // nothing is transmitted
            const SolvedGeometry& at = solved.at[i / 2];
            const Geometry& asked = problem.geometries[i / 2];
            const double scale = std::abs(finest[i]);
            const Value value{(i % 2 == 0 ? at.reflection_error : at.transmission_error) / scale,
                              std::abs(found[i] - finest[i]) / scale,
                              std::abs(finer[i] - finest[i]) / scale};
            const bool is_grazing = std::min(asked.mu_in, asked.mu_out) < 0.15;
            for (const std::string& name :
                 {problem.kind + (is_grazing ? ", grazing" : ""), std::string("all")}) {
                classes[name].values.push_back(value);
                classes[name].missed += value.estimate > options.tolerance;
            }
            if (value.error > 1.5 * value.estimate)
                std::printf(
                    "seed %d, %s, value %zu: error %.1e, estimate %.1e, reference %.1e, "
                    "%d nodes\n",
                    seed, problem.kind.c_str(), i, value.error, value.estimate, value.uncertainty,
                    solved.nodes);
        }
        std::fflush(stdout);
    }
    if (references) return 0;
    std::printf("%-18s %5s %5s %8s %8s %8s %8s %6s %5s %6s %6s\n", "", "all", "sure", "honest %",
                "99 % in", "beyond %", "said %", "ratio", "of", "nodes", "cost");
    for (const auto& [name, all] : classes) print(name, all, options.tolerance);
}
