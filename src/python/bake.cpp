// Baking a recipe.
#include <stratus/bake/bake.h>
#include <stratus/io/table_file.h>

#include "long_work.h"
#include "module.h"

#include <memory>

namespace stratus::python {
namespace {

/// The table, what is to be told of its recipe, and by how much it misses its tolerance, or "".
py::tuple bake_recipe(const std::string& text_or_path, bool is_path, int threads,
                      const py::object& note, const py::object& progress) {
    std::vector<std::string> notes;
    const Recipe recipe =
        is_path ? read_recipe(text_or_path, &notes) : parse_recipe(text_or_path, "", &notes);
    std::string missed;
    BakeOptions options;
    options.missed = [&](const std::string& sentence) { missed = sentence; };
    auto table = run_long(
        threads, note, progress,
        [&](const BakeOptions& with) { return std::make_shared<AnyTable>(bake(recipe, with)); },
        options);
    return py::make_tuple(table, notes, missed);
}

}  // namespace

void add_bake(py::module_& module) { module.def("bake", bake_recipe); }

}  // namespace stratus::python
