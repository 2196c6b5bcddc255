#include <stratus/bake/toml_section.h>

#include <stratus/base/number_text.h>
#include <stratus/table/member_and_ground.h>

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <string_view>

namespace stratus {

namespace {

bool is_interval(std::string_view range) {
    return !range.empty() && (range[0] == '[' || range[0] == '(');
}

/// "a number in [0, 1]".
std::string allowed(const Key& key) {
    const std::string_view form = key.form, range = key.range;
    const bool counted = form.starts_with('"') || form.starts_with("one") ||
                         form.starts_with("two") || form.starts_with("three") ||
                         form.starts_with("true") || form.starts_with("tables");
    std::string text = (counted ? "" : "a ") + std::string(form);
    if (is_interval(range))
        text += " in " + std::string(range);
    else if (range != "-")
        text += ": " + std::string(range);
    return text;
}

/// Where the string or the comment ends that begins at `at`: at its last quotation mark, or at the
/// end of the line where there is none. `at` itself where neither begins.
std::size_t end_of_verbatim(std::string_view text, std::size_t at) {
    const char quote = text[at];
    if (quote != '#' && quote != '"' && quote != '\'') return at;
    const std::string three(3, quote);
    const bool is_long = quote != '#' && text.substr(at, 3) == three;
    for (std::size_t i = at + (is_long ? 3 : 1); i < text.size(); ++i) {
        if (text[i] == '\n' && !is_long) return i - 1;
        if (text[i] == '\\' && quote == '"')
            ++i;
        else if (is_long && text.substr(i, 3) == three)
            return i + 2;
        else if (!is_long && quote != '#' && text[i] == quote)
            return i;
    }
    return text.size() - 1;
}

/// Refuses what is nested too deep, before the library meets it. What is not TOML is left to the
/// library: it stops where it finds that.
void refuse_depth(std::string_view text, const TomlFile& file) {
    int parts = 1, depth = 0, line = 1;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const std::size_t end = end_of_verbatim(text, i);
        line +=
            static_cast<int>(std::count(text.begin() + static_cast<std::ptrdiff_t>(i),
                                        text.begin() + static_cast<std::ptrdiff_t>(end + 1), '\n'));
        i = end;
        const char letter = text[i];
        if (letter == '[' || letter == '{') ++depth;
        if (letter == ']' || letter == '}') depth = std::max(depth - 1, 0);
        if (letter == '.') ++parts;
        if (letter != '.' && std::string_view("\n=,[]{}").find(letter) != std::string_view::npos)
            parts = 1;
        if (parts <= max_key_parts && depth <= max_nesting) continue;
        const bool is_key = parts > max_key_parts;
        throw std::invalid_argument(
            std::string(file.caller) + ": " + (file.name.empty() ? "" : file.name + ", ") +
            "line " + std::to_string(line) + ": " +
            (is_key ? "a key must have at most " + std::to_string(max_key_parts) + " dotted parts"
                    : "brackets must be nested at most " + std::to_string(max_nesting) + " deep") +
            ", got more");
    }
}

/// A key's name after that of its table; "": the file's root.
std::string full_name(const std::string& table, const std::string& key) {
    return table.empty() ? key : table + "." + key;
}

/// Refuses a file of another kind than `wanted`, known by keys that this lacks.
void refuse_other_kind(const toml::table& root, const std::string& wanted,
                       const std::string& name) {
    struct Kind {
        std::string_view name;
        std::vector<std::string_view> keys;
        const char* commands;
    };
    static const Kind kinds[] = {
        {"scene",
         {"camera", "sun", "planet", "rings", "slab", "lobes", "lambert"},
         "`stratus render`"},
        {"stack", {"layers"}, "`stratus bake`, `export` and `solve --layers`"},
        {"recipe", {"phase_function", "family"}, "`stratus bake`"}};
    const auto met = std::ranges::find_if(kinds, [&](const Kind& kind) {
        return std::ranges::any_of(kind.keys, [&](auto key) { return root.contains(key); });
    });
    if (met == std::end(kinds) || (met->name == "stack" && wanted == "recipe")) return;
    require(met->name == wanted, wanted.c_str(), name, "a " + wanted,
            "a " + std::string(met->name) + ", which is for " + met->commands);
}

}  // namespace

std::string toml_text(const toml::node& node) {
    std::ostringstream text;
    text << toml::node_view<const toml::node>(node);
    return text.str();
}

std::string TomlFile::place(const toml::node& node) const {
    const auto line = node.source().begin.line;
    if (line == 0) return name.empty() ? "" : name + ": ";
    return (name.empty() ? "" : name + ", ") + "line " + std::to_string(line) + ": ";
}

Section::Section(const toml::table& table, const TomlFile& file, Keys keys)
    : Section(table, file, keys, "", "") {}

Section::Section(const toml::table& table, const TomlFile& file, Keys keys, const std::string& name,
                 const std::string& kind)
    : table_(table), file_(file), keys_(keys), name_(name), kind_(kind) {
    std::vector<std::string> known;
    for (const Key& key : keys_)
        if (full_name(kind_, key.own_name()) == key.name) known.push_back(key.own_name());
    if (known.empty()) throw std::logic_error("no keys of [" + kind_ + "] have rows");
    for (const auto& [key, node] : table) {
        const std::string met(key.str());
        if (is_listed(met, known)) continue;
        throw std::invalid_argument(std::string(file_.caller) + ": " + file_.place(node) +
                                    "unknown key '" + shown(full_name(name_, met)) +
                                    "'; did you mean '" +
                                    full_name(name_, nearest_name(met, known)) + "'?");
    }
}

Section Section::section(const char* key, const std::string& kind) const {
    static const toml::table empty;
    const bool required = std::string_view(row(key).default_value) == "(required)";
    require(has(key) || !required, key, "present", "nothing");
    require_allowed(!has(key) || is_table(key), key, "another kind of value");
    return {is_table(key) ? *table_.get_as<toml::table>(key) : empty, file_, keys_,
            full_name(name_, key), kind.empty() ? full_name(kind_, key) : kind};
}

const Key& Section::row(const char* key) const {
    const auto found = std::ranges::find(keys_, full_name(kind_, key), &Key::name);
    if (found == keys_.end())
        throw std::logic_error("key '" + std::string(key) + "' of [" + kind_ + "] has no row");
    return *found;
}

const toml::node& Section::node(const char* key, toml::table& defaults) const {
    const Key& its = row(key);
    if (const toml::node* const given = table_.get(key)) return *given;
    require(*its.default_value != '(', key, "present", "nothing");
    defaults = toml::parse("value = " + std::string(its.default_value));
    return *defaults.get("value");
}

template <class Value>
void Section::require_allowed(bool holds, const char* key, const Value& met) const {
    require(holds, key, allowed(row(key)), met);
}

template <class T>
T Section::value(const char* key) const {
    toml::table defaults;
    const toml::node& met = node(key, defaults);
    const auto value = met.value<T>();
    if (!value) require_allowed(false, key, toml_text(met));
    return *value;
}

bool Section::is(const char* key, const char* text) const {
    return has(key) && table_.get(key)->value_exact<std::string>() == text;
}

std::string Section::text(const char* key) const { return value<std::string>(key); }

bool Section::flag(const char* key) const { return value<bool>(key); }

double Section::number(const char* key) const {
    const double met = value<double>(key);
    require_allowed(NumberRange(row(key).range).holds(met), key, met);
    return met;
}

double Section::number(const char* key, double min, double max, const char* allowed) const {
    const double met = value<double>(key);
    require(met >= min && met <= max, key, allowed, met);
    return met;
}

int Section::count(const char* key) const {
    const auto met = value<std::int64_t>(key);
    require_allowed(NumberRange(row(key).range).holds(static_cast<double>(met)), key, met);
    return static_cast<int>(met);
}

const toml::array& Section::list(const char* key, std::size_t least, std::size_t most,
                                 toml::table& defaults) const {
    const toml::node& met = node(key, defaults);
    const toml::array* const list = met.as_array();
    if (list == nullptr) require_allowed(false, key, toml_text(met));
    require_allowed(list->size() >= least && list->size() <= most, key,
                    list->empty()
                        ? "an empty list"
                        : std::to_string(list->size()) + " of them, not " + std::to_string(least) +
                              (least == most ? "" : " to " + std::to_string(most)));
    return *list;
}

std::vector<double> Section::numbers(const char* key, std::size_t least, std::size_t most) const {
    toml::table defaults;
    const NumberRange range = row(key).range;
    std::vector<double> values;
    for (const toml::node& node : list(key, least, most, defaults)) {
        const auto one = node.value<double>();
        if (!one || !range.holds(*one)) require_allowed(false, key, toml_text(node));
        values.push_back(*one);
    }
    return values;
}

std::array<double, 3> Section::three(const char* key) const {
    if (!is_list(key) && has(key)) {
        const double all = number(key);
        return {all, all, all};
    }
    const std::vector<double> each = numbers(key, 3, 3);
    return {each[0], each[1], each[2]};
}

std::vector<std::string> Section::texts(const char* key, std::size_t least,
                                        std::size_t most) const {
    toml::table defaults;
    std::vector<std::string> values;
    for (const toml::node& node : list(key, least, most, defaults)) {
        const auto one = node.value_exact<std::string>();
        if (!one) require_allowed(false, key, toml_text(node));
        values.push_back(*one);
    }
    return values;
}

std::string Section::choice(const char* key, const std::vector<std::string>& choices) const {
    const std::string met = text(key);
    require_allowed(is_listed(met, choices), key, met);
    return met;
}

const toml::array& Section::tables(const char* key) const {
    const toml::array* const met = table_.get_as<toml::array>(key);
    require_allowed(met != nullptr && met->is_homogeneous<toml::table>(), key,
                    has(key) ? "another value" : "nothing");
    return *met;
}

std::string Section::at(const char* key) const {
    row(key);
    const toml::node* const met = table_.get(key);
    if (!met && name_.empty()) return (file_.name.empty() ? "" : file_.name + ": ") + key;
    return file_.place(met ? *met : table_) + full_name(name_, key);
}

std::string Section::here() const {
    if (name_.empty()) return file_.name.empty() ? file_.caller : file_.name;
    return file_.place(table_) + name_;
}

std::string Section::told(const char* key, const char* what) const {
    return std::string(file_.caller) + ": " + at(key) + ": " + what;
}

PhaseFunction Section::phase_function(const char* key, const PhaseSource& source) const {
    const std::string met = text(key);
    return placed(
        key, [&] { return read_phase_function(met, source.directory.string(), source.notes); });
}

std::vector<PhaseFunction> Section::phase_functions(const char* key, std::size_t count,
                                                    const PhaseSource& source) const {
    std::vector<PhaseFunction> functions;
    for (const std::string& text : texts(key, count, count))
        functions.push_back(placed(key, [&] {
            return read_phase_function(text, source.directory.string(), source.notes);
        }));
    return functions;
}

toml::table parse_toml(const std::string& text, const TomlFile& file) {
    const std::string name = file.name.empty() ? "the text" : file.name;
    require(text.find('\0') == text.npos, file.caller, name, "TOML text", "a binary file");
    refuse_depth(text, file);
    try {
        toml::table root = toml::parse(text);
        refuse_other_kind(root, file.caller, name);
        return root;
    } catch (const toml::parse_error& error) {
        std::ostringstream line;
        line << file.caller << ": " << (file.name.empty() ? "" : file.name + ", ") << "line "
             << error.source().begin.line << ": " << shown(std::string(error.description()));
        throw std::invalid_argument(line.str());
    }
}

LowerBoundary read_lower_boundary(const Section& file, const char* caller,
                                  const PhaseSource& source) {
    const Section section = file.section("below");
    constexpr const char* forms =
        "lambert_albedo alone, ground alone, or both phase_function and albedo";
    for (const char* alone : {"lambert_albedo", "ground"}) {
        if (!section.has(alone)) continue;
        for (const char* other : {"lambert_albedo", "ground", "phase_function", "albedo"})
            require(other == std::string(alone) || !section.has(other), caller, section.here(),
                    forms, alone + std::string(" and ") + other);
        if (alone == std::string("lambert_albedo"))
            return LowerBoundary::surface(section.number(alone));
        const std::string ground = section.text(alone);
        return section.placed(alone, [&] { return read_ground(ground, source.directory); });
    }
    const bool has_phase = section.has("phase_function"), has_albedo = section.has("albedo");
    require(has_phase && has_albedo, caller, section.here(), forms,
            has_phase    ? "phase_function alone"
            : has_albedo ? "albedo alone"
                         : "nothing");
    return LowerBoundary::layer(section.phase_function("phase_function", source),
                                section.number("albedo"));
}

}  // namespace stratus
