// `stratus plan`: which effects a scene needs, what each contributes and costs, and the recipe of
// its table.
#include <stratus/scene/plan.h>

#include <stratus/io/atomic_file.h>
#include <stratus/runtime/argument.h>

#include "allowed.h"
#include "commands.h"
#include "progress.h"
#include "query.h"
#include "signals_held.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {
namespace {

struct PlanCommand {
    std::string scene, recipe;
    double tolerance = 0;
    int threads = 0;
    bool quiet = false;
};

template <class... Arguments>
std::string text(const char* format, Arguments... arguments) {
    char line[256];
    std::snprintf(line, sizeof line, format, arguments...);
    return line;
}

std::string short_text(const std::string& whole) {
    constexpr std::size_t max_length = 60;
    return whole.size() <= max_length ? whole : whole.substr(0, max_length - 3) + "...";
}

std::string range_text(const Range& range, const char* unit = "") {
    if (range.min > range.max) return "none";
    return range.min == range.max ? text("%.3g%s", range.min, unit)
                                  : text("%.3g to %.3g%s", range.min, range.max, unit);
}

/// In columns.
std::string cost_text(const SceneCost& cost) {
    return text("%9.2f %9.2f %9.0f", cost.bake_seconds, cost.bytes * 1e-6, cost.ray_ns);
}

SceneCost operator-(const SceneCost& all, const SceneCost& some) {
    return {all.bake_seconds - some.bake_seconds, all.bytes - some.bytes, all.ray_ns - some.ray_ns};
}

void print_range(const Scene& scene) {
    const LookupRange range = measure_range(scene);
    const bool one_each = !scene.layer.channels.empty();
    const std::vector<PhaseFunction>& parts =
        one_each ? scene.layer.channels : scene.layer.components;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        const std::string part = parts[k].text();
        std::cout << (k == 0     ? "layer: "
                      : one_each ? "\n       "
                                 : " mixed with ")
                  << (one_each ? part : short_text(part));
    }
    const char* const sides = range.reflection
                                  ? (range.transmission ? "both sides" : "the lit side")
                                  : (range.transmission ? "the unlit side" : "no side");
    std::cout << "\nseen: " << sides << "; optical depth " << range_text(range.optical_depth)
              << ", albedo " << range_text(range.albedo) << "\n      mu_in "
              << range_text(range.mu_in) << ", mu_out " << range_text(range.mu_out) << ", azimuth "
              << range_text(range.azimuth, " deg") << "\n\n";
}

void print_plan(const Plan& plan) {
    const PlanCosts& costs = *plan.costs;
    std::cout << "effect            mean       max  needed    bake s        MB    ns/ray\n";
    std::vector<std::string> without_effect;
    for (std::size_t e = 0; e < plan.shares.size(); ++e) {
        const EffectShare& share = plan.shares[e];
        if (share.max == 0 && costs.without[e].bytes == costs.all.bytes) {
            without_effect.push_back(share.name);
            continue;
        }
        std::cout << text("%-13s %8.2g  %8.2g  %-6s ", share.name.c_str(), share.mean, share.max,
                          share.needed ? "yes" : "no")
                  << cost_text(costs.all - costs.without[e]) << '\n';
    }
    std::cout << "all effects                              " << cost_text(costs.all)
              << "\nthe plan                                 " << cost_text(costs.planned)
              << text("\nIt changes none of %d pixels by more than %.2g; tolerance: %.2g.\n",
                      plan.pixels, plan.max_change, plan.tolerance);
    if (!without_effect.empty())
        std::cout << "No visible effect: " << joined(without_effect) << ".\n";
}

/// The recipe of one table for all panels; of three where channels have their own phase functions.
std::vector<Recipe> planned_recipes(const SceneFile& file, const std::vector<Plan>& plans) {
    std::vector<Recipe> all;
    for (std::size_t k = 0; k < plans.size(); ++k) {
        Scene scene = file.panels[k];
        scene.effects = plans[k].effects;
        std::vector<Recipe> own;
        for (const Scene& channel : channel_scenes(scene))
            if (const std::optional<Recipe> one = needed_recipe(channel)) own.push_back(*one);
        if (own.empty()) continue;
        if (all.empty()) all = own;
        for (std::size_t c = 0; c < all.size(); ++c) {
            const std::optional<Recipe> both =
                own.size() == all.size() ? common_recipe(all[c], own[c]) : std::nullopt;
            if (!both)
                throw std::invalid_argument(
                    "plan: SCENE must have panels that can share a recipe; '" + scene.title +
                    "' needs its own");
            all[c] = *both;
        }
    }
    return all;
}

void write_recipe(const std::string& recipe, const std::string& path) {
    const SignalsHeld held;
    write_atomically(path, [&](const std::filesystem::path& temporary) {
        std::ofstream out(temporary, std::ios::binary);
        out << recipe;
        out.close();
        if (!out) throw std::runtime_error(path + ": cannot be written");
    });
}

void run_plan(const PlanCommand& command) {
    if (!command.recipe.empty()) {
        require_writable("plan", "--write", command.recipe);
        require_different_files("plan", command.scene, command.recipe);
    }
    Progress progress(command.quiet);
    std::vector<std::string> notes;
    SceneFile file = read_scene(command.scene, &notes);
    for (const std::string& note : notes) progress.note("note: " + note);
    if (file.figure)
        throw std::invalid_argument("plan: SCENE must be a picture, got a figure: " +
                                    command.scene);
    for (const Scene& scene : file.panels)
        if (!command.recipe.empty() && !scene.layer.channels.empty())
            throw std::invalid_argument(
                "plan: --write must be left out for three phase functions, which need a recipe "
                "each");
    if (command.tolerance > 0)
        for (Scene& scene : file.panels) scene.tolerance = command.tolerance;
    BakeOptions options;
    options.threads = command.threads;
    options.progress = [&](double done, const std::string& stage) { progress.show(done, stage); };
    const std::vector<Plan> plans = plan_scenes(file.panels, {options, true});
    for (std::size_t k = 0; k < plans.size(); ++k) {
        if (file.panels.size() > 1)
            std::cout << (k > 0 ? "\n" : "") << "== " << file.panels[k].title << "\n";
        print_range(file.panels[k]);
        print_plan(plans[k]);
    }
    const std::vector<Recipe> recipes = planned_recipes(file, plans);
    if (recipes.empty()) {
        std::cout << "\nNo table is needed: single scattering has a closed form.\n";
        if (!command.recipe.empty())
            throw std::runtime_error("plan: --write has nothing to write, no table is needed");
        return;
    }
    const std::string name = std::filesystem::path(command.scene).filename().string();
    std::string recipe_text;
    for (Recipe recipe : recipes) {
        recipe.title = file.title;
        recipe_text = (recipes.size() == 1 ? "# The table that " : "# One of the tables that ") +
                      name + " needs.\n" + resolved_text(recipe);
        std::cout << "\n" << recipe_text;
    }
    if (!command.recipe.empty()) write_recipe(recipe_text, command.recipe);
}

}  // namespace

void add_plan(CLI::App& app) {
    auto command = std::make_shared<PlanCommand>();
    CLI::App* plan = app.add_subcommand("plan", "Which effects a scene needs, and what they cost");
    plan->add_option("SCENE", command->scene, "Scene, .toml")->required();
    plan->add_option("--tolerance", command->tolerance,
                     "Relative change of a pixel that is tolerated, instead of the scene's own")
        ->check(number("in [1e-6, 0.5]", [](double e) { return e >= 1e-6 && e <= 0.5; }));
    plan->add_option("--write", command->recipe, "Recipe to write, .toml")->check(file_name());
    add_threads(*plan, command->threads);
    plan->add_flag("--quiet", command->quiet, "No progress, no notes");
    plan->footer(
        "Each effect is left out in turn, and some 16000 pixels are compared: the mean and the\n"
        "largest relative change (to at least 1 % of the brightest pixel). An effect that changes\n"
        "no pixel by more than half the tolerance is not needed. Costs are what an effect adds:\n"
        "seconds to bake, MB of tables, ns per ray on one thread.\n"
        "`stratus render` follows the plan unless --effects says otherwise.\n"
        "Example:\n  stratus plan tables/scenes/saturn_lit.toml --write saturn_lit_needs.toml");
    plan->callback([command] { run_plan(*command); });
}

}  // namespace stratus
