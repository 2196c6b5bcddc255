// The stability matrix by textbook doubling and by the harmonic scheme: a Markdown table.
//
// Three methods: doubling from single scattering without truncation, as in the textbook; doubling
// from the diamond rule with delta-M; the harmonic scheme. The first depths of the matrix, 0 and
// 1e-300, are closed forms and left out.
#include <stratus/bake/parallel.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/transfer/solve.h>

#include "../tests/transfer/stability_matrix.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <vector>

namespace {

using namespace stratus;

constexpr std::size_t contestants = 3;
constexpr int node_counts[] = {2, 8, 32};

struct Cell {
    test::NamedPhaseFunction of;
    double albedo, optical_depth;
    int nodes;
};

/// Results of one cell, or of many: counts and worst errors.
struct Worst {
    int cells = 0, broken = 0, negative = 0;
    double energy = 0, transmitted = 0;

    void add(const Worst& other) {
        cells += other.cells;
        broken += other.broken;
        negative += other.negative;
        energy = std::max(energy, other.energy);
        transmitted = std::max(transmitted, other.transmitted);
    }
};

SolverOptions make_options(std::size_t contestant, int nodes) {
    SolverOptions options;
    options.nodes = nodes;
    if (contestant == 2) return options;
    options.scheme = Scheme::classic;
    options.start = contestant == 0 ? ClassicStart::single : ClassicStart::diamond;
    options.truncate = contestant == 1 ? Truncate::delta_m : Truncate::nothing;
    return options;
}

/// By doubling all the way, also in deep conservative layers, where solve_layer would not.
LayerSolution solve(const Cell& cell, const SolverOptions& options) {
    if (options.scheme == Scheme::harmonic)
        return solve_layer(cell.of.phase_function, cell.albedo, cell.optical_depth,
                           test::stability_cosines, options);
    const bool endless = std::isinf(cell.optical_depth);
    const DepthLadder ladder{endless ? 1 : cell.optical_depth, endless ? 0 : 1, endless};
    return solve_ladder(cell.of.phase_function, {cell.albedo}, ladder, test::stability_cosines,
                        options)[0][0];
}

double energy_defect(const LayerSolution& layer) {
    double worst = std::abs(layer.spherical_albedo + layer.total_transmittance - 1);
    for (Eigen::Index i = 0; i < layer.mu.size(); ++i)
        worst =
            std::max(worst, std::abs(layer.plane_albedo(i) + layer.diffuse_transmittance(i) +
                                     direct_transmittance(layer.optical_depth, layer.mu(i)) - 1));
    return worst;
}

/// UTU by the harmonic scheme with twice the nodes, where 32 nodes resolve the phase function.
std::optional<double> reference_transmittance(const Cell& cell) {
    if (cell.nodes < 32 || std::isinf(cell.optical_depth)) return {};
    const std::vector<double> next = cell.of.phase_function.moments(2 * cell.nodes + 1);
    if (std::abs(next.back()) > 1e-6) return {};
    SolverOptions options = make_options(2, 2 * cell.nodes);
    options.modes = 1;
    const double reference = solve(cell, options).total_transmittance;
    if (reference < 1e-290) return {};
    return reference;
}

Worst measure(const Cell& cell, std::size_t contestant, std::optional<double> reference) {
    Worst result;
    result.cells = 1;
    try {
        const LayerSolution layer = solve(cell, make_options(contestant, cell.nodes));
        if (!std::isfinite(layer.spherical_albedo + layer.total_transmittance))
            throw std::runtime_error("not finite");
        if (cell.albedo == 1) result.energy = energy_defect(layer);
        result.negative = test::most_negative(layer) < -1e-9 ? 1 : 0;
        if (reference) result.transmitted = std::abs(layer.total_transmittance / *reference - 1);
    } catch (const std::runtime_error&) {
        result.broken = 1;
    }
    return result;
}

}  // namespace

int main() {
    std::vector<double> depths(test::stability_depths.begin() + 2, test::stability_depths.end());
    std::vector<Cell> cells;
    for (const double tau : depths)
        for (const int nodes : node_counts)
            for (const auto& of : test::stability_phase_functions())
                for (const double albedo : test::stability_albedos)
                    cells.push_back({of, albedo, tau, nodes});
    std::vector<Worst> of_cell(cells.size() * contestants);
    parallel_for(static_cast<int>(cells.size()), 0, [&](int i) {
        const auto at = static_cast<std::size_t>(i);
        const std::optional<double> reference = reference_transmittance(cells[at]);
        for (std::size_t c = 0; c < contestants; ++c)
            of_cell[at * contestants + c] = measure(cells[at], c, reference);
    });

    std::puts(
        "Each entry: textbook, diamond start with delta-M, harmonic; worst or count of cells.\n");
    std::puts(
        "| optical depth | broke down | R or T negative | energy lost or made at w = 1 | "
        "error of what is transmitted |\n| --- | --- | --- | --- | --- |");
    for (const double tau : depths) {
        std::array<Worst, contestants> worst;
        for (std::size_t i = 0; i < cells.size(); ++i)
            for (std::size_t c = 0; c < contestants && cells[i].optical_depth == tau; ++c)
                worst[c].add(of_cell[i * contestants + c]);
        std::printf("| %g | %d, %d, %d of %d | %d, %d, %d | %.0e, %.0e, %.0e |", tau,
                    worst[0].broken, worst[1].broken, worst[2].broken, worst[0].cells,
                    worst[0].negative, worst[1].negative, worst[2].negative, worst[0].energy,
                    worst[1].energy, worst[2].energy);
        if (std::isinf(tau))
            std::puts(" |");
        else
            std::printf(" %.0e, %.0e, %.0e |\n", worst[0].transmitted, worst[1].transmitted,
                        worst[2].transmitted);
    }
}
