// `stratus convert`: all samples in the other file format, lossless both ways; those of a packed table as its
// lookups give them. `stratus pack`: a table in the small file that lookups map into memory. `stratus seal`: a table
// that was changed on purpose, with checksums of what it holds.
#include <stratus/base/number_text.h>
#include <stratus/io/file_bytes.h>
#include <stratus/io/table_file.h>
#include <stratus/table/packed_table.h>

#include "options.h"
#include "progress.h"
#include "query.h"

#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

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
