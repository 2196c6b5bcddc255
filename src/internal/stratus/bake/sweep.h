// Sweeps: many tables from one recipe, one for each row of a CSV file or of the recipe's [sweep].
//
// Each column is a key of the recipe, dotted where it stands in a section ("discretisation.nodes";
// of a stack also "layers.2.albedo", counted from the top): its cells take the place of what the
// recipe has there. A cell of a CSV holds what the recipe would, texts with or without quotes; an
// empty one leaves the recipe as it is. [sweep] has a list of values for each key, all of one
// length. The column `name` names the tables, or else they are numbered from 1.
#pragma once

#include <stratus/bake/recipe.h>
#include <stratus/table/table.h>

#include <filesystem>
#include <string>
#include <vector>

namespace stratus {

struct SweepRow {
    std::string name;  // of its table
    Recipe recipe;     // whose text is the recipe with the row's cells in it
};

/// Whether the recipe has a [sweep]. Errors: as of read_recipe, for what is no TOML.
bool has_sweep(const std::filesystem::path& recipe);

/// The rows of the recipe's [sweep], or of a CSV in its place. Notes for the user go to `notes`,
/// each once.
///
/// Errors   as of read_recipe, naming the CSV's line, or the table's number, and the column's key;
///          std::invalid_argument for a column that is no key, with the nearest known, for a name
///          twice or one that is no file's, for no rows, for lists that differ in length, and for a
///          CSV beside a [sweep]; std::runtime_error for files that cannot be read.
std::vector<SweepRow> read_sweep(const std::filesystem::path& recipe,
                                 std::vector<std::string>* notes = nullptr);
std::vector<SweepRow> read_sweep(const std::filesystem::path& recipe,
                                 const std::filesystem::path& csv,
                                 std::vector<std::string>* notes = nullptr);

/// Whether a table was baked of this recipe, by a program of this version, with the same files of
/// phase functions.
bool is_baked_from(const Table& table, const Recipe& recipe);

/// Whether the errors that a table states meet its tolerance, as Verification::meets.
bool states_tolerance_met(const Table& table);

}  // namespace stratus
