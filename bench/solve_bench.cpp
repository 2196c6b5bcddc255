// One layer, all modes, at all Gauss nodes, one thread: the "2.3 N^3 operations a doubling and
// mode" of method.md.
#include <stratus/base/instruction_set.h>
#include <stratus/transfer/solve.h>

#include <benchmark/benchmark.h>

#include <vector>

namespace {

struct Case {
    double asymmetry, albedo, optical_depth;
    int nodes;
};

constexpr Case hazy{0.75, 0.99, 8, 32}, cloudy{0.9, 1, 64, 64}, fine{0.95, 1, 8, 96},
    finest{0.95, 1, 8, 128};

void solve(benchmark::State& state, Case of, stratus::Scheme scheme,
           stratus::InstructionSet widest) {
    const auto phase = stratus::PhaseFunction::henyey_greenstein(of.asymmetry);
    stratus::SolverOptions options;
    options.nodes = of.nodes;
    options.modes = 2 * of.nodes;
    options.scheme = scheme;
    const stratus::InstructionSetLimit limit(widest);
    double spherical_albedo = 0;
    if (!stratus::is_available(widest)) {
        state.SkipWithError("not available on this processor");
        return;
    }
    for (auto _ : state)
        spherical_albedo =
            stratus::solve_layer(phase, of.albedo, of.optical_depth, {}, options).spherical_albedo;
    state.counters["spherical_albedo"] = spherical_albedo;
}

using stratus::InstructionSet, stratus::Scheme;
constexpr auto widest = InstructionSet::avx512;
constexpr auto milliseconds = benchmark::kMillisecond;

BENCHMARK_CAPTURE(solve, HG075_32_nodes_64_modes, hazy, Scheme::harmonic, widest)
    ->Unit(milliseconds);
BENCHMARK_CAPTURE(solve, HG075_32_nodes_64_modes_avx512, hazy, Scheme::harmonic,
                  InstructionSet::avx512)
    ->Unit(milliseconds);
BENCHMARK_CAPTURE(solve, HG075_32_nodes_64_modes_avx2, hazy, Scheme::harmonic, InstructionSet::avx2)
    ->Unit(milliseconds);
BENCHMARK_CAPTURE(solve, HG075_32_nodes_64_modes_generic, hazy, Scheme::harmonic,
                  InstructionSet::generic)
    ->Unit(milliseconds);
BENCHMARK_CAPTURE(solve, HG075_32_nodes_64_modes_classic, hazy, Scheme::classic, widest)
    ->Unit(milliseconds);
BENCHMARK_CAPTURE(solve, HG09_64_nodes_128_modes, cloudy, Scheme::harmonic, widest)
    ->Unit(milliseconds);
BENCHMARK_CAPTURE(solve, HG09_64_nodes_128_modes_generic, cloudy, Scheme::harmonic,
                  InstructionSet::generic)
    ->Unit(milliseconds);

BENCHMARK_CAPTURE(solve, HG095_96_nodes_192_modes, fine, Scheme::harmonic, widest)
    ->Unit(milliseconds);
BENCHMARK_CAPTURE(solve, HG095_128_nodes_256_modes, finest, Scheme::harmonic, widest)
    ->Unit(milliseconds);

// Fluxes of isotropic layers with 16 nodes: mode 0 alone, one layer, or one of eight albedos.
void solve_fluxes(benchmark::State& state, double optical_depth, int albedo_count) {
    const auto phase = stratus::PhaseFunction::isotropic();
    stratus::SolverOptions options;
    options.nodes = 16;
    std::vector<double> albedos;
    for (int a = 0; a < albedo_count; ++a) albedos.push_back(0.99 - 0.1 * a);
    double spherical_albedo = 0;
    for (auto _ : state)
        spherical_albedo =
            stratus::solve_ladder(phase, albedos, {optical_depth, 1}, {}, options)[0][0]
                .spherical_albedo;
    state.counters["spherical_albedo"] = spherical_albedo;
    state.counters["of_one"] = benchmark::Counter(
        albedo_count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

BENCHMARK_CAPTURE(solve_fluxes, isotropic_16_nodes, 8, 1)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(solve_fluxes, isotropic_16_nodes_8_albedos, 8, 8)->Unit(benchmark::kMicrosecond);

}  // namespace
