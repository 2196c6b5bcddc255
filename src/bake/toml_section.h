// What the TOML files that users write have in common: keys checked by name, values by range.
#pragma once

#include <stratus/io/phase_file.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/lower_boundary.h>

#include <toml++/toml.h>

#include <filesystem>
#include <string>
#include <vector>

namespace stratus {

/// One table of a file. Refuses unknown keys, naming the nearest known one; refusals begin with the
/// `caller`: "recipe", "stack" or "scene".
class Section {
  public:
    Section(const toml::table& table, const char* caller, const std::string& name,
            std::vector<std::string> known);

    bool has(const char* key) const { return table_.contains(key); }
    std::string text(const char* key) const;
    double number(const char* key, double min, double max, const char* allowed) const;
    /// Of a key that is there.
    bool flag(const char* key) const;
    /// `besides`: other forms allowed, as the start of the refusal's range.
    int count(const char* key, int min, int max, const std::string& besides = "") const;
    /// True when the key is there and is this text.
    bool is(const char* key, const char* text) const;
    const toml::table& table(const char* key, const char* form) const;
    std::vector<std::string> texts(const char* key, const char* form) const;
    /// A list of numbers, each in [min, max].
    std::vector<double> numbers(const char* key, double min, double max, const char* allowed) const;
    bool is_table(const char* key) const { return table_.get_as<toml::table>(key) != nullptr; }
    bool is_list(const char* key) const { return table_.get_as<toml::array>(key) != nullptr; }

    /// The key's name in refusals.
    std::string full_name(const char* key) const { return prefix_ + key; }

  private:
    template <class T>
    T value(const char* key, const char* kind) const;

    const toml::table& table_;
    const char* caller_;
    std::string prefix_;
};

/// Where phase functions find the files that they name, and where notes on them go.
struct PhaseSource {
    std::string directory;
    std::vector<std::string>* notes;
};

/// The file's root table. Errors: std::invalid_argument naming the line.
toml::table parse_toml(const std::string& text, const char* caller);

/// A whole file. Errors: std::runtime_error when it cannot be read.
std::string read_text(const std::filesystem::path& path);

/// The table [below]: lambert_albedo, or phase_function and albedo.
LowerBoundary read_lower_boundary(const Section& file, const char* caller,
                                  const PhaseSource& source);

}  // namespace stratus
