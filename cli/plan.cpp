// `stratus plan`: which effects a scene needs, what each contributes and costs, and the recipe of
// its table.
#include <stratus/bake/parallel.h>
#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/io/file_bytes.h>
#include <stratus/picture/png.h>
#include <stratus/scene/contents.h>
#include <stratus/scene/plan.h>

#include "options.h"
#include "progress.h"

#include <array>
#include <cmath>
#include <iostream>
#include <map>
#include <set>

namespace stratus {
namespace {

// ---- Where each effect changes a picture, in false colours

constexpr double least_change = 1e-4;  // where the scale begins; it ends at 1
constexpr int panels_a_row = 4, panel_width = 256, title_height = 24, scale_height = 74;

/// From black over purple, red and orange to pale yellow, ever brighter.
std::array<float, 3> false_colour(double change) {
    constexpr std::array<std::array<double, 3>, 5> stops{{{0, 0, 0.02},
                                                          {0.34, 0.06, 0.43},
                                                          {0.73, 0.21, 0.33},
                                                          {0.98, 0.56, 0.04},
                                                          {0.99, 1, 0.64}}};
    const double place =
        std::clamp(1 - std::log10(std::max(change, least_change)) / std::log10(least_change), 0.0,
                   1.0) *
        (stops.size() - 1);
    const std::size_t first = std::min(stops.size() - 2, static_cast<std::size_t>(place));
    const double share = place - static_cast<double>(first);
    std::array<float, 3> colour;
    for (std::size_t c = 0; c < 3; ++c)
        colour[c] = static_cast<float>(
            srgb_decoded((1 - share) * stops[first][c] + share * stops[first + 1][c]));
    return colour;
}

/// A picture under construction, with the labels of its panels.
struct Page {
    Image image;
    std::vector<Label> labels;

    /// Fills a rectangle: colour_at(x, y), in pixels from its upper left corner.
    template <class ColourAt>
    void fill(int left, int top, int width, int height, const ColourAt& colour_at) {
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                std::ranges::copy(colour_at(x, y), image.pixel(left + x, top + y));
    }
};

int panel_height(const Image& picture) {
    return std::max(1, picture.height * panel_width / picture.width);
}

std::vector<const EffectShare*> shown_effects(const PlanReport& report) {
    std::vector<const EffectShare*> shown;
    for (const EffectShare& share : report.shares)
        if (!share.changes.empty() && std::ranges::max(share.changes) > 0) shown.push_back(&share);
    return shown;
}

/// Draws the scene's picture and its effects from a row on.
void draw_scene(const PlanReport& report, const std::string& title, double white, int top,
                Page& page) {
    const Image& picture = report.picture;
    const int height = panel_height(picture);
    const std::vector<const EffectShare*> shown = shown_effects(report);
    for (int k = 0; k <= int_size(shown); ++k) {
        const EffectShare* const share = k == 0 ? nullptr : shown[size(k) - 1];
        const int left = k % panels_a_row * panel_width,
                  above = top + k / panels_a_row * (height + title_height);
        page.labels.push_back(
            {left + 6.0, above + title_height - 7.0, panel_width - 12.0,
             share ? share->name + ", " + short_number(share->max, 2) + " at most" : title});
        page.fill(left, above + title_height, panel_width, height, [&](int x, int y) {
            const int across = x * picture.width / panel_width,
                      down = std::min(picture.height - 1, y * picture.height / height);
            const float* const pixel = picture.pixel(across, down);
            if (share)
                return false_colour(double{share->changes[size(down * picture.width + across)]});
            const auto scale = static_cast<float>(1 / white);
            return std::array<float, 3>{scale * pixel[0], scale * pixel[1], scale * pixel[2]};
        });
    }
}

void draw_scale(int top, Page& page) {
    const int width = panels_a_row * panel_width - 2 * 60;
    page.fill(60, top + 4, width, 16, [&](int x, int) {
        return false_colour(std::pow(least_change, 1 - static_cast<double>(x) / (width - 1)));
    });
    for (int k = 0; k <= 4; ++k)
        page.labels.push_back({50.0 + width * k / 4.0, top + 38.0, 100,
                               short_number(least_change * std::pow(10, k))});
    page.labels.push_back({50, top + 62.0, static_cast<double>(width),
                           "relative change of each pixel's light without the effect"});
}

/// Draws, for each scene, its sparse picture and beside it a panel for each effect that shows there:
/// the relative change of each pixel without the effect, on one logarithmic scale below.
///
/// Errors   std::runtime_error naming the path and the reason.
void write_change_picture(const SceneFile& file, const std::vector<PlanReport>& reports,
                          const std::string& path) {
    std::vector<int> tops{0};
    for (const PlanReport& report : reports) {
        const int panels = 1 + int_size(shown_effects(report));
        tops.push_back(tops.back() + (panels + panels_a_row - 1) / panels_a_row *
                                         (panel_height(report.picture) + title_height));
    }
    Page page{Image(panels_a_row * panel_width, tops.back() + scale_height), {}};
    for (std::size_t k = 0; k < reports.size(); ++k)
        draw_scene(reports[k], panel_name(file, k), file.panels[k].white, tops[k], page);
    draw_scale(tops.back(), page);
    write_file(path, std::bind_front(write_png, std::cref(page.image), 1, page.labels));
}

// ---- The command

struct PlanCommand {
    std::string scene, recipe, picture, drop;
    CacheOptions cache;
    double tolerance = 0;
    int width = 0, threads = 0;
    bool quiet = false;
};

constexpr double shown_pixels = 16384;  // of each panel of --picture

std::string short_text(const std::string& whole) {
    constexpr std::size_t max_length = 60;
    return whole.size() <= max_length ? whole : whole.substr(0, max_length - 3) + "...";
}

std::string range_text(const Range& range, const char* unit = "") {
    if (range.min > range.max) return "none";
    return range.min == range.max ? formatted("%.3g%s", range.min, unit)
                                  : formatted("%.3g to %.3g%s", range.min, range.max, unit);
}

void print_contents(const Scene& scene) {
    const bool one_each = !scene.layer.channels.empty();
    const std::vector<PhaseFunction>& parts =
        one_each ? scene.layer.channels : scene.layer.components;
    constexpr const char* labels[] = {"red:   ", "green: ", "blue:  "};
    for (std::size_t c = 0; c < scene.layer.stacks.size(); ++c)
        for (const StackLayer& layer : scene.layer.stacks[c])
            std::cout << (&layer != &scene.layer.stacks[c][0] ? "       "
                          : one_each                          ? labels[c]
                                                              : "stack: ")
                      << short_text(layer.phase_function.text()) << ", albedo "
                      << short_number(layer.albedo) << ", optical depth "
                      << short_number(layer.optical_depth) << "\n";
    std::vector<std::string> texts;
    for (const PhaseFunction& part : parts)
        texts.push_back(one_each ? part.text() : short_text(part.text()));
    if (scene.layer.stacks.empty())
        std::cout << "layer: " << joined(texts, one_each ? "\n       " : " mixed with ");
    const SeenLight light = seen_light(scene);
    const SeenDirections seen = seen_directions(scene);
    const MatterSpan matter = whole_matter_span(scene);
    std::vector<std::string> sides;
    if (light.reflection) sides.emplace_back("the lit side");
    if (light.transmission) sides.emplace_back("the unlit side");
    if (light.fluxes) sides.emplace_back("what lies behind");
    std::cout << "\nseen: " << (sides.empty() ? "nothing" : joined(sides)) << "; optical depth "
              << range_text(matter.optical_depth) << ", albedo " << range_text(matter.albedo)
              << "\n      mu_in " << range_text(seen.mu_in) << ", mu_out "
              << range_text(seen.mu_out) << ", azimuth " << range_text(seen.azimuth, " deg")
              << "\n\n";
    if (const std::optional<Scene> planet = planet_scene(scene)) {
        std::cout << "its planet\n";
        print_contents(*planet);
    }
}

/// "multiple, azimuth and shadows".
std::string listed(const std::vector<std::string>& names) {
    if (names.size() < 2) return joined(names);
    return joined({names.begin(), names.end() - 1}) + " and " + names.back();
}

/// Says in one sentence what a scene should simulate.
std::string describe_plan(const PlanReport& report) {
    std::vector<std::string> kept, idle;
    for (const EffectShare& share : report.shares)
        if (share.seen && report.plan.effects.*share.effect)
            (share.max > 0 ? kept : idle).push_back(share.name);
    std::string answer = kept.empty() ? "nothing" : listed(kept);
    for (const auto& [name, change] : report.plan.left_out)
        answer += "; " +
                  std::string(name == "multiple"  ? "orders n >= 2"
                              : name == "azimuth" ? "their azimuth"
                                                  : "the shell") +
                  " may be left out, without which light changes by " +
                  (change.change > 0 ? formatted("about %.2g at most", change.change) : "nothing");
    if (report.plan.left_out.empty()) answer += "; leave out nothing";
    if (!idle.empty())
        answer += "; " + listed(idle) + (idle.size() == 1 ? " shows nowhere" : " show nowhere");
    return answer + formatted(" (tolerance %.2g)", report.plan.tolerance);
}

/// Prints what to simulate: one line for all panels with the same answer.
void print_answers(const SceneFile& file, const std::vector<PlanReport>& reports) {
    std::vector<std::pair<std::string, std::vector<std::string>>> answers;
    for (std::size_t k = 0; k < reports.size(); ++k) {
        const std::string answer = describe_plan(reports[k]);
        auto same = std::ranges::find(answers, answer, [](const auto& each) { return each.first; });
        if (same == answers.end()) same = answers.insert(answers.end(), {answer, {}});
        same->second.push_back(panel_name(file, k));
    }
    for (const auto& [answer, panels] : answers)
        std::cout << (answers.size() > 1 ? joined(panels, "; ") + ": simulate " : "Simulate ")
                  << answer << ".\n";
    std::cout << "\n";
}

void print_orders(const OrderReport& orders) {
    std::cout << "\norder of scattering: share of the light that is seen of the "
              << (orders.side == Side::reflection ? "lit" : "unlit") << " side, at " << orders.where
              << "\n";
    double left = 1;
    for (std::size_t n = 0; n < orders.share.size(); ++n) {
        left -= orders.share[n];
        std::cout << formatted("  %3zu  %8.2g, all beyond %8.2g\n", n + 1, orders.share[n],
                               std::max(0.0, left));
    }
    const bool listed = orders.enough <= std::ssize(orders.share);
    std::cout << (listed ? "" : "about ")
              << formatted("%d orders suffice for the tolerance there.\n", orders.enough);
}

void print_plan(const PlanReport& report) {
    std::cout << "effect          mean       max   tables s        MB  fate, and where the largest "
                 "change is\n";
    for (const EffectShare& share : report.shares) {
        if (!share.seen) {
            std::cout << formatted("%-12s        -         -          -         -  %s\n",
                                   share.name.c_str(), share.fate.c_str());
            continue;
        }
        std::cout << formatted("%-12s %7.2g  %s%7.2g  %9.2f %9.2f  ", share.name.c_str(),
                               share.mean, share.estimated ? "~ " : "  ", share.max,
                               share.table_seconds, share.table_bytes * 1e-6)
                  << share.fate << (share.where.empty() ? "" : "; " + share.where) << '\n';
    }
    std::cout
        << "means, and maxima without ~, which marks estimates, are those of a sparse picture "
           "of "
        << report.picture.width << " x " << report.picture.height << " pixels, one ray each\n";
    for (const OrderReport& orders : report.orders) print_orders(orders);
}

void print_cost(const FileReport& report, int frames, double reading, int threads, double planning,
                double planning_processor) {
    const TableCost& tables = report.cost.tables;
    const double seconds = reading + report.cost.seconds(),
                 next = report.cost.light_seconds + report.cost.ray_seconds;
    std::cout << formatted(
        "\nrender takes about %.2f s of processor time, %.2f s on %d thread%s: reading %.2f, "
        "choosing %.2f, solving %.2f, checking %.2f, packing tables %.2f, preparing light %.2f, "
        "rays %.2f\n",
        seconds, reading + report.cost.seconds() / threads, threads, threads == 1 ? "" : "s",
        reading, tables.choose_seconds, tables.solve_seconds, tables.check_seconds,
        tables.pack_seconds, report.cost.light_seconds, report.cost.ray_seconds);
    if (frames > 1)
        std::cout << formatted(
            "that is the first frame, of which all is told above; tables serve all %d, each "
            "further one "
            "takes about %.2f s of processor time if it is alike, all together %.2f s\n",
            frames, next, seconds + (frames - 1) * next);
    std::cout << formatted("planning took %.2f s, %.2f s of processor time", planning,
                           planning_processor)
              << (report.kept_seconds > 0
                      ? formatted(", of which %.2f s made choices that render will find",
                                  report.kept_seconds)
                      : "")
              << "\n";
}

/// A recipe of a table that serves a light path of all panels and frames, and the name of its file's ending:
/// "", "_shine", "_red", "_shine_red", "_planet".
struct PlannedRecipe {
    Recipe recipe;
    std::string ending;
};

/// The ending of each of a scene's channel_scenes.
std::vector<std::string> channel_endings(const Scene& scene) {
    std::vector<std::string> endings{""};
    if (!scene.layer.channels.empty()) endings = {"_red", "_green", "_blue"};
    if (const std::optional<Scene> planet = planet_scene(scene))
        for (const std::string& ending : channel_endings(*planet))
            endings.push_back("_planet" + ending);
    return endings;
}

/// One for each light path, or for each and red, green and blue; colours that are alike share one.
std::vector<PlannedRecipe> planned_recipes(const Film& film,
                                           const std::vector<PlanReport>& reports) {
    std::map<std::pair<std::size_t, LightPath>, PlannedRecipe> all;
    const Scenes scenes = all_panels(film);
    for (std::size_t k = 0; k < scenes.size(); ++k) {
        Scene scene = scenes[k];
        leave_out(reports[k % reports.size()].plan, scene);
        const Scenes channels = channel_scenes(scene);
        const std::vector<std::string> endings = channel_endings(scene);
        for (std::size_t c = 0; c < channels.size(); ++c)
            for (const auto& [path, own] : needed_recipes(channels[c])) {
                const auto [planned, is_new] = all.try_emplace({c, path});
                PlannedRecipe& both = planned->second;
                const std::optional<Recipe> wider = is_new ? own : common_recipe(both.recipe, own);
                if (!wider)
                    throw std::invalid_argument(
                        "plan: SCENE must have panels that can share a recipe" +
                        (scene.title.empty() ? "" : "; '" + scene.title + "' needs its own"));
                both.recipe = *wider;
                both.ending = endings[c];
                if (path != LightPath::sunlight)
                    both.ending = std::string("_") + light_path_name(path) + endings[c];
            }
    }
    std::vector<PlannedRecipe> recipes;
    std::set<std::string> texts;
    for (auto& [place, planned] : all)
        if (texts.insert(resolved_text(planned.recipe)).second)
            recipes.push_back(std::move(planned));
    return recipes;
}

/// NAME_red.toml and so on.
std::string path_with(const fs::path& path, const std::string& ending) {
    const std::string name = path.stem().string() + ending + path.extension().string();
    return (path.parent_path() / name).string();
}

void run_plan(const PlanCommand& command) {
    if (!command.recipe.empty()) require_output("plan", "--write", command.recipe, {command.scene});
    if (!command.picture.empty())
        require_output("plan", "--picture", command.picture, {command.scene}, {".png"});
    Progress progress(command.quiet);
    std::vector<std::string> notes;
    const auto start = Clock::now();
    const double started = processor_seconds();
    const std::unique_ptr<TableCache> cache = open_cache(command.cache);
    Film film = read_film(command.scene, &notes);
    const SceneFile& file = film[0];
    const double reading = processor_seconds() - started;
    progress.notes(notes);
    require(!file.figure, "plan", "SCENE", "a picture", "a figure: " + command.scene);
    change({{}, split(command.drop), command.width, command.tolerance}, film);
    const Scenes later = all_panels({film.begin() + 1, film.end()});
    BakeOptions options;
    options.threads = command.threads;
    options.progress = std::ref(progress);
    const FileReport report =
        report_plans(file.panels, options, cache.get(),
                     command.picture.empty() ? few_pixels : shown_pixels, later);
    if (!command.picture.empty()) write_change_picture(file, report.scenes, command.picture);
    const std::vector<PlanReport>& reports = report.scenes;
    print_answers(file, reports);
    for (std::size_t k = 0; k < reports.size(); ++k) {
        if (file.panels.size() > 1)
            std::cout << (k > 0 ? "\n" : "") << "== " << panel_name(file, k) << "\n";
        print_contents(file.panels[k]);
        print_plan(reports[k]);
    }
    print_cost(report, file.frames, reading, thread_count(command.threads), seconds_since(start),
               processor_seconds() - started);
    const std::vector<PlannedRecipe> recipes = planned_recipes(film, reports);
    if (recipes.empty()) {
        std::cout << "\nNo table is needed: single scattering has a closed form.\n";
        if (!command.recipe.empty())
            throw std::runtime_error("plan: --write has nothing to write, no table is needed");
        return;
    }
    const std::string name = fs::path(command.scene).filename().string();
    for (const PlannedRecipe& planned : recipes) {
        Recipe recipe = planned.recipe;
        recipe.title = file.title;
        const std::string recipe_text =
            (recipes.size() == 1 ? "# The table that " : "# One of the tables that ") + name +
            " needs.\n" + resolved_text(recipe);
        std::cout << "\n" << recipe_text;
        if (!command.recipe.empty())
            write_content_held(
                recipes.size() == 1 ? command.recipe : path_with(command.recipe, planned.ending),
                recipe_text);
    }
}

}  // namespace

void add_plan(CLI::App& app) {
    const auto [command, options] = add_command<PlanCommand>(
        app, "plan", "Which effects a scene needs, and what they cost", run_plan);
    add_file(command, "SCENE", options.scene, "Scene, .toml")->required();
    command
        .add_option("--tolerance", options.tolerance,
                    "Relative change of a pixel that is tolerated, instead of the scene's own")
        ->check(number_in("[1e-6, 0.5]"));
    add_file(command, "--write", options.recipe,
             "Recipe to write, .toml; with NAME_fluxes.toml and NAME_shine.toml for light "
             "paths with tables of their own, NAME_red.toml and so on for a phase "
             "function or stack each, and NAME_planet.toml for a planet's layer within rings");
    add_file(command, "--picture", options.picture,
             "Picture of where each effect changes the scene, in false colours, .png");
    add_drop(command, options.drop);
    add_width(command, options.width);
    add_cache(command, options.cache);
    add_threads(command, options.threads);
    add_quiet(command, options.quiet);
    command.footer(
        "The first line says what to simulate. Largest changes with ~ are estimates over all that "
        "the\n"
        "scene contains: its albedos, depths and the directions that it sees, by the solver "
        "itself,\n"
        "with a margin. Others, and means, are those of a sparse picture of some 400 pixels,\n"
        "relative to at least 1 % of the brightest. The orders n >= 2, or their azimuth, and a "
        "shell\n"
        "are left out where they are estimated to change no more than half the tolerance, unless "
        "the\n"
        "scene names them. Costs are what tables take more for an effect: seconds of one processor "
        "and\n"
        "MB.\n"
        "`stratus render` follows the plan unless --effects says otherwise, and finds the choices "
        "of\n"
        "its tables that the plan made. Each recipe is one of `stratus bake RECIPE -o "
        "TABLE.stratus`,\n"
        "and `stratus render SCENE` takes each of the tables by --table.\n"
        "Example:\n  stratus plan tables/scenes/saturn_lit.toml --write saturn_lit_needs.toml");
}

}  // namespace stratus
