// `stratus pack`: the small file that lookups, renderers and pages read.
#include <stratus/base/number_text.h>
#include <stratus/io/atomic_file.h>
#include <stratus/table/packed_table.h>

#include "commands.h"
#include "query.h"
#include "signals.h"
#include "table_option.h"

#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {
namespace {

struct PackOptions {
    std::string input, output;
    ReadOptions reading;
    bool quiet = false;
};

void run_pack(const PackOptions& options) {
    require_writable("pack", "--output", options.output, {packed_ending});
    require_different_files("pack", options.input, options.output);
    if (is_packed(options.input))
        throw std::invalid_argument("pack: TABLE must end in .h5 or .exr, got " + options.input);
    const Table table = read_table(options.input, options.reading);
    const std::vector<char> packed = pack(table);
    {
        const SignalsHeld held;
        write_content_atomically(options.output, packed);
    }
    if (options.quiet) return;
    const double samples = 4.0 * static_cast<double>(table.reflection_multiple.size() +
                                                     table.transmission_multiple.size());
    const double size = static_cast<double>(packed.size());
    std::cerr << "stratus: " << options.output << ": " << short_number(size / 1e6, 3) << " MB, "
              << short_number(100 * size / samples, 3) << " % of the table's samples\n";
}

}  // namespace

void add_pack(CLI::App& app) {
    auto options = std::make_shared<PackOptions>();
    CLI::App* command = app.add_subcommand(
        "pack", "Write the small file of a table that fast lookups map into memory");
    command->add_option("TABLE", options->input, "Table to read, .h5 or .exr")->required();
    command->add_option("-o,--output", options->output, "File to write, .stratus")->required();
    command->add_flag("--quiet", options->quiet, "Do not report the size");
    add_max_memory(*command, options->reading);
    command->footer(
        "eval, verify, info and render --table read it as they read a table; its accuracy is what\n"
        "`stratus verify` says. Keep the table: bind, edit and convert what is exact.\n\n"
        "Example:\n  stratus pack saturn_rings.h5 -o saturn_rings.stratus");
    command->callback([options] { run_pack(*options); });
}

}  // namespace stratus
