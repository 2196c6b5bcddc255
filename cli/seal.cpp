// `stratus seal`: new checksums for a table whose numbers were changed on purpose.
#include <stratus/io/table_file.h>

#include "commands.h"
#include "query.h"
#include "signals.h"
#include "table_option.h"

#include <memory>
#include <string>

namespace stratus {
namespace {

struct SealOptions {
    std::string table, output;
    ReadOptions reading;
};

void run_seal(const SealOptions& options) {
    const std::string output = options.output.empty() ? options.table : options.output;
    require_table_ending("seal", "TABLE", options.table);
    require_table_ending("seal", "--output", output);
    require_writable("seal", "--output", output);
    ReadOptions reading = options.reading;
    reading.ignore_checksums = true;
    const Table table = read_table(options.table, reading);
    const SignalsHeld held;
    write_table(table, output);
}

}  // namespace

void add_seal(CLI::App& app) {
    auto options = std::make_shared<SealOptions>();
    CLI::App* command = app.add_subcommand(
        "seal", "Write a table that was changed on purpose with checksums of what it holds now");
    command->add_option("TABLE", options->table, "Table that was changed, .h5 or .exr")->required();
    command->add_option("-o,--output", options->output,
                        "File to write, .h5 or .exr. Default: TABLE itself");
    add_max_memory(*command, options->reading);
    command->footer(
        "What it holds must be a valid table. Its measured error is still that of the bake; see\n"
        "`stratus verify`. Attributes of your own are kept if they are text or numbers, datasets "
        "of\n"
        "your own are not.\n\n"
        "Example:\n  stratus seal saturn_rings.h5");
    command->callback([options] { run_seal(*options); });
}

}  // namespace stratus
