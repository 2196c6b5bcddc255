// Keys of the TOML files that users write: one table of recipes here, one of scenes in
// stratus/scene/scene.h. Files are read by these tables alone: a key without a row is refused,
// ranges are checked and defaults taken as the row says. A new key is a new row, and the line that
// reads it.
#pragma once

#include <span>
#include <string>

namespace stratus {

struct Key {
    const char* section;  // table that it stands in; "" at the top of the file
    const char* name;
    const char* form;           // of the value: "number", "string", "table", ...
    const char* unit;           // "-" without one
    const char* range;          // "[0, 1)" of every number of the value; or words; "-" without one
    const char* default_value;  // as TOML text; words in parentheses where there is none
    const char* meaning;
};

using Keys = std::span<const Key>;

/// Returns the keys of recipes, in the order of reading.
Keys recipe_keys();

/// Returns the keys of stack files (stack_file.h): the layers, and those that bake them as one material.
Keys stack_keys();

/// "section.name", or the name of a key at the top.
std::string full_name(const Key& key);

/// A header and a line for each key: full name, form, unit, range, default and meaning, with two
/// blanks or more between.
std::string key_columns(Keys keys);

}  // namespace stratus
