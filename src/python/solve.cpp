// The solver: R and T at geometries, and fluxes, of a layer or a stack.
#include <stratus/bake/stack_file.h>
#include <stratus/runtime/single_scattering.h>
#include <stratus/transfer/solve.h>
#include <stratus/transfer/stack.h>

#include <map>
#include <utility>

#include "module.h"

namespace stratus::python {
namespace {

constexpr std::size_t max_cosines = 64;  // solved at once: each costs as much as a node does

struct Geometries {
    const double *mu_in, *mu_out, *azimuth;
    std::size_t count;
};

/// R, T, and of each what was scattered once.
struct Light {
    explicit Light(std::size_t count)
        : reflection(count), transmission(count), reflected_once(count), transmitted_once(count) {}

    py::tuple arrays() && {
        return py::make_tuple(array_of(std::move(reflection)), array_of(std::move(transmission)),
                              array_of(std::move(reflected_once)),
                              array_of(std::move(transmitted_once)));
    }

    std::vector<double> reflection, transmission, reflected_once, transmitted_once;
};

using Pair = std::pair<int, int>;
using RowsOfPair = std::map<Pair, std::vector<std::size_t>>;

std::vector<SolvedValue> values_of(const LayerSolution& solution, Side side, const Pair& pair,
                                   const std::vector<double>& azimuths) {
    return side == Side::reflection ? solution.reflection(pair.first, pair.second, azimuths)
                                    : solution.transmission(pair.first, pair.second, azimuths);
}

std::vector<SolvedValue> values_of(const StackSolution& solution, Side side, const Pair& pair,
                                   const std::vector<double>& azimuths) {
    return solution.values(side, pair.first, pair.second, azimuths);
}

template <class Solution>
void fill(const Solution& solution, const RowsOfPair& rows_of, const Geometries& at, Light& light) {
    for (const auto& [pair, rows] : rows_of) {
        std::vector<double> azimuths;
        for (const std::size_t row : rows) azimuths.push_back(at.azimuth[row]);
        const auto reflected = values_of(solution, Side::reflection, pair, azimuths);
        const auto transmitted = values_of(solution, Side::transmission, pair, azimuths);
        for (std::size_t i = 0; i < rows.size(); ++i) {
            light.reflection[rows[i]] = reflected[i].total;
            light.transmission[rows[i]] = transmitted[i].total;
            light.reflected_once[rows[i]] = reflected[i].single;
            light.transmitted_once[rows[i]] = transmitted[i].single;
        }
    }
}

/// Solves as many rows at a time as share a list of cosines of reasonable length.
template <class Solve>
Light solve_rows(const Geometries& at, const Solve& solve) {
    Light light(at.count);
    for (std::size_t row = 0; row < at.count;) {
        std::map<double, int> place;
        std::vector<double> cosines;
        RowsOfPair rows_of;
        for (; row < at.count && cosines.size() <= max_cosines - 2; ++row) {
            const auto place_of = [&](double mu) {
                const auto [found, is_new] =
                    place.try_emplace(mu, static_cast<int>(cosines.size()));
                if (is_new) cosines.push_back(mu);
                return found->second;
            };
            const int in = place_of(at.mu_in[row]), out = place_of(at.mu_out[row]);
            rows_of[{in, out}].push_back(row);
        }
        fill(solve(cosines), rows_of, at, light);
    }
    return light;
}

Geometries geometries_of(const Doubles& mu_in, const Doubles& mu_out, const Doubles& azimuth) {
    const Geometries at{mu_in.data(), mu_out.data(), azimuth.data(), count_of(mu_in)};
    require_all(at.mu_in, at.count, "solve", "mu_in", allowed_cosine);
    require_all(at.mu_out, at.count, "solve", "mu_out", allowed_cosine);
    require_all(at.azimuth, at.count, "solve", "azimuth", allowed_angle);
    return at;
}

SolverOptions options_of(int nodes, int orders) {
    SolverOptions options;
    options.nodes = nodes;
    options.orders = orders;
    return options;
}

/// Fluxes follow from the first azimuthal mode.
SolverOptions flux_options(int nodes, int orders) {
    SolverOptions options = options_of(nodes, orders);
    options.modes = 1;
    return options;
}

py::array list_of(const Eigen::VectorXd& values) {
    return array_of(std::vector<double>(values.begin(), values.end()));
}

py::dict fluxes_of(const ModeSolution& solution, double optical_depth,
                   const std::vector<double>& mu) {
    std::vector<double> direct;
    for (const double cosine : mu) direct.push_back(direct_transmittance(optical_depth, cosine));
    py::dict fluxes;
    fluxes["spherical_albedo"] = solution.spherical_albedo;
    fluxes["total_transmittance"] = solution.total_transmittance;
    fluxes["ground_absorptance"] = solution.spherical_ground_absorptance;
    fluxes["plane_albedo"] = list_of(solution.plane_albedo);
    fluxes["diffuse_transmittance"] = list_of(solution.diffuse_transmittance);
    fluxes["direct_transmittance"] = array_of(std::move(direct));
    fluxes["over_boundary"] = solution.lower_boundary.is_present();
    return fluxes;
}

std::vector<double> cosines_of(const Doubles& mu_in) {
    require_all(mu_in.data(), count_of(mu_in), "fluxes", "mu_in", allowed_cosine);
    return {mu_in.data(), mu_in.data() + mu_in.size()};
}

py::tuple solve_one(const PhaseFunction& phase_function, double albedo, double optical_depth,
                    const Doubles& mu_in, const Doubles& mu_out, const Doubles& azimuth, int nodes,
                    int orders, const py::object& below) {
    const Geometries at = geometries_of(mu_in, mu_out, azimuth);
    const SolverOptions options = options_of(nodes, orders);
    const LowerBoundary boundary = boundary_of(below);
    const auto solved = [&] {
        const py::gil_scoped_release release;
        return solve_rows(at, [&](const std::vector<double>& mu) {
            return solve_layer(phase_function, albedo, optical_depth, mu, options, boundary);
        });
    };
    return solved().arrays();
}

py::tuple solve_several(const Stack& stack, const Doubles& mu_in, const Doubles& mu_out,
                        const Doubles& azimuth, int nodes) {
    const Geometries at = geometries_of(mu_in, mu_out, azimuth);
    const auto solved = [&] {
        const py::gil_scoped_release release;
        return solve_rows(at, [&](const std::vector<double>& mu) {
            return solve_stack(stack.layers, stack.lower_boundary, mu, options_of(nodes, 0));
        });
    };
    return solved().arrays();
}

py::dict fluxes_of_one(const PhaseFunction& phase_function, double albedo, double optical_depth,
                       const Doubles& mu_in, int nodes, int orders, const py::object& below) {
    const std::vector<double> mu = cosines_of(mu_in);
    const LowerBoundary boundary = boundary_of(below);
    const auto solved = [&] {
        const py::gil_scoped_release release;
        return solve_layer(phase_function, albedo, optical_depth, mu, flux_options(nodes, orders),
                           boundary);
    };
    py::dict fluxes = fluxes_of(solved(), optical_depth, mu);
    const bool lossless =
        albedo == 1 && orders == 0 && (!boundary.is_present() || boundary.albedo == 1);
    fluxes["conservative"] = lossless;
    return fluxes;
}

py::dict fluxes_of_several(const Stack& stack, const Doubles& mu_in, int nodes) {
    const std::vector<double> mu = cosines_of(mu_in);
    double depth = 0;
    bool lossless = !stack.lower_boundary.is_present() || stack.lower_boundary.albedo == 1;
    for (const StackLayer& layer : stack.layers) {
        depth += layer.optical_depth;
        lossless = lossless && layer.albedo == 1;
    }
    const auto solved = [&] {
        const py::gil_scoped_release release;
        return solve_stack(stack.layers, stack.lower_boundary, mu, flux_options(nodes, 0));
    };
    py::dict fluxes = fluxes_of(solved(), depth, mu);
    fluxes["conservative"] = lossless;
    return fluxes;
}

std::pair<Stack, std::vector<std::string>> read_layers(const std::string& text_or_path,
                                                       bool is_path) {
    std::vector<std::string> notes;
    Stack stack =
        is_path ? read_stack(text_or_path, &notes) : parse_stack(text_or_path, "", &notes);
    return {std::move(stack), std::move(notes)};
}

}  // namespace

void add_solve(py::module_& module) {
    const py::class_<Stack> stack(module, "Stack");
    module.def("read_stack", read_layers);
    module.def("solve_layer", solve_one);
    module.def("solve_stack", solve_several);
    module.def("layer_fluxes", fluxes_of_one);
    module.def("stack_fluxes", fluxes_of_several);
}

}  // namespace stratus::python
