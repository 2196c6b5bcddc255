#include "toml_section.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace stratus {

namespace {

std::string line_of(const toml::node& node) {
    return " in line " + std::to_string(node.source().begin.line);
}

}  // namespace

Section::Section(const toml::table& table, const char* caller, const std::string& name,
                 std::vector<std::string> known)
    : table_(table), caller_(caller), prefix_(name.empty() ? "" : name + ".") {
    for (const auto& [key, node] : table) {
        const std::string met(key.str());
        if (std::find(known.begin(), known.end(), met) != known.end()) continue;
        throw std::invalid_argument(std::string(caller) + ": unknown key '" + prefix_ + met + "'" +
                                    line_of(node) + "; did you mean '" + prefix_ +
                                    nearest_name(met, known) + "'?");
    }
}

template <class T>
T Section::value(const char* key, const char* kind) const {
    const toml::node* node = table_.get(key);
    require(node != nullptr, caller_, prefix_ + key, "present", "nothing");
    const auto met = node->value<T>();
    if (met) return *met;
    std::ostringstream text;
    text << toml::node_view<const toml::node>(node);
    require(false, caller_, prefix_ + key + line_of(*node), kind, text.str());
    return {};
}

std::string Section::text(const char* key) const {
    return value<std::string>(key, "a string in quotes");
}

double Section::number(const char* key, double min, double max, const char* allowed) const {
    const double met = value<double>(key, "a number");
    require(met >= min && met <= max, caller_, prefix_ + key, allowed, met);
    return met;
}

int Section::count(const char* key, int min, int max, const std::string& besides) const {
    const std::string allowed =
        besides + "a whole number in [" + std::to_string(min) + ", " + std::to_string(max) + "]";
    const auto met = value<std::int64_t>(key, allowed.c_str());
    require(met >= min && met <= max, caller_, prefix_ + key, allowed, met);
    return static_cast<int>(met);
}

bool Section::flag(const char* key) const {
    const auto met = table_.get(key)->value_exact<bool>();
    require(met.has_value(), caller_, prefix_ + key, "true or false", "another value");
    return *met;
}

bool Section::is(const char* key, const char* text) const {
    return has(key) && table_.get(key)->value_exact<std::string>() == text;
}

const toml::table& Section::table(const char* key, const char* form) const {
    const toml::table* met = table_.get_as<toml::table>(key);
    require(met != nullptr, caller_, prefix_ + key, form, "another kind of value");
    return *met;
}

std::vector<std::string> Section::texts(const char* key, const char* form) const {
    const toml::array* met = table_.get_as<toml::array>(key);
    require(met != nullptr, caller_, prefix_ + key, form, "another kind of value");
    std::vector<std::string> values;
    for (const toml::node& node : *met) {
        const auto one = node.value_exact<std::string>();
        require(one.has_value(), caller_, prefix_ + key, form, "another kind of entry");
        values.push_back(*one);
    }
    return values;
}

std::vector<double> Section::numbers(const char* key, double min, double max,
                                     const char* allowed) const {
    const toml::array* met = table_.get_as<toml::array>(key);
    const std::string form = std::string("a list of numbers ") + allowed;
    require(met != nullptr, caller_, prefix_ + key, form, "another kind of value");
    std::vector<double> values;
    for (const toml::node& node : *met) {
        const auto one = node.value<double>();
        require(one.has_value(), caller_, prefix_ + key, form, "another kind of entry");
        require(*one >= min && *one <= max, caller_, prefix_ + key, form, *one);
        values.push_back(*one);
    }
    return values;
}

toml::table parse_toml(const std::string& text, const char* caller) {
    try {
        return toml::parse(text);
    } catch (const toml::parse_error& error) {
        std::ostringstream line;
        line << caller << ": line " << error.source().begin.line << ": " << error.description();
        throw std::invalid_argument(line.str());
    }
}

std::string read_text(const std::filesystem::path& path) {
    std::ifstream file(path);
    if (!file || std::filesystem::is_directory(path))
        throw std::runtime_error(path.string() + ": cannot be read");
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

LowerBoundary read_lower_boundary(const Section& file, const char* caller,
                                  const PhaseSource& source) {
    const Section section(file.table("below", "a table: [below]"), caller, "below",
                          {"lambert_albedo", "phase_function", "albedo"});
    constexpr const char* forms = "lambert_albedo alone, or both phase_function and albedo";
    if (section.has("lambert_albedo")) {
        require(!section.has("phase_function") && !section.has("albedo"), caller, "below", forms,
                "lambert_albedo and more");
        return LowerBoundary::surface(section.number("lambert_albedo", 0, 1, "in [0, 1]"));
    }
    const bool has_phase = section.has("phase_function"), has_albedo = section.has("albedo");
    require(has_phase && has_albedo, caller, "below", forms,
            has_phase    ? "phase_function alone"
            : has_albedo ? "albedo alone"
                         : "nothing");
    return LowerBoundary::layer(
        read_phase_function(section.text("phase_function"), source.directory, source.notes),
        section.number("albedo", 0, 1, "in [0, 1]"));
}

}  // namespace stratus
