// `stratus bake`: a recipe in, a table out.
#include "allowed.h"
#include "commands.h"
#include "progress.h"
#include "query.h"
#include "signals_held.h"

#include <stratus/bake/bake.h>
#include <stratus/io/table_file.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <future>
#include <memory>
#include <string>
#include <vector>

namespace stratus {
namespace {

struct BakeCommand {
    std::string recipe, output, exr;
    int threads = 0;
    bool quiet = false;
};

void run_bake(const BakeCommand& command) {
    require_writable("bake", "--output", command.output, ".h5");
    if (!command.exr.empty()) require_writable("bake", "--exr", command.exr, ".exr");
    require_different_files("bake", command.recipe, command.output);
    require_different_files("bake", command.recipe, command.exr);
    std::vector<std::string> notes;
    const Recipe recipe = read_recipe(command.recipe, &notes);

    const auto started = std::chrono::steady_clock::now();
    Progress progress(command.quiet);
    for (const std::string& note : notes) progress.note("note: " + note);
    BakeOptions options;
    options.threads = command.threads;
    options.note = [&](const std::string& line) { progress.note("  " + line); };
    options.progress = [&](double done, const std::string& stage) { progress.show(done, stage); };
    const Table table = bake(recipe, options);
    const SignalsHeld held;
    // The two libraries know nothing of each other: both files are compressed at the same time.
    std::future<void> picture;
    if (!command.exr.empty())
        picture = std::async(std::launch::async, [&] { write_table(table, command.exr); });
    write_table(table, command.output);
    if (picture.valid()) picture.get();

    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
    char line[160];
    std::snprintf(line, sizeof line,
                  "%zu samples a side, %.1f MiB on disk, %.2f s; largest error at random points "
                  "%.2g, asked for %.2g",
                  table.sample_count(),
                  static_cast<double>(std::filesystem::file_size(command.output)) / 1048576,
                  seconds, table.measured_error, table.tolerance);
    progress.note(line);
}

}  // namespace

void add_bake(CLI::App& app) {
    auto command = std::make_shared<BakeCommand>();
    CLI::App* bake = app.add_subcommand("bake", "Bake a table from a recipe");
    bake->add_option("RECIPE", command->recipe, "Recipe, .toml")->required();
    bake->add_option("-o,--output", command->output, "Table to write, .h5")->required();
    bake->add_option("--exr", command->exr, "The same table as a picture file, .exr")
        ->check(file_name());
    bake->add_option("--threads", command->threads, "Threads; 0: one for each processor")
        ->capture_default_str()
        ->check(whole_number(0, 1024));
    bake->add_flag("--quiet", command->quiet, "No progress, no notes");
    bake->footer(
        "A recipe with a second_phase_function bakes both in any mixture, of which lookups choose "
        "one.\n"
        "Example:\n  stratus bake tables/saturn_rings.toml -o saturn_rings.h5 --exr "
        "saturn_rings.exr");
    bake->callback([command] { run_bake(*command); });
}

}  // namespace stratus
