// `stratus convert`: all samples in the other file format, lossless both ways; those of a packed table as its
// lookups give them.
#include <stratus/io/table_file.h>

#include "commands.h"
#include "query.h"
#include "signals.h"
#include "table_option.h"

#include <memory>
#include <string>

namespace stratus {
namespace {

struct ConvertOptions {
    std::string input;
    std::string output;
    ReadOptions reading;
};

void run_convert(const ConvertOptions& options) {
    if (!is_packed(options.input)) require_table_ending("convert", "IN", options.input);
    require_table_ending("convert", "OUT", options.output);
    require_different_files("convert", options.input, options.output);
    const Table table = read_samples(options.input, options.reading);
    const SignalsHeld held;
    write_table(table, options.output);
}

}  // namespace

void add_convert(CLI::App& app) {
    auto options = std::make_shared<ConvertOptions>();
    CLI::App* command =
        app.add_subcommand("convert", "Write a table's samples in another file format");
    command
        ->add_option("IN", options->input,
                     "Table to read, .h5 or .exr, losslessly, or .stratus, whose lookups are "
                     "evaluated at its samples")
        ->required();
    command->add_option("OUT", options->output, "Table to write, .h5 or .exr")->required();
    add_max_memory(*command, options->reading);
    command->footer("Example:\n  stratus convert saturn_rings.h5 saturn_rings.exr");
    command->callback([options] { run_convert(*options); });
}

}  // namespace stratus
