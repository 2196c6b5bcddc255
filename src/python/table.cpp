// Tables: baking, reading, writing, what they hold, and lookups at any layer.
#include <stratus/base/constants.h>
#include <stratus/io/file_bytes.h>
#include <stratus/io/table_file.h>
#include <stratus/table/lookup.h>
#include <stratus/table/metadata.h>

#include "module.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <sstream>

namespace stratus::python {

namespace {

using Shared = std::shared_ptr<AnyTable>;

Shared read(const std::string& path) {
    const std::string ending = fs::path(path).extension().string();
    require(ending == ".h5" || ending == ".exr" || ending == packed_ending, "load", "path",
            "a name ending in .h5, .exr or .stratus", path);
    return std::make_shared<AnyTable>(read_any_table(path));
}

// HDF5 is not asked by two threads at a time: reading and writing keep Python's lock.

void write_file(const AnyTable& table, const std::string& path) {
    if (fs::path(path).extension() != packed_ending) {
        require(!table.packed(), "Table.save", "path",
                "a name ending in .stratus for a packed table", path);
        write_table(table.table(), path);
        return;
    }
    require(!table.packed(), "Table.save", "the table",
            "a dense one: a packed one is a file already", "packed");
    const py::gil_scoped_release release;
    write_content_atomically(path, pack(table.table()));
}

Shared packed(const Shared& table) {
    if (table->packed()) return table;
    const py::gil_scoped_release release;
    return std::make_shared<AnyTable>(PackedTable(pack(table->table())));
}

Shared unpacked(const Shared& table) {
    if (!table->packed()) return table;
    const py::gil_scoped_release release;
    return std::make_shared<AnyTable>(table->packed()->unpacked());
}

/// Facts that a table's attributes leave out, by the names that files give them.
py::dict facts(const AnyTable& any) {
    const Table& table = any.table();
    py::dict facts;
    facts["phase_function"] = table.phase_function;
    if (mixes_two(table.family)) facts["second_phase_function"] = table.second_phase_function;
    facts["tolerance"] = table.tolerance;
    facts["measured_error"] = table.measured_error;
    facts["highest_order"] = table.highest_order;
    facts["extrapolation_length"] = table.extrapolation_length;
    if (table.lower_boundary.is_present()) {
        facts["below"] = table.lower_boundary.is_surface() ? "lambert surface"
                         : table.lower_boundary.law        ? table.lower_boundary.law->text()
                                                           : "semi-infinite layer";
        facts["below_albedo"] = table.lower_boundary.albedo;
    }
    return facts;
}

py::dict axis_values(const AnyTable& any) {
    py::dict found;
    for (const AxisField& field : all_axis_fields(any.table()))
        found[field.name] = numpy_array(table_axis(any.table(), field).values);
    return found;
}

py::dict axis_scales(const AnyTable& any) {
    py::dict found;
    for (const AxisField& field : all_axis_fields(any.table()))
        found[field.name] = stored_scale_name(field, any.table());
    return found;
}

/// Adds numbers over the first `rank` axes without copying them; the array keeps the table.
template <class Number>
void add_dataset(py::dict& found, const char* name, const std::vector<Number>& values,
                 const Shared& table, std::size_t rank) {
    if (values.empty()) return;
    std::vector<AxisField> axes = all_axis_fields(table->table());
    axes.resize(table->table().family.size() + rank);
    std::vector<py::ssize_t> shape;
    std::vector<std::string> dimensions;
    for (const AxisField& field : axes) {
        const std::size_t count = table_axis(table->table(), field).values.size();
        if (count == 0) continue;
        shape.push_back(static_cast<py::ssize_t>(count));
        dimensions.emplace_back(field.name);
    }
    py::array_t<Number> array(shape, values.data(), py::cast(table));
    array.attr("flags").attr("writeable") = false;
    found[name] = py::make_tuple(dimensions, array);
}

/// name -> (dimensions, numbers); of a packed table the fluxes alone.
py::dict datasets(const Shared& table) {
    const Table& of = table->table();
    py::dict found;
    for (const SampleField& field : sample_fields)
        add_dataset(found, field.name, of.*field.samples, table, field.rank);
    add_dataset(found, diffusion_exponent_name, of.diffusion_exponent, table, 1);
    return found;
}

// ---- lookups ------------------------------------------------------------------------------------

struct Points {
    const double *albedo, *optical_depth, *mu_in, *mu_out, *azimuth;
    std::size_t count;
};

void require_within(const double* values, std::size_t count, const char* function,
                    const char* argument, double lowest, double highest) {
    constexpr double rounding = 1e-9;  // of angles in degrees, of sums of depths
    std::ostringstream text;
    text << "in [" << lowest << ", " << highest << "], which the table holds";
    const double margin = std::isinf(highest) ? 0 : rounding * highest;
    require_all(values, count, function, argument,
                {lowest - margin, highest + margin, text.str().c_str()});
}

/// Refuses what a lookup would clamp.
void require_known(const TableView& view, const Points& at, const char* function) {
    require_all(at.mu_in, at.count, function, "mu_in", allowed_cosine);
    require_all(at.mu_out, at.count, function, "mu_out", allowed_cosine);
    require_all(at.azimuth, at.count, function, "azimuth", allowed_angle);
    const AxisView &albedo = view.albedo, &depth = view.optical_depth;
    require_within(at.albedo, at.count, function, "albedo", albedo.lowest, albedo.highest);
    require_within(at.optical_depth, at.count, function, "optical_depth",
                   depth.count == 0              ? infinity
                   : view.knows_thinner_layers() ? 0
                                                 : depth.lowest,
                   depth.count == 0 || depth.ends_at_infinity ? infinity : depth.highest);
    if (view.has_all_directions()) return;
    require_within(at.mu_in, at.count, function, "mu_in", view.mu_in.lowest, view.mu_in.highest);
    require_within(at.mu_out, at.count, function, "mu_out", view.mu_out.lowest,
                   view.mu_out.highest);
    if (view.azimuth.count == 1 && view.azimuth.lowest == 0) return;
    std::vector<double> azimuth(at.azimuth, at.azimuth + at.count);
    for (double& angle : azimuth) angle = std::abs(std::remainder(angle, 2 * pi));
    require_within(azimuth.data(), at.count, function, "azimuth", view.azimuth.lowest,
                   view.azimuth.highest);
}

/// Sixteen at a time where the table is packed.
void look_up_packed(const PackedTable& table, Side side, const Points& at, double mixture,
                    std::vector<double>& found) {
    constexpr std::size_t piece = 1024;
    std::vector<float> numbers(6 * piece);
    for (std::size_t first = 0; first < at.count; first += piece) {
        const std::size_t count = std::min(piece, at.count - first);
        const double* const from[] = {at.albedo, at.optical_depth, at.mu_in, at.mu_out, at.azimuth};
        for (std::size_t k = 0; k < 5; ++k)
            for (std::size_t i = 0; i < count; ++i)
                numbers[k * piece + i] = static_cast<float>(from[k][first + i]);
        const float* const n = numbers.data();
        const PackedPoints points{n, n + piece, n + 2 * piece, n + 3 * piece, n + 4 * piece, count};
        float* const total = numbers.data() + 5 * piece;
        table.scattering(side, points, total, mixture);
        for (std::size_t i = 0; i < count; ++i) found[first + i] = double{total[i]};
    }
}

Doubles look_up(const AnyTable& table, bool transmitted, const Doubles& albedo,
                const Doubles& optical_depth, const Doubles& mu_in, const Doubles& mu_out,
                const Doubles& azimuth, const std::vector<double>& member, bool single,
                bool multiple) {
    const Points at{albedo.data(), optical_depth.data(), mu_in.data(),
                    mu_out.data(), azimuth.data(),       element_count(albedo)};
    const Side side = transmitted ? Side::transmission : Side::reflection;
    const char* const function = transmitted ? "Table.transmission" : "Table.reflection";
    std::vector<double> found(at.count);
    without_lock([&] {
        const TableView all = table.view();
        require(transmitted ? all.has_transmission() : all.has_reflection(), function, "the table",
                transmitted ? "one that holds transmission" : "one that holds reflection",
                transmitted ? "reflection alone" : "transmission alone");
        const TableView view = all.at(FamilyPoint(member));
        for (std::size_t k = 0; k < member.size(); ++k)
            require(holds((*all.family)[k], member[k]), function, (*all.family)[k].name(),
                    allowed_text((*all.family)[k]), member[k]);
        require_known(view, at, function);
        const bool mixes = all.has_family() && is_mixture(*all.family);
        if (single && multiple && table.packed() && (mixes || !all.has_family())) {
            look_up_packed(*table.packed(), side, at, mixes ? member[0] : 1, found);
        } else {
            for (std::size_t i = 0; i < at.count; ++i) {
                const Geometry geometry{at.mu_in[i], at.mu_out[i], at.azimuth[i]};
                const Scattered light =
                    scattering(view, side, at.albedo[i], at.optical_depth[i], geometry);
                found[i] = (single ? light.single : 0) + (multiple ? light.multiple : 0);
            }
        }
    });
    return numpy_array(std::move(found));
}

}  // namespace

void add_table(py::module_& module) {
    py::class_<AnyTable, Shared>(module, "Table")
        .def("is_packed", [](const AnyTable& table) { return table.packed() != nullptr; })
        .def("attributes", [](const AnyTable& table) { return table.table().attributes; })
        .def("facts", facts)
        .def("axes", axis_values)
        .def("scales", axis_scales)
        .def("look_up", look_up)
        .def("write", write_file);
    module.def("read_table", read);
    module.def("datasets", datasets);
    module.def("packed", packed);
    module.def("unpacked", unpacked);
}

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
