// `stratus convert`: the same table in the other file format, lossless both ways.
#include <stratus/io/table_file.h>

#include "commands.h"
#include "query.h"
#include "signals_held.h"
#include "table_option.h"

#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>

namespace stratus {
namespace {

struct ConvertOptions {
    std::string input;
    std::string output;
    ReadOptions reading;
};

/// Refuses before a long read what the writer would refuse after it.
void check_ending(const char* argument, const std::string& path) {
    const std::string ending = std::filesystem::path(path).extension().string();
    if (ending == ".h5" || ending == ".exr") return;
    throw std::invalid_argument(std::string("convert: ") + argument +
                                " must end in .h5 or .exr, got " + path);
}

void run_convert(const ConvertOptions& options) {
    check_ending("IN", options.input);
    check_ending("OUT", options.output);
    require_different_files("convert", options.input, options.output);
    const Table table = read_noted_table(options.input, options.reading);
    const SignalsHeld held;
    write_table(table, options.output);
}

}  // namespace

void add_convert(CLI::App& app) {
    auto options = std::make_shared<ConvertOptions>();
    CLI::App* command =
        app.add_subcommand("convert", "Write a table in the other file format, losslessly");
    command->add_option("IN", options->input, "Table to read, .h5 or .exr")->required();
    command->add_option("OUT", options->output, "Table to write, .h5 or .exr")->required();
    add_max_memory(*command, options->reading);
    command->footer("Example:\n  stratus convert saturn_rings.h5 saturn_rings.exr");
    command->callback([options] { run_convert(*options); });
}

}  // namespace stratus
