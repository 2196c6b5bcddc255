// `stratus view`: a table as a web page to look at.
#include <stratus/view/page.h>

#include <stratus/base/number_text.h>
#include <stratus/io/atomic_file.h>

#include "commands.h"
#include "query.h"
#include "signals.h"
#include "options.h"

#include <iostream>
#include <memory>
#include <string>

namespace stratus {
namespace {

struct ViewOptions {
    std::string table, output, at;
    ReadOptions reading;
    bool quiet = false;
};

void run_view(const ViewOptions& options) {
    require_output("view", "--output", options.output, {options.table}, {".html"});
    const std::string page =
        view_page(read_member("view", options.table, options.reading, options.at));
    {
        const SignalsHeld held;
        write_content_atomically(options.output, page);
    }
    if (!options.quiet)
        std::cerr << "stratus: " << options.output << ": "
                  << short_number(static_cast<double>(page.size()) / 1e6, 3) << " MB\n";
}

}  // namespace

void add_view(CLI::App& app) {
    auto options = std::make_shared<ViewOptions>();
    CLI::App* command = app.add_subcommand("view", "Write a web page on which to look at a table");
    command->add_option("TABLE", options->table, "Table, .stratus, .h5 or .exr")->required();
    command->add_option("-o,--output", options->output, "File to write, .html")->required();
    command->add_option("--at", options->at, at_help());
    command->add_flag("--quiet", options->quiet, "Do not report the size");
    add_max_memory(*command, options->reading);
    command->footer(
        "The page is one file, needs no network, and draws by WebGL2: a lit sphere, rings, a slab "
        "over ground, and\n"
        "lobes, light scattered once beside all orders; of what can be lit from above alone, no "
        "rings. Tables\nmust be of both sides and all directions.\n\n"
        "Example:\n  stratus view saturn_rings.stratus -o saturn_rings.html");
    command->callback([options] { run_view(*options); });
}

}  // namespace stratus
