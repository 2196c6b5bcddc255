// Options that several commands have, and validators, which refuse in the house form: option, allowed
// range, value met.
//
// CLI11 alone would read an empty value as zero and 010 as eight.
#pragma once

#include <stratus/bake/keys.h>
#include <stratus/layer/effects.h>
#include <stratus/table/ground.h>

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace stratus {

/// A number for which `holds` is true; never nan. `allowed` names its range: "in [0, 1]".
CLI::Validator number(const std::string& allowed, bool (*holds)(double value));

/// Numbers in [0, 1] and in [0, inf].
CLI::Validator number_in_0_1();
CLI::Validator number_in_0_inf();

/// A decimal whole number in [min, max].
CLI::Validator whole_number(long long min, long long max);

/// Anything but the empty text that a script passes when its variable is unset.
CLI::Validator file_name();

/// The parts of a comma-separated list.
std::vector<std::string> split(const std::string& list);

/// The ground of the option --over of a command, which refusals name.
LowerBoundary read_over(const std::string& command, const std::string& text);

/// Adds the option --threads; `more` ends its help.
void add_threads(CLI::App& command, int& threads, const std::string& more = "");

/// Adds --nodes or --tolerance of the solver, and --accept; `more` ends the help of --nodes.
void add_accuracy(CLI::App& command, int& nodes, double& tolerance, bool& accept,
                  const std::string& more = "");

/// Adds the option --keys, which prints a file's keys and ends the program.
void add_keys(CLI::App& command, const std::string& files, Keys keys);

/// Adds the options --density and --opposition of commands that look at layers.
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
