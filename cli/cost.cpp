// `stratus cost`: what accuracy costs in time and in bytes, as CSV and as a figure.
#include "allowed.h"
#include "commands.h"
#include "progress.h"
#include "query.h"

#include <stratus/bake/cost.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace stratus {
namespace {

struct CostCommand {
    std::string recipe, output, svg;
    CostOptions options;
    bool quiet = false;
};

void run_cost(const CostCommand& command) {
    if (!command.output.empty() && command.output != "-")
        require_writable("cost", "--output", command.output);
    if (!command.svg.empty()) require_writable("cost", "--svg", command.svg, ".svg");
    for (const std::string& written : {command.output, command.svg})
        require_different_files("cost", command.recipe, written);
    std::vector<std::string> notes;
    const Recipe recipe = read_recipe(command.recipe, &notes);

    Progress progress(command.quiet);
    for (const std::string& note : notes) progress.note("note: " + note);
    CostOptions options = command.options;
    options.note = [&](const std::string& line) { progress.note("  " + line); };
    options.progress = [&](double done, const std::string& stage) { progress.show(done, stage); };
    const CostStudy study = measure_cost(recipe, options);
    write_answer(command.output, [&](std::ostream& out) { write_cost(out, study.points); });
}

std::string help_of_columns() {
    std::string text =
        "Columns of the CSV, a row a point; empty where one does not belong to it:\n";
    for (const auto& [name, meaning] : cost_columns())
        text += "  " + std::string(name) + ": " + meaning + "\n";
    return text;
}

}  // namespace

void add_cost(CLI::App& app) {
    auto command = std::make_shared<CostCommand>();
    CLI::App* cost =
        app.add_subcommand("cost", "Measure what accuracy costs a recipe in time and bytes");
    cost->add_option("RECIPE", command->recipe, "Recipe, .toml")->required();
    cost->add_option("-o,--output", command->output, "CSV to write. Default or -: standard output")
        ->check(file_name());
    cost->add_option("--svg", command->svg, "Figure of both frontiers to draw, .svg")
        ->check(file_name());
    cost->add_option("--seconds", command->options.seconds,
                     "After which nothing new is measured, from cheap to dear")
        ->capture_default_str()
        ->check(number("above 0", [](double seconds) { return seconds > 0; }));
    cost->add_option("--threads", command->options.threads,
                     "Threads; 0: one for each processor. What is timed runs alone on one")
        ->capture_default_str()
        ->check(whole_number(0, 1024));
    cost->add_flag("--quiet", command->quiet, "No progress, no notes");
    cost->footer(help_of_columns() +
                 "Errors are relative to the total R or T, as `stratus verify` has them.\n"
                 "Example:\n  stratus cost tables/saturn_rings.toml -o cost.csv --svg cost.svg");
    cost->callback([command] { run_cost(*command); });
}

}  // namespace stratus
