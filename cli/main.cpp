// The program `stratus`: passes its arguments to a subcommand and returns an exit code.
//
// Exit code 0: done. 2: wrong usage, which is whatever CLI11 cannot parse and every
// std::invalid_argument (a value, a row of a query, a file name's ending). 1: all other failures (a
// file, a library, a failed check). 128 + signal: a bake was interrupted and can be resumed. Errors
// are one line on stderr.
#include <stratus/base/argument.h>

#include "options.h"
#include "progress.h"

#include <cerrno>
#include <cstring>
#include <exception>
#include <iostream>
#include <malloc.h>
#include <new>

namespace {

int refuse(int exit_code, const std::string& message) {
    stratus::say(message);
    return exit_code;
}

/// Has the allocator keep what solves free for the next ones, which are alike: given back to the
/// system, it would be cleared page by page each time, a twentieth of a small bake.
void keep_freed_memory() {
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the most that glibc allows; larger ones are given back
    mallopt(M_TRIM_THRESHOLD, 256 << 20);
#endif
}

/// Throws if the output could not be written, because of a full disk or a closed pipe.
void flush_standard_output() {
    errno = 0;
    if (std::cout.flush() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
    throw std::runtime_error(std::string("standard output: ") +
                             (errno != 0 ? std::strerror(errno) : "write error"));
}

/// Refuses a word that stands for no command, with the nearest that does.
void refuse_unknown_command(const CLI::App& app) {
    const std::vector<std::string> unread = app.remaining();
    if (!app.get_subcommands().empty() || unread.empty() || unread[0].starts_with('-')) return;
    std::vector<std::string> known;
    for (const CLI::App* command : app.get_subcommands(nullptr))
        known.push_back(command->get_name());
    throw std::invalid_argument("COMMAND must be one of " + stratus::joined(known) + ", got '" +
                                unread[0] + "'; did you mean '" +
                                stratus::nearest_name(unread[0], known) + "'?");
}

int run(int argc, char** argv) {
    CLI::App app{"Multiple scattering tables for clouds, rings, haze and dusty ground.", "stratus"};
    app.set_version_flag("--version", "stratus " STRATUS_VERSION);
    app.footer(
        "Example:\n  stratus info saturn_rings.h5\n"
        "Options of each command: stratus COMMAND --help");
    app.require_subcommand(0, 1);  // 0: with 1, CLI11 would not name a misspelt one
    using namespace stratus;
    for (AddCommand* const add :
         {add_solve, add_bake, add_eval, add_info, add_verify, add_convert, add_pack, add_seal,
          add_export, add_shader, add_fit, add_cost, add_phase, add_plan, add_render, add_view})
        add(app);

    try {
        app.parse(argc, argv);
        if (app.get_subcommands().empty()) throw CLI::RequiredError("COMMAND");
    } catch (const CLI::ExtrasError&) {
        refuse_unknown_command(app);
        throw;
    } catch (const CLI::Success& help_or_version) {
        app.exit(help_or_version);
    }
    flush_standard_output();
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    keep_freed_memory();
    std::signal(SIGXFSZ, SIG_IGN);  // a write beyond `ulimit -f` fails instead, and says so
    try {
        return run(argc, argv);
    } catch (const stratus::EndedBySignal& error) {
        return refuse(error.exit_code, error.what());
    } catch (const CLI::ParseError& error) {
        return refuse(2, std::string(error.what()) + " (see --help)");
    } catch (const std::invalid_argument& error) {
        return refuse(2, error.what());
    } catch (const std::bad_alloc&) {
        return refuse(1, "out of memory");
    } catch (const std::exception& error) {
        return refuse(1, error.what());
    }
}
