#include <stratus/bake/sweep.h>

#include <stratus/bake/keys.h>
#include <stratus/io/csv.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/number_text.h>

#include "recipe_of.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string_view>

namespace stratus {

namespace {

constexpr const char* caller = "sweep";
constexpr const char* name_column = "name";

// ---- Columns

/// A column's key, part by part.
std::vector<std::string> parts_of(const std::string& column) {
    std::vector<std::string> parts;
    std::istringstream text(column);
    for (std::string part; std::getline(text, part, '.');) parts.push_back(part);
    return parts;
}

/// A layer's number in "layers.2.albedo"; 0: none.
std::size_t number_of(const std::string& part) {
    std::size_t number = 0;
    const auto end = std::from_chars(part.data(), part.data() + part.size(), number).ptr;
    return end == part.data() + part.size() ? number : 0;
}

/// The key that a column gives; null where there is none.
const Key* find_key(const std::string& column, Keys keys) {
    std::string name;
    for (const std::string& part : parts_of(column))
        if (name != "layers" || number_of(part) == 0) name += (name.empty() ? "" : ".") + part;
    const auto found = std::ranges::find(keys, name, full_name);
    return found == keys.end() ? nullptr : &*found;
}

const Key& key_of(const std::string& column, Keys keys, const std::string& csv) {
    if (const Key* const key = find_key(column, keys)) return *key;
    std::vector<std::string> known{name_column};
    for (const Key& key : keys) known.push_back(full_name(key));
    throw std::invalid_argument(std::string(caller) + ": " + csv + ": no key of the recipe is '" +
                                column + "'; did you mean '" + nearest_name(column, known) + "'?");
}

// ---- Cells

void set_text(toml::table& section, const std::string& key, const std::string& text) {
    section.insert_or_assign(key, text);
}

/// What the cell would be in the recipe; a text where it is nothing else, which is refused by the
/// key's own rule.
void set_value(toml::table& section, const Key& key, const std::string& name,
               const std::string& cell) {
    if (key.form == std::string_view("string") && !cell.starts_with('"') && !cell.starts_with('\''))
        return set_text(section, name, cell);
    double number;
    if (read_number(cell, number) == cell.size() &&
        cell.find_first_not_of("+-0123456789") != cell.npos) {
        section.insert_or_assign(name, number);
        return;
    }
    try {
        const toml::table parsed = toml::parse("value = " + cell);
        section.insert_or_assign(name, *parsed.get("value"));
    } catch (const toml::parse_error&) {
        set_text(section, name, cell);
    }
}

/// Puts a cell in its place; sections that the recipe lacks are begun.
void put_cell(toml::table& recipe, const std::string& column, const Key& key,
              const std::string& cell, const std::string& place) {
    toml::table* section = &recipe;
    const std::vector<std::string> parts = parts_of(column);
    for (std::size_t p = 0; p + 1 < parts.size(); ++p) {
        if (!section->contains(parts[p])) section->insert(parts[p], toml::table());
        toml::node* below = section->get(parts[p]);
        if (toml::array* const layers = below->as_array()) {
            const std::size_t number = p + 2 < parts.size() ? number_of(parts[++p]) : 0;
            require(number >= 1 && number <= layers->size(), caller, place + column,
                    "numbered by a layer, as in layers.1.albedo, up to " +
                        std::to_string(layers->size()),
                    cell);
            below = layers->get(number - 1);
        }
        section = below->as_table();
        require(section != nullptr, caller, place + column, "a key within a table of the recipe",
                cell);
    }
    set_value(*section, key, parts.back(), cell);
}

// ---- Rows

void check_name(const std::string& name, const std::string& place) {
    constexpr std::size_t longest = 200;
    require(
        !name.empty() && name.size() <= longest && name[0] != '.' && name.find('/') == name.npos,
        caller, place + name_column,
        "a file's name of up to 200 bytes, without '/' and not beginning with '.'",
        "'" + name + "'");
}

std::string text_of(const toml::table& table) {
    std::ostringstream text;
    text << table << '\n';
    return text.str();
}

void add_new(const std::vector<std::string>& some, std::vector<std::string>* notes) {
    for (const std::string& note : some)
        if (notes != nullptr && std::ranges::find(*notes, note) == notes->end())
            notes->push_back(note);
}

}  // namespace

std::vector<SweepRow> read_sweep(const std::filesystem::path& recipe,
                                 const std::filesystem::path& csv,
                                 std::vector<std::string>* notes) {
    const toml::table parsed = parse_toml(read_text(recipe), {"recipe", recipe.string()});
    const Keys keys = parsed.contains("layers") ? stack_keys() : recipe_keys();
    const CsvTexts cells = read_csv_texts(csv.string());
    require(!cells.rows.empty(), caller, cells.name, "a header and at least one row", "no rows");
    std::vector<const Key*> key_of_column;
    for (const std::string& column : cells.columns)
        key_of_column.push_back(column == name_column ? nullptr
                                                      : &key_of(column, keys, cells.name));

    std::vector<SweepRow> rows;
    std::set<std::string> names;
    for (std::size_t r = 0; r < cells.rows.size(); ++r) {
        const std::string line = cells.name + ", line " + std::to_string(cells.lines[r]);
        const std::string place = line + ": ";
        toml::table of_row = parsed;  // a copy has no lines: refusals name those of the CSV
        std::string name = std::to_string(r + 1);
        for (std::size_t c = 0; c < cells.columns.size(); ++c) {
            const std::string& cell = cells.rows[r][c];
            if (key_of_column[c] == nullptr)
                check_name(name = cell, place);
            else if (!cell.empty())
                put_cell(of_row, cells.columns[c], *key_of_column[c], cell, place);
        }
        require(names.insert(name).second, caller, place + name_column, "a new one in every row",
                "'" + name + "' again");
        std::vector<std::string> of_recipe;
        SweepRow row{
            name, recipe_of(of_row, {"recipe", line}, {recipe.parent_path().string(), &of_recipe})};
        row.recipe.text = text_of(of_row);
        rows.push_back(std::move(row));
        add_new(of_recipe, notes);
    }
    return rows;
}

bool is_baked_of(const Table& table, const Recipe& recipe) {
    const auto states = [&](const char* name, const std::string& text) {
        const auto found = table.attributes.find(name);
        return found != table.attributes.end() && found->second == text;
    };
    if (!states("recipe", recipe.text) || !states("program_version", STRATUS_VERSION)) return false;
    const auto resolved = table.attributes.find("resolved_recipe");
    if (resolved == table.attributes.end()) return false;
    Recipe baked = parse_recipe(resolved->second);
    baked.discretisation = recipe.discretisation;  // the recipe's text says what it fixes
    return resolved_text(baked) == resolved_text(recipe);
}

bool states_tolerance_met(const Table& table) {
    const auto within = [&](const char* name, double most) {
        const auto found = table.attributes.find(name);
        double error = 0;
        return found == table.attributes.end() ||
               (read_number(found->second, error) > 0 && error <= most);
    };
    const double tolerance = table.tolerance;
    return within("measured_error_99.9_percent", tolerance) &&
           table.measured_error <= 5 * tolerance &&
           within("measured_error_forward_99_percent", tolerance) &&
           (table.path_law || within("measured_error_grazing_99_percent", tolerance));
}

}  // namespace stratus
