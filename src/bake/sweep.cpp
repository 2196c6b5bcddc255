#include <stratus/bake/sweep.h>

#include <stratus/bake/accuracy.h>
#include <stratus/bake/toml_section.h>
#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/io/csv.h>

#include "recipe_sections.h"

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
constexpr const char* section_name = "sweep";
constexpr Key name_key{"name", "string", "-", "-", "\"1\", ...", "of the table"};

// ---- Columns

/// A column's key, part by part.
std::vector<std::string> split_column(const std::string& column) {
    std::vector<std::string> parts;
    std::istringstream text(column);
    for (std::string part; std::getline(text, part, '.');) parts.push_back(part);
    return parts;
}

/// A layer's number in "layers.2.albedo"; 0: none.
std::size_t layer_number(const std::string& part) {
    std::size_t number = 0;
    const auto end = std::from_chars(part.data(), part.data() + part.size(), number).ptr;
    return end == part.data() + part.size() ? number : 0;
}

/// The key that a column gives; null where there is none.
const Key* find_key(const std::string& column, Keys keys) {
    std::string name;
    for (const std::string& part : split_column(column))
        if (name != "layers" || layer_number(part) == 0) name += (name.empty() ? "" : ".") + part;
    const auto found = std::ranges::find(keys, name, &Key::name);
    return found == keys.end() ? nullptr : &*found;
}

const Key& require_key(const std::string& column, Keys keys, const std::string& where) {
    if (column == name_key.name) return name_key;
    if (const Key* const key = find_key(column, keys)) return *key;
    std::vector<std::string> known{name_key.name};
    for (const Key& key : keys) known.push_back(key.name);
    throw std::invalid_argument(std::string(caller) + ": " + where + ": no key of the recipe is '" +
                                column + "'; did you mean '" + nearest_name(column, known) + "'?");
}

// ---- Cells

/// A row before it is a recipe.
struct Row {
    std::string place;  // "FILE, line 7: ", in refusals
    toml::table cells;  // by column
};

/// Adds a cell of a CSV as the recipe would have it; anything else becomes a text, which the key's own
/// rule refuses.
void add_cell(Row& row, const std::string& column, const Key& key, const std::string& cell) {
    double number;
    if (key.form == std::string_view("string") && !cell.starts_with('"') &&
        !cell.starts_with('\'')) {
        row.cells.insert(column, cell);
    } else if (read_number(cell, number) == cell.size() &&
               cell.find_first_not_of("+-0123456789") != cell.npos) {
        row.cells.insert(column, number);
    } else {
        try {
            row.cells.insert(column, *parse_toml("value = " + cell, {caller, ""}).get("value"));
        } catch (const std::invalid_argument&) {
            row.cells.insert(column, cell);
        }
    }
}

/// Puts a cell in its place; sections that the recipe lacks are begun.
void put_cell(toml::table& recipe, const std::string& column, const toml::node& cell,
              const std::string& place) {
    toml::table* section = &recipe;
    const std::vector<std::string> parts = split_column(column);
    for (std::size_t p = 0; p + 1 < parts.size(); ++p) {
        if (!section->contains(parts[p])) section->insert(parts[p], toml::table());
        toml::node* below = section->get(parts[p]);
        if (toml::array* const layers = below->as_array()) {
            const std::size_t number = p + 2 < parts.size() ? layer_number(parts[++p]) : 0;
            require(number >= 1 && number <= layers->size(), caller, place + column,
                    "numbered by a layer, as in layers.1.albedo, up to " +
                        std::to_string(layers->size()),
                    toml_text(cell));
            below = layers->get(number - 1);
        }
        section = below->as_table();
        require(section != nullptr, caller, place + column, "a key within a table of the recipe",
                toml_text(cell));
    }
    section->insert_or_assign(parts.back(), cell);
}

// ---- Rows

std::vector<Row> rows_of_csv(const std::filesystem::path& csv, Keys keys) {
    const CsvTexts texts = read_csv_texts(csv.string());
    require(!texts.rows.empty(), caller, texts.name, "a header and at least one row", "no rows");
    std::vector<const Key*> key_of_column;
    for (const std::string& column : texts.columns)
        key_of_column.push_back(&require_key(column, keys, texts.name));
    std::vector<Row> rows;
    for (std::size_t r = 0; r < texts.rows.size(); ++r) {
        Row row{texts.name + ", line " + std::to_string(texts.lines[r]) + ": ", {}};
        for (std::size_t c = 0; c < texts.columns.size(); ++c)
            if (const std::string& cell = texts.rows[r][c];
                !cell.empty() || key_of_column[c] == &name_key)
                add_cell(row, texts.columns[c], *key_of_column[c], cell);
        rows.push_back(std::move(row));
    }
    return rows;
}

/// Lists of values by the keys that they are of, from a section with tables within.
void add_columns(const toml::table& section, const std::string& prefix, Keys keys,
                 const TomlFile& file, std::vector<Row>& rows) {
    for (const auto& [key, node] : section) {
        const std::string column = prefix + std::string(key.str());
        const std::string subject = file.place(node) + "sweep." + column;
        if (const toml::table* const within = node.as_table()) {
            add_columns(*within, column + ".", keys, file, rows);
            continue;
        }
        require_key(column, keys, file.name + ": [sweep]");
        const toml::array* const list = node.as_array();
        require(list != nullptr && !list->empty(), caller, subject,
                "a list of values, one for each table", list ? "an empty one" : toml_text(node));
        if (rows.empty()) rows.resize(list->size());
        require(list->size() == rows.size(), caller, subject,
                "as long as the other lists of [sweep], " + std::to_string(rows.size()),
                list->size());
        for (std::size_t r = 0; r < rows.size(); ++r) {
            rows[r].place = file.place(section) + "table " + std::to_string(r + 1) + ": ";
            rows[r].cells.insert(column, (*list)[r]);
        }
    }
}

std::string checked_name(const toml::node& name, const std::string& place) {
    constexpr std::size_t longest = 200;
    const std::string text = name.value_or(std::string());
    require(
        !text.empty() && text.size() <= longest && text[0] != '.' && text.find('/') == text.npos,
        caller, place + name_key.name,
        "a file's name of up to 200 bytes, without '/' and not beginning with '.'",
        name.is_string() ? "'" + text + "'" : toml_text(name));
    return text;
}

void add_new(const std::vector<std::string>& some, std::vector<std::string>* notes) {
    for (const std::string& note : some)
        if (notes != nullptr && std::ranges::find(*notes, note) == notes->end())
            notes->push_back(note);
}

/// The recipe with the cells of each row.
std::vector<SweepRow> make_rows(const toml::table& recipe, const std::vector<Row>& rows,
                                const std::string& directory, std::vector<std::string>* notes) {
    std::vector<SweepRow> sweep;
    std::set<std::string> names;
    for (const Row& row : rows) {
        toml::table of_row = recipe;  // a copy has no lines: refusals name those of the sweep
        std::string name = std::to_string(sweep.size() + 1);
        for (const auto& [column, cell] : row.cells) {
            if (column.str() == name_key.name)
                name = checked_name(cell, row.place);
            else
                put_cell(of_row, std::string(column.str()), cell, row.place);
        }
        require(names.insert(name).second, caller, row.place + name_key.name,
                "a new one in every row", "'" + name + "' again");
        std::vector<std::string> of_recipe;
        const std::string source = row.place.substr(0, row.place.size() - 2);  // without ": "
        SweepRow made{name, make_recipe(of_row, {"recipe", source}, {directory, &of_recipe})};
        made.recipe.text = toml_text(of_row) + "\n";
        sweep.push_back(std::move(made));
        add_new(of_recipe, notes);
    }
    return sweep;
}

Keys known_keys(const toml::table& recipe) {
    return recipe.contains("layers") ? stack_keys() : recipe_keys();
}

}  // namespace

bool has_sweep(const std::filesystem::path& recipe) {
    return parse_toml(read_text(recipe), {"recipe", recipe.string()}).contains(section_name);
}

std::vector<SweepRow> read_sweep(const std::filesystem::path& recipe,
                                 std::vector<std::string>* notes) {
    const TomlFile file{"recipe", recipe.string()};
    toml::table parsed = parse_toml(read_text(recipe), file);
    const toml::table* const section = parsed.get_as<toml::table>(section_name);
    require(section != nullptr, caller, file.name + ": sweep",
            "a table with a list of values a key",
            parsed.contains(section_name) ? "another kind of value" : "nothing");
    std::vector<Row> rows;
    add_columns(*section, "", known_keys(parsed), file, rows);
    require(!rows.empty(), caller, file.place(*section) + "sweep", "a list of values a key",
            "an empty table");
    parsed.erase(section_name);
    return make_rows(parsed, rows, recipe.parent_path().string(), notes);
}

std::vector<SweepRow> read_sweep(const std::filesystem::path& recipe,
                                 const std::filesystem::path& csv,
                                 std::vector<std::string>* notes) {
    const TomlFile file{"recipe", recipe.string()};
    const toml::table parsed = parse_toml(read_text(recipe), file);
    require(!parsed.contains(section_name), caller, "--sweep",
            "left out for a recipe that has a [sweep] of its own", csv.string());
    return make_rows(parsed, rows_of_csv(csv, known_keys(parsed)), recipe.parent_path().string(),
                     notes);
}

bool is_baked_from(const Table& table, const Recipe& recipe) {
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
           table.measured_error <= largest_over_tolerance * tolerance &&
           within("measured_error_forward_99_percent", tolerance) &&
           (table.path_law || within("measured_error_grazing_99_percent", tolerance));
}

}  // namespace stratus
