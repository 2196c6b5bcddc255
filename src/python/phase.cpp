// Phase functions.
#include <stratus/io/phase_file.h>

#include "module.h"

namespace stratus::python {
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
    {
        const py::gil_scoped_release release;
        constexpr Allowed allowed{-1 - 1e-12, 1 + 1e-12, "in [-1, 1]"};
        require_all(at, count, "PhaseFunction", "cos_scattering_angle", allowed);
        for (std::size_t i = 0; i < count; ++i) found[i] = phi(at[i]);
    }
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
