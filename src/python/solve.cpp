// Phase functions; the solver: R and T at geometries, and fluxes, of a layer or a stack.
#include <stratus/bake/stack_file.h>
#include <stratus/io/table_file.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/transfer/solve_to_tolerance.h>

#include "module.h"

#include <array>
#include <tuple>
#include <utility>
#include <vector>

namespace stratus::python {
namespace {

/// The columns of a matrix, an array each.
template <std::size_t columns>
py::list numpy_arrays(const std::vector<std::array<double, columns>>& rows) {
    py::list arrays;
    for (std::size_t k = 0; k < columns; ++k) {
        std::vector<double> column;
        for (const auto& row : rows) column.push_back(row[k]);
        arrays.append(numpy_array(std::move(column)));
    }
    return arrays;
}

/// R, T, of each what was scattered once, and their errors.
py::list numpy_arrays(const SolvedGeometries& solved) {
    std::vector<std::array<double, 6>> rows;
    for (const SolvedGeometry& at : solved.at)
        rows.push_back({at.reflection.total, at.transmission.total, at.reflection.single,
                        at.transmission.single, at.reflection_error, at.transmission_error});
    return numpy_arrays(rows);
}

using Angles = std::array<Doubles, 3>;  // mu_in, mu_out, azimuth

std::vector<Geometry> make_geometries(const Angles& angles) {
    const auto& [mu_in, mu_out, azimuth] = angles;
    const std::size_t count = element_count(mu_in);
    require_all(mu_in.data(), count, "solve", "mu_in", allowed_cosine);
    require_all(mu_out.data(), count, "solve", "mu_out", allowed_cosine);
    require_all(azimuth.data(), count, "solve", "azimuth", allowed_angle);
    std::vector<Geometry> geometries;
    for (std::size_t i = 0; i < count; ++i)
        geometries.push_back({mu_in.data()[i], mu_out.data()[i], azimuth.data()[i]});
    return geometries;
}

/// Nodes, or 0: as many as a tolerance needs; the tolerance; orders.
using AskedOptions = std::tuple<int, double, int>;

SolverOptions make_options(const AskedOptions& asked) {
    const auto [nodes, tolerance, orders] = asked;
    SolverOptions options;
    if (nodes != 0)
        options.nodes = nodes;
    else
        options.tolerance = tolerance;
    options.orders = orders;
    return options;
}

std::vector<double> checked_cosines(const Doubles& mu_in) {
    require_all(mu_in.data(), element_count(mu_in), "fluxes", "mu_in", allowed_cosine);
    return {mu_in.data(), mu_in.data() + mu_in.size()};
}

py::list solve_stack(const Stack& stack, const Angles& angles, const AskedOptions& asked) {
    const std::vector<Geometry> geometries = make_geometries(angles);
    const SolverOptions options = make_options(asked);
    return numpy_arrays(without_lock(
        [&] { return solve_geometries(stack.layers, stack.lower_boundary, geometries, options); }));
}

py::dict stack_fluxes(const Stack& stack, const Doubles& mu_in, const AskedOptions& asked) {
    const std::vector<double> mu = checked_cosines(mu_in);
    const SolverOptions options = make_options(asked);
    const SolvedFluxes solved =
        without_lock([&] { return solve_fluxes(stack.layers, stack.lower_boundary, mu, options); });
    std::vector<double> direct;
    for (const double cosine : mu)
        direct.push_back(direct_transmittance(stack.optical_depth(), cosine));
    using namespace py::literals;
    return py::dict("spherical_albedo"_a = solved.spherical_albedo,
                    "total_transmittance"_a = solved.total_transmittance,
                    "absorptance"_a = absorptance(stack, solved, options.orders),
                    "ground_absorptance"_a = solved.spherical_ground_absorptance,
                    "plane_albedo"_a = numpy_array(solved.plane_albedo),
                    "diffuse_transmittance"_a = numpy_array(solved.diffuse_transmittance),
                    "direct_transmittance"_a = numpy_array(direct), "error"_a = solved.error,
                    "relative_error"_a = solved.relative_error);
}

using LayerParts = std::tuple<PhaseFunction, double, double>;  // with albedo and optical depth

/// One layer, checked by the name of the function that solves it.
Stack make_layer(const PhaseFunction& phase_function, double albedo, double optical_depth,
                 const py::object& below, const std::string& function) {
    Stack stack{{{phase_function, albedo, optical_depth}}, make_lower_boundary(below)};
    check_layers(stack.layers, stack.lower_boundary.is_present(), function.c_str());
    return stack;
}

Stack make_stack(const std::vector<LayerParts>& parts, const py::object& below) {
    Stack stack{{}, make_lower_boundary(below)};
    for (const auto& [phase_function, albedo, optical_depth] : parts)
        stack.layers.push_back({phase_function, albedo, optical_depth});
    check_layers(stack.layers, stack.lower_boundary.is_present(), "Stack");
    return stack;
}

py::list fluxes_inside(const Stack& stack, const Doubles& levels, const Doubles& mu_in,
                       const AskedOptions& asked) {
    const std::vector<double> mu = checked_cosines(mu_in);
    const std::vector<double> depths(levels.data(), levels.data() + levels.size());
    const SolverOptions options = make_options(asked);
    const SolvedInside solved = without_lock([&] {
        return solve_fluxes_inside(stack.layers, stack.lower_boundary, depths, mu, options);
    });
    std::vector<std::array<double, 5>> rows;
    for (const FluxesAtLevel& at : solved.levels)
        for (std::size_t i = 0; i < mu.size(); ++i)
            rows.push_back(
                {at.direct[i], at.diffuse[i], at.upward[i], at.actinic[i], at.heating_rate[i]});
    py::list found = numpy_arrays(rows);
    found.append(solved.error);
    found.append(solved.relative_error);
    return found;
}

py::list light_inside(const Stack& stack, double level, const Angles& angles,
                      const AskedOptions& asked) {
    const std::vector<Geometry> geometries = make_geometries(angles);
    const SolverOptions options = make_options(asked);
    return numpy_arrays(without_lock([&] {
        return solve_geometries_inside(stack.layers, stack.lower_boundary, level, geometries,
                                       options);
    }));
}

/// Cosines, azimuths, and 1 where light leaves on the lit side, 0 elsewhere.
py::list observed_directions(const Doubles& incidence, const Doubles& emission,
                             const Doubles& phase) {
    std::vector<std::array<double, 4>> rows;
    for (py::ssize_t i = 0; i < incidence.size(); ++i) {
        const auto [at, side] = observed_geometry(
            {incidence.data()[i], emission.data()[i], phase.data()[i]}, "directions");
        rows.push_back({at.mu_in, at.mu_out, at.azimuth, side == Side::reflection ? 1.0 : 0.0});
    }
    return numpy_arrays(rows);
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
    module.def("make_layer", make_layer);
    module.def("solve_stack", solve_stack);
    module.def("stack_fluxes", stack_fluxes);
    module.def("make_stack", make_stack);
    module.def("stack_fluxes_inside", fluxes_inside);
    module.def("solve_stack_inside", light_inside);
    module.def("observed_directions", observed_directions);
}

namespace {

std::pair<PhaseFunction, std::vector<std::string>> read_text(const std::string& text,
                                                             const std::string& directory) {
    std::vector<std::string> notes;
    PhaseFunction phi = read_phase_function(text, directory, &notes);
    return {std::move(phi), std::move(notes)};
}

Doubles values_at(const PhaseFunction& phi, const Doubles& cosines) {
    const double* const at = cosines.data();
    const std::size_t count = element_count(cosines);
    std::vector<double> found(count);
    without_lock([&] {
        constexpr Allowed allowed{-1 - 1e-12, 1 + 1e-12, "in [-1, 1]"};
        require_all(at, count, "PhaseFunction", "cos_scattering_angle", allowed);
        for (std::size_t i = 0; i < count; ++i) found[i] = phi(at[i]);
    });
    return numpy_array(std::move(found));
}

}  // namespace

void add_phase(py::module_& module) {
    py::class_<PhaseFunction>(module, "PhaseFunction")
        .def("values", values_at)
        .def("moments",
             [](const PhaseFunction& phi, int count) { return numpy_array(phi.moments(count)); })
        .def("asymmetry", &PhaseFunction::asymmetry)
        .def("albedo", &PhaseFunction::albedo)
        .def("text", &PhaseFunction::text)
        .def("caption", &PhaseFunction::caption);
    module.def("read_phase_function", read_text);
    module.def("phase_function_help", phase_function_help);
}

}  // namespace stratus::python
