// Recipes: the TOML file that says what table to bake. tolerance is the one knob; the rest follows
// from it. A stack file (stack_file.h) is a recipe of the stack as one material.
#pragma once

#include <stratus/base/axis.h>
#include <stratus/layer/lower_boundary.h>
#include <stratus/layer/stack_layers.h>
#include <stratus/phase/phase_family.h>
#include <stratus/phase/phase_function.h>
#include <stratus/transfer/solver_options.h>

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace stratus {

/// Closed range of a table axis.
struct Range {
    double min;
    double max;
};

/// An axis over a parameter of the phase function (phase_family.h), lengths in um: a range, sampled
/// as the tolerance asks, or just some values, of which lookups take one.
struct FamilyRange {
    PhaseParameter parameter;
    Range range;                 // from the first value to the last
    std::vector<double> values;  // ascending; empty: a range
};

/// How finely a table is solved and sampled. 0 stands for "as the tolerance asks".
struct Discretisation {
    int nodes = 0;                             // Gauss nodes of the solver, [1, 512]
    int modes = 0;                             // azimuthal modes
    int mu_samples = 0;                        // of mu_in and mu_out alike
    int azimuth_samples = 0;                   // over 0 .. 180 degrees, ends included
    int optical_depth_samples_per_octave = 0;  // a whole number: doubling goes by octaves
    double deepest_optical_depth = 0;  // last finite sample of an axis that ends at infinity
    int albedo_samples = 0;
    std::array<int, max_family_axes> family_samples{};  // of the ranges of a family
    Scheme scheme = Scheme::harmonic;
    /// linear or square_root; open: the cheaper one, or linear where azimuth_samples is given.
    std::optional<AxisScale> azimuth_scale = std::nullopt;
    /// square_root_of_complement or fourth_root_of_complement; open: the cheaper one, or the former
    /// where albedo_samples is given.
    std::optional<AxisScale> albedo_scale = std::nullopt;
};

struct Recipe {
    std::string title;
    std::string phase_text;               // as given
    PhaseFunction phase_function;         // as read
    PhaseFunction second_phase_function;  // of families with a mixture axis
    // At most two; the mixture's range is of shares of the first in all that is scattered, [0, 1].
    std::vector<FamilyRange> family;
    // Whether the path law (path_law.h) is left to lookups, of all members of the family alike;
    // open: not decided yet.
    std::optional<bool> leaves_path_law;
    bool exact_fluxes = true;      // as in SolverOptions; no key sets it
    double tolerance = 1e-3;       // relative error of R and T asked for
    Range optical_depth{0.01, 8};  // (0, inf]; min = max = inf: the semi-infinite layer alone
    Range albedo{0, 1};            // [0, 1]
    // Directions that the table knows, all unless narrowed; min = max: one alone.
    Range mu_in{0, 1}, mu_out{0, 1};  // [0, 1], max at least 1e-4
    Range azimuth{0, 180};            // degrees, [0, 180], max above 0
    int orders = 0;                   // light scattered more often is left out, [2, 100]; 0: all
    LowerBoundary lower_boundary;     // what the layer lies on; then there is reflection alone
    // The layers of a stack, top first; empty: one layer. phase_function, optical_depth and albedo are then
    // those of mean_layer, with min = max.
    StackLayers layers;
    bool reflection = true;
    bool transmission = true;
    Discretisation discretisation;
    std::string text;  // the file as it was
};

/// Reads a recipe from TOML text, whose keys are recipe_keys() (toml_section.h), or stack_keys() where it
/// has [[layers]]; files it names are looked for below `directory`. Notes for the user go to
/// `notes`. `name`: of its file, in refusals.
///
/// Errors   std::invalid_argument naming file, line, key, the allowed range and the value met;
///          unknown keys with the nearest known; std::runtime_error for files that cannot be read.
Recipe parse_recipe(const std::string& text, const std::string& directory = "",
                    std::vector<std::string>* notes = nullptr, const std::string& name = "");

/// Reads a recipe from a file. Errors: std::runtime_error when it cannot be read.
Recipe read_recipe(const std::filesystem::path& path, std::vector<std::string>* notes = nullptr);

/// The recipe of a stack as one material, for the tolerance, sides and all else that are left as
/// they are in Recipe; no transmission where nothing passes.
///
/// Errors   std::invalid_argument for layers as of check_layers (stack_layers.h), and for a total
///          depth below 1e-6.
Recipe recipe_of_stack(StackLayers layers, const LowerBoundary& lower_boundary);

/// Checks the ranges of directions.
///
/// Errors   std::invalid_argument naming the key, the allowed range and the value met.
void check_directions(const Recipe& recipe);

/// The recipe of one point of its family alone. One without a family comes back as it is.
Recipe at_member(const Recipe& recipe, const FamilyPoint& point);

/// A recipe's range of mixtures with a second phase function, to be widened; null where it has none.
Range* mixture_range(Recipe& recipe) noexcept;
const Range* mixture_range(const Recipe& recipe) noexcept;

/// True where its family is the mixtures of two phase functions and nothing else.
bool is_mixture_alone(const Recipe& recipe) noexcept;

/// Makes the recipe one of mixtures of its phase function with a second one.
void set_mixture(Recipe& recipe, const PhaseFunction& second, Range shares);

/// TOML text of a recipe. Of a resolved one every choice is spelled out, so that the same table can
/// be baked again from it alone; what is left open is left out.
std::string resolved_text(const Recipe& recipe);

}  // namespace stratus
