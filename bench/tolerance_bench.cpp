// Whether estimated errors are the true ones: random layers and stacks are solved to a tolerance,
// and compared with two and three times as many nodes.
//
// usage: tolerance_bench [COUNT [TOLERANCE [FIRST SEED]]]; with --references in place of TOLERANCE, it
// prints tests/reference/random_layers.csv: values by four times the nodes that 1e-3 needs.
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

double seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
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
        for (const Side side : {Side::reflection, Side::transmission})
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

void print(const std::string& name, const Class& all, double tolerance) {
    int honest = 0, known = 0, beyond = 0;
    std::vector<double> ratios;
    for (const Value& value : all.values) {
        const double least = std::min(value.estimate, std::max(value.error, 1e-13));
        if (value.uncertainty > 0.2 * least && value.uncertainty > 0.1 * value.estimate) continue;
        ++known;
        honest += value.error < 1.5 * value.estimate;
        beyond += value.error > tolerance;
        if (value.error > tolerance / 100) ratios.push_back(value.estimate / value.error);
    }
    std::printf(
        "%-9s %6zu values, %5.1f %% with a sure reference; of these %6.2f %% below 1.5 "
        "estimates, %5.2f %% beyond the tolerance (%4.1f %% say so); estimate / error %5.1f "
        "in the median of %zu; nodes %3.0f; cost %.2f\n",
        name.c_str(), all.values.size(),
        100.0 * known / std::max<double>(1, double(all.values.size())),
        100.0 * honest / std::max(1, known), 100.0 * beyond / std::max(1, known),
        100.0 * all.missed / std::max<double>(1, double(all.values.size())), median(ratios),
        ratios.size(), median(all.nodes), median(all.cost));
}

}  // namespace

int main(int argc, char** argv) {
    const int count = argc > 1 ? std::atoi(argv[1]) : 250;
    const bool references = argc > 2 && std::string(argv[2]) == "--references";
    SolverOptions options;
    options.tolerance = references ? 1e-3 : argc > 2 ? std::atof(argv[2]) : 1e-4;
    const int first = argc > 3 ? std::atoi(argv[3]) : 1;
    if (references)
        std::printf(
            "# R and T of the layers and geometries of tests/transfer/random_problems.h, printed "
            "by\n"
            "# tolerance_bench %d --references\nseed,geometry,reflection,transmission\n",
            count);
    std::map<std::string, Class> classes;
    for (int seed = first; seed < first + count; ++seed) {
        const RandomProblem problem = test::random_problem(static_cast<std::uint64_t>(seed));
        const double start = seconds();
        const SolvedGeometries solved =
            solve_geometries(problem.layers, problem.boundary, problem.geometries, options);
        const double middle = seconds();
        solve_with(problem, solved.nodes);
        const double alone = seconds() - middle;
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
            Class& to = classes[name];
            to.nodes.push_back(solved.nodes);
            to.cost.push_back((middle - start) / alone);
            for (std::size_t i = 0; i < found.size(); ++i) {
                if (finest[i] == 0) continue;  // nothing is transmitted
                const SolvedGeometry& at = solved.at[i / 2];
                const double scale = std::abs(finest[i]);
                const double estimate =
                    (i % 2 == 0 ? at.reflection_error : at.transmission_error) / scale;
                to.values.push_back({estimate, std::abs(found[i] - finest[i]) / scale,
                                     std::abs(finer[i] - finest[i]) / scale});
                to.missed += estimate > options.tolerance;
                if (name == "all" && to.values.back().error > 1.5 * estimate)
                    std::printf(
                        "seed %d, %s, value %zu: error %.1e, estimate %.1e, reference "
                        "%.1e, %d nodes\n",
                        seed, problem.kind.c_str(), i, to.values.back().error, estimate,
                        to.values.back().uncertainty, solved.nodes);
            }
        }
        std::fflush(stdout);
    }
    for (const auto& [name, all] : classes) print(name, all, options.tolerance);
}
