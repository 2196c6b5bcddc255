// One layer, all modes, at all Gauss nodes, one thread: what method.md calls "2.3 N^3 operations a
// doubling and mode".
#include <stratus/transfer/solve.h>

#include <benchmark/benchmark.h>

#include <string>

namespace {

struct Case {
    double asymmetry, albedo, optical_depth;
    int nodes;
};

constexpr Case hazy{0.75, 0.99, 8, 32}, cloudy{0.9, 1, 64, 64};

void solve(benchmark::State& state, Case of, stratus::Scheme scheme, const char* instruction_set) {
    const auto phase = stratus::PhaseFunction::henyey_greenstein(of.asymmetry);
    stratus::SolverOptions options;
    options.nodes = of.nodes;
    options.modes = 2 * of.nodes;
    options.scheme = scheme;
    options.instruction_set = instruction_set;
    double spherical_albedo = 0;
    try {
        for (auto _ : state)
            spherical_albedo = stratus::solve_layer(phase, of.albedo, of.optical_depth, {}, options)
                                   .spherical_albedo;
    } catch (const std::exception& refusal) {  // an instruction set that this processor lacks
        state.SkipWithError(refusal.what());
    }
    state.counters["spherical_albedo"] = spherical_albedo;
}

using stratus::Scheme;
constexpr auto milliseconds = benchmark::kMillisecond;

BENCHMARK_CAPTURE(solve, HG075_32_nodes_64_modes, hazy, Scheme::harmonic, nullptr)
    ->Unit(milliseconds);
BENCHMARK_CAPTURE(solve, HG075_32_nodes_64_modes_avx512, hazy, Scheme::harmonic, "avx512")
    ->Unit(milliseconds);
BENCHMARK_CAPTURE(solve, HG075_32_nodes_64_modes_avx2, hazy, Scheme::harmonic, "avx2")
    ->Unit(milliseconds);
BENCHMARK_CAPTURE(solve, HG075_32_nodes_64_modes_generic, hazy, Scheme::harmonic, "generic")
    ->Unit(milliseconds);
BENCHMARK_CAPTURE(solve, HG075_32_nodes_64_modes_classic, hazy, Scheme::classic, nullptr)
    ->Unit(milliseconds);
BENCHMARK_CAPTURE(solve, HG09_64_nodes_128_modes, cloudy, Scheme::harmonic, nullptr)
    ->Unit(milliseconds);
BENCHMARK_CAPTURE(solve, HG09_64_nodes_128_modes_generic, cloudy, Scheme::harmonic, "generic")
    ->Unit(milliseconds);

}  // namespace
