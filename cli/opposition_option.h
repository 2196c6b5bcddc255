// The options --density and --opposition of commands that look at layers.
#pragma once

#include <stratus/runtime/effects.h>

#include <CLI/CLI.hpp>

#include <string>

namespace stratus {

void add_density_and_opposition(CLI::App& command, double& density, std::string& opposition);

/// `blinn`, whose width is that of the density, or `hapke:width=H` and `,amplitude=A`.
///
/// Errors   std::invalid_argument naming the command.
Opposition parse_opposition(const std::string& command, const std::string& text, double density);

}  // namespace stratus
