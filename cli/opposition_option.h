// The options --density and --opposition of commands that look at layers.
#pragma once

#include <stratus/layer/effects.h>

#include <CLI/CLI.hpp>

#include <string>

namespace stratus {

void add_density_and_opposition(CLI::App& command, std::string& density, std::string& opposition);

/// A share of the volume, or `number=N,radius=R` of the particles that fill it.
///
/// Errors   std::invalid_argument naming the command.
double parse_density(const std::string& command, const std::string& text);

/// `blinn`, or `hapke` and what it is given of `width=H` and `amplitude=A`; the rest follows from
/// the density.
///
/// Errors   std::invalid_argument naming the command.
Opposition parse_opposition(const std::string& command, const std::string& text, double density);

}  // namespace stratus
