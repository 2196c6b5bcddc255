// The subcommands, one file each. Each function registers a command with its options and callback.
#pragma once

#include <CLI/CLI.hpp>

namespace stratus {

void add_solve(CLI::App& app);
void add_bake(CLI::App& app);
void add_eval(CLI::App& app);
void add_info(CLI::App& app);
void add_verify(CLI::App& app);
void add_convert(CLI::App& app);
void add_pack(CLI::App& app);
void add_seal(CLI::App& app);
void add_export(CLI::App& app);
void add_shader(CLI::App& app);
void add_fit(CLI::App& app);
void add_cost(CLI::App& app);
void add_phase(CLI::App& app);
void add_plan(CLI::App& app);
void add_render(CLI::App& app);
void add_view(CLI::App& app);

}  // namespace stratus
