// TOML files: the keys that they may have, then their sections as they are read.
//
// Keys of the TOML files that users write: one table of recipes here, one of scenes in
// stratus/scene/scene.h. Files are read by these tables alone: a key without a row is refused,
// ranges are checked and defaults taken as the row says. A new key is a new row, and the line that
// reads it.
#pragma once

#include <stratus/base/argument.h>
#include <stratus/io/file_bytes.h>
#include <stratus/io/table_file.h>
#include <stratus/layer/lower_boundary.h>

#include <toml++/toml.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {

struct Key {
    const char* name;           // after the tables that it stands in: "camera.look_at"
    const char* form;           // of the value: "number", "string", "table", ...
    const char* unit;           // "-" without one
    const char* range;          // "[0, 1)" of every number of the value; or words; "-" without one
    const char* default_value;  // as TOML text; words in parentheses where there is none
    const char* meaning;

    /// The name in the table that it stands in.
    std::string own_name() const {
        const std::string full = name;
        return full.substr(full.rfind('.') + 1);
    }
};

using Keys = std::span<const Key>;

/// Returns the keys of recipes, in the order of reading.
Keys recipe_keys();

/// Returns the keys of stack files (stack_file.h): the layers, and those that bake them as one material.
Keys stack_keys();

/// A header and a line for each key: name, form, unit, range, default and meaning, with two
/// blanks or more between.
std::string key_columns(Keys keys);

// Shared reading of the TOML files that users write: keys, ranges and defaults by the rows of
// toml_section.h; refusals that name the line.

/// Where phase functions find the files that they name, and where notes on them go.
struct PhaseSource {
    std::filesystem::path directory;
    std::vector<std::string>* notes;
};

/// A file as refusals name it.
struct TomlFile {
    const char* caller;  // "recipe", "stack" or "scene"
    std::string name;    // empty: text that comes from no file

    /// "NAME, line 7: "; without the line of what is not in the file.
    std::string place(const toml::node& node) const;
};

/// One table of a file. Refuses unknown keys, naming the nearest known one, and values that are not
/// as the key's row says.
///
/// Errors   std::invalid_argument "caller: file, line 7: key must be allowed, got value";
///          std::logic_error where a key is asked for that has no row.
class Section {
  public:
    /// The root of a file.
    Section(const toml::table& table, const TomlFile& file, Keys keys);
    /// A table within, `name` in refusals, whose rows are those of the section `kind`.
    Section(const toml::table& table, const TomlFile& file, Keys keys, const std::string& name,
            const std::string& kind);

    /// The table under a key, whose rows are those of the section `kind`, or of the key within this
    /// section's; empty where the key is absent but not required.
    Section section(const char* key, const std::string& kind = "") const;

    bool has(const char* key) const { return row(key), table_.contains(key); }
    bool is_table(const char* key) const { return row(key), table_.get_as<toml::table>(key); }
    bool is_list(const char* key) const { return row(key), table_.get_as<toml::array>(key); }
    /// True when the key is there and is this text.
    bool is(const char* key, const char* text) const;

    // Values, or their defaults; refused where there is neither.
    std::string text(const char* key) const;
    bool flag(const char* key) const;
    double number(const char* key) const;
    /// `allowed` in place of the row's range: it depends on other values.
    double number(const char* key, double min, double max, const char* allowed) const;
    int count(const char* key) const;
    /// From `least` to `most` of them.
    std::vector<double> numbers(const char* key, std::size_t least, std::size_t most) const;
    /// Three numbers, or one that is all three.
    std::array<double, 3> three(const char* key) const;
    std::vector<std::string> texts(const char* key, std::size_t least, std::size_t most) const;
    /// The key's text is one of its row's.
    std::string choice(const char* key, const std::vector<std::string>& choices) const;
    const toml::array& tables(const char* key) const;

    /// "FILE, line 7: section.key", of the key, or of its section where it is absent: the subject
    /// of refusals.
    std::string at(const char* key) const;
    /// Names the place of the section itself.
    std::string here() const;

    /// Refuses what a key has unless `holds`.
    template <class Value>
    void require(bool holds, const char* key, const std::string& allowed, const Value& met) const {
        stratus::require(holds, file_.caller, at(key), allowed, met);
    }

    /// Returns read(); its refusals are told with the place of the key.
    template <class Read>
    auto placed(const char* key, const Read& read) const {
        try {
            return read();
        } catch (const std::invalid_argument& error) {
            throw std::invalid_argument(told(key, error.what()));
        } catch (const std::runtime_error& error) {
            throw std::runtime_error(told(key, error.what()));
        }
    }
    PhaseFunction phase_function(const char* key, const PhaseSource& source) const;
    /// A list of `count`.
    std::vector<PhaseFunction> phase_functions(const char* key, std::size_t count,
                                               const PhaseSource& source) const;

  private:
    const Key& row(const char* key) const;
    /// Refuses what is not as the key's row says.
    template <class Value>
    void require_allowed(bool holds, const char* key, const Value& met) const;
    /// The value, or its default out of `defaults`.
    const toml::node& node(const char* key, toml::table& defaults) const;
    template <class T>
    T value(const char* key) const;
    const toml::array& list(const char* key, std::size_t least, std::size_t most,
                            toml::table& defaults) const;
    std::string told(const char* key, const char* what) const;

    const toml::table& table_;
    TomlFile file_;
    Keys keys_;
    std::string name_, kind_;
};

/// A value as TOML writes it.
std::string toml_text(const toml::node& node);

/// Most parts of a dotted key, and most brackets within each other: the library calls itself for
/// each, and its stack ends.
constexpr int max_key_parts = 32, max_nesting = 32;

/// Returns the file's root table. Errors: std::invalid_argument naming the line, or the kind of file
/// that was given in place of the caller's.
toml::table parse_toml(const std::string& text, const TomlFile& file);

/// The table [below]: lambert_albedo, ground, or phase_function and albedo.
LowerBoundary read_lower_boundary(const Section& file, const char* caller,
                                  const PhaseSource& source);

}  // namespace stratus
