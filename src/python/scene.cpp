// Scenes: plans and pictures.
#include <stratus/io/table_file.h>
#include <stratus/scene/layer_tables.h>
#include <stratus/scene/plan.h>
#include <stratus/scene/render.h>
#include <stratus/scene/scene.h>

#include "module.h"

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace stratus::python {
namespace {

/// Recipes of the tables that serve a scene in all frames of a film, as text.
std::vector<std::string> list_recipes(Scenes frames, const Plan& plan) {
    for (Scene& frame : frames) leave_out(plan, frame);
    std::vector<std::string> recipes;
    for (const SharedRecipe& shared : shared_recipes(channel_scenes(frames)))
        recipes.push_back(resolved_text(shared.recipe));
    return recipes;
}

py::dict plan_dict(const Scenes& frames, const Plan& plan) {
    py::list left_out;
    for (const LeftOut& effect : plan.left_out)
        left_out.append(py::make_tuple(effect.name, effect.change.change, effect.change.found,
                                       effect.change.where));
    std::vector<std::string> effects;
    for (const auto& [name, effect] : scene_effects())
        if (plan.effects.*effect) effects.emplace_back(name);
    using namespace py::literals;
    return py::dict("title"_a = frames[0].title, "tolerance"_a = plan.tolerance,
                    "effects"_a = effects, "left_out"_a = left_out,
                    "recipes"_a = list_recipes(frames, plan));
}

/// Adds what each effect changes and costs.
void add_report(const PlanReport& report, py::dict& told) {
    py::list shares;
    for (const EffectShare& share : report.shares)
        shares.append(py::make_tuple(share.name, share.seen, share.mean, share.max, share.estimated,
                                     share.where, share.fate, share.table_seconds));
    told["shares"] = shares;
    py::dict orders;
    for (const OrderReport& side : report.orders)
        orders[side.side == Side::reflection ? "lit" : "unlit"] = side.share;
    told["orders"] = orders;
}

py::tuple plan(const std::string& text_or_path, bool is_path, std::optional<double> tolerance,
               const std::vector<std::string>& drop, bool measure, int threads,
               const py::object& progress) {
    std::vector<std::string> notes;
    Film film = is_path ? read_film(text_or_path, &notes) : parse_film(text_or_path, "", &notes);
    require(!film[0].figure, "plan", "scene", "a picture", "a figure");
    if (tolerance)
        require(*tolerance >= 1e-6 && *tolerance <= 0.5, "plan", "tolerance", "in [1e-6, 0.5]",
                *tolerance);
    change({{}, drop, 0, tolerance.value_or(0)}, film);
    const std::size_t panels = film[0].panels.size();
    std::vector<Scenes> frames(panels);
    for (const SceneFile& file : film)
        for (std::size_t k = 0; k < panels; ++k) frames[k].push_back(file.panels[k]);
    py::list plans;
    double seconds = std::numeric_limits<double>::quiet_NaN();
    if (measure) {
        const Scenes later = all_panels({film.begin() + 1, film.end()});
        const FileReport report =
            run_long(threads, py::none(), progress, [&](const BakeOptions& options) {
                return report_plans(film[0].panels, options, nullptr, few_pixels, later);
            });
        for (std::size_t k = 0; k < panels; ++k) {
            py::dict told = plan_dict(frames[k], report.scenes[k].plan);
            add_report(report.scenes[k], told);
            plans.append(told);
        }
        seconds = report.cost.seconds();
    } else {
        const auto planned = without_lock([&] { return follow_plans(film); });
        for (std::size_t k = 0; k < panels; ++k) plans.append(plan_dict(frames[k], planned[k]));
    }
    return py::make_tuple(plans, seconds, notes);
}

PackedTable packed_table(const std::string& path) {
    if (std::filesystem::path(path).extension() == ".stratus") return PackedTable(path);
    return PackedTable(pack(read_table(path)));
}

/// The radiance of one frame, height x width x 3, and notes.
py::tuple render_frame(const std::string& text_or_path, bool is_path, int frame,
                       const std::vector<std::string>& effects,
                       const std::vector<std::string>& drop, std::optional<int> width,
                       const std::vector<std::string>& table_paths, bool cached, int threads,
                       const py::object& progress) {
    std::vector<std::string> notes;
    Film film = is_path ? read_film(text_or_path, &notes) : parse_film(text_or_path, "", &notes);
    require(!film[0].figure, "render", "scene", "a picture", "a figure");
    require(frame >= 0 && frame < film[0].frames, "render", "frame",
            "in [0, " + std::to_string(film[0].frames - 1) + "]", frame);
    if (width) require(*width >= 1 && *width <= 16384, "render", "width", "in [1, 16384]", *width);
    change({effects, drop, width.value_or(0)}, film);
    const Image image = run_long(threads, py::none(), progress, [&](const BakeOptions& options) {
        if (effects.empty() && table_paths.empty()) follow_plans(film);
        std::vector<PackedTable> given;
        for (const std::string& path : table_paths) given.push_back(packed_table(path));
        std::optional<TableCache> cache;
        if (cached && !default_cache_folder().empty())
            cache.emplace(default_cache_folder(), default_cache_limit);
        const Scenes scenes = all_panels(film);
        const auto tables = given.empty() ? bake_for(scenes, options, cache ? &*cache : nullptr)
                                          : adopt_tables(scenes, std::move(given));
        RenderOptions rendering;
        rendering.threads = options.threads;
        rendering.progress = [&](double done, const std::string& stage) {
            if (options.log.stop()) throw WorkStopped();
            options.progress(done, stage);
        };
        return render(film, frame, tables, rendering);
    });
    return py::make_tuple(numpy_array(image.rgb), image.height, image.width, notes);
}

}  // namespace

void add_scene(py::module_& module) {
    module.def("plan", plan);
    module.def("render", render_frame);
}

}  // namespace stratus::python
