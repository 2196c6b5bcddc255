// Stack files: the TOML file that says what layers lie on top of one another.
//
//     [[layers]]                      # top first, as many as there are
//     phase_function = "rayleigh"
//     albedo = 1.0
//     optical_depth = 0.2             # finite; the last one may be inf where there is no [below]
//                                     # Scenes and exports take three of each, of red, green and
//                                     # blue: albedo = [0.7, 0.9, 1.0]
//
//     [below]                         # may be left out
//     lambert_albedo = 0.3            # a surface; or phase_function and albedo: a semi-infinite
//                                     # layer
//
// A stack file is a recipe, too (recipe.h), of the stack as one material; what else it may say for
// that is read there alone.
#pragma once

#include <stratus/layer/lower_boundary.h>
#include <stratus/layer/stack_layers.h>
#include <stratus/transfer/solve_to_tolerance.h>

#include <filesystem>
#include <string>
#include <vector>

namespace stratus {

/// The arguments of solve_stack.
struct Stack {
    StackLayers layers;  // top first
    LowerBoundary lower_boundary;

    double optical_depth() const;  // of all layers
    /// Whether nothing absorbs light, the lower boundary included.
    bool is_lossless() const;
};

/// Returns the share of uniform light that layers and lower boundary absorb, by fluxes of all orders, or of
/// so many: it then contains the light of higher ones.
double absorptance(const Stack& stack, const SolvedFluxes& fluxes, int orders = 0);

/// Reads a stack from TOML text; files it names are looked for below `directory`. Notes for the
/// user go to `notes`. `name`: of its file, in refusals.
///
/// Errors   std::invalid_argument naming file, line, key, the allowed range and the value met;
///          unknown keys with the nearest known; lists of three, for this is one colour;
///          std::runtime_error for files that cannot be read.
Stack parse_stack(const std::string& text, const std::string& directory = "",
                  std::vector<std::string>* notes = nullptr, const std::string& name = "");

/// Reads a stack from a file. Errors: std::runtime_error when it cannot be read.
Stack read_stack(const std::filesystem::path& path, std::vector<std::string>* notes = nullptr);

/// Reads the stack of a file, or, where a layer has lists of three, those of red, green and blue.
/// Errors: as above.
std::vector<Stack> read_coloured_stack(const std::filesystem::path& path,
                                       std::vector<std::string>* notes = nullptr);

}  // namespace stratus
