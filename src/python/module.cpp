#include "module.h"

#include <stratus/table/member_and_ground.h>

namespace stratus::python {

LowerBoundary make_lower_boundary(const py::object& below) {
    if (below.is_none()) return {};
    if (py::isinstance<py::tuple>(below)) {
        const auto [phase_function, albedo] = below.cast<std::pair<PhaseFunction, double>>();
        return LowerBoundary::layer(phase_function, albedo);
    }
    if (py::isinstance<py::str>(below)) return read_ground(below.cast<std::string>());
    return LowerBoundary::surface(below.cast<double>());
}

Opposition make_opposition(const OppositionParts& parts) {
    const auto& [law, width, amplitude] = parts;
    if (law.empty()) return {};
    require(law == "blinn" || law == "hapke", "opposition", "law", "blinn or hapke", law);
    return {law == "blinn" ? Opposition::Law::blinn : Opposition::Law::hapke, width, amplitude};
}

}  // namespace stratus::python

PYBIND11_MODULE(_stratus, module) {
    using namespace stratus::python;
    module.attr("version") = STRATUS_VERSION;
    add_phase(module);
    add_solve(module);
    add_table(module);
    add_bake(module);
    add_slice(module);
    add_scene(module);
    add_fit(module);
}
