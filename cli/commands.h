// The subcommands, a file each but for convert, pack and seal. Each function registers a command with its options and callback.
#pragma once

#include <CLI/CLI.hpp>

namespace stratus {

using AddCommand = void(CLI::App& app);

AddCommand add_solve, add_bake, add_eval, add_info, add_verify, add_convert, add_pack, add_seal,
    add_export, add_shader, add_fit, add_cost, add_phase, add_plan, add_render, add_view;

}  // namespace stratus
