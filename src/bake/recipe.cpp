#include <stratus/bake/recipe.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>

#include <toml++/toml.h>

#include <stratus/runtime/argument.h>

namespace stratus {

namespace {

/// One table of the recipe; remembers which keys were asked for, so that the others can be refused.
class Section {
  public:
    Section(const toml::table& table, std::string name, std::vector<std::string> known)
        : table_(table), prefix_(name.empty() ? "" : name + ".") {
        for (const auto& [key, node] : table) {
            const std::string met(key.str());
            if (std::find(known.begin(), known.end(), met) != known.end()) continue;
            throw std::invalid_argument("recipe: unknown key '" + prefix_ + met + "'" + line(node) +
                                        "; did you mean '" + prefix_ + nearest_name(met, known) +
                                        "'?");
        }
    }

    bool has(const char* key) const { return table_.contains(key); }

    std::string text(const char* key) const {
        return value<std::string>(key, "a string in quotes");
    }

    double number(const char* key, double least, double most, const char* allowed) const {
        const double met = value<double>(key, "a number");
        require(met >= least && met <= most, "recipe", prefix_ + key, allowed, met);
        return met;
    }

    bool is(const char* key, const char* text) const {
        return table_.get(key)->value_exact<std::string>() == text;
    }

    /// `besides`: what is allowed but for numbers, as the start of the sentence that refuses.
    int count(const char* key, int least, int most, const std::string& besides = "") const {
        const std::string allowed = besides + "a whole number in [" + std::to_string(least) + ", " +
                                    std::to_string(most) + "]";
        const auto met = value<std::int64_t>(key, allowed.c_str());
        require(met >= least && met <= most, "recipe", prefix_ + key, allowed, met);
        return static_cast<int>(met);
    }

    const toml::table& table(const char* key, const char* form) const {
        const toml::table* met = table_.get_as<toml::table>(key);
        require(met != nullptr, "recipe", prefix_ + key, form, "something else");
        return *met;
    }

    std::vector<std::string> texts(const char* key, const char* form) const {
        const toml::array* met = table_.get_as<toml::array>(key);
        require(met != nullptr, "recipe", prefix_ + key, form, "something else");
        std::vector<std::string> values;
        for (const toml::node& node : *met) {
            const auto one = node.value_exact<std::string>();
            require(one.has_value(), "recipe", prefix_ + key, form, "something else in the list");
            values.push_back(*one);
        }
        return values;
    }

    static std::string line(const toml::node& node) {
        return " in line " + std::to_string(node.source().begin.line);
    }

  private:
    template <class T>
    T value(const char* key, const char* kind) const {
        const toml::node* node = table_.get(key);
        require(node != nullptr, "recipe", prefix_ + key, "present", "nothing");
        const auto met = node->value<T>();
        if (met) return *met;
        std::ostringstream text;
        text << toml::node_view<const toml::node>(node);
        require(false, "recipe", prefix_ + key + line(*node), kind, text.str());
        return {};
    }

    const toml::table& table_;
    std::string prefix_;
};

constexpr double infinity = std::numeric_limits<double>::infinity();

Range read_range(const Section& recipe, const char* key, double least, double most,
                 const char* allowed) {
    const Section section(recipe.table(key, "a table { min = ..., max = ... }"), key,
                          {"min", "max"});
    const Range range{section.number("min", least, most, allowed),
                      section.number("max", least, most, allowed)};
    require(range.min <= range.max, "recipe", std::string(key) + ".min", "at most max", range.min);
    const double width = range.max - range.min;
    require(range.min == range.max || width >= 1e-9, "recipe", std::string(key) + ".max",
            "equal to min or 1e-9 above it", range.max);
    return range;
}

Discretisation read_discretisation(const toml::table& table) {
    const Section section(
        table, "discretisation",
        {"nodes", "modes", "mu_samples", "azimuth_samples", "optical_depth_samples_per_octave",
         "deepest_optical_depth", "albedo_samples", "scheme"});
    Discretisation d;
    auto take = [&](int& into, const char* key, int least, int most) {
        if (section.has(key)) into = section.count(key, least, most);
    };
    take(d.nodes, "nodes", 1, 512);
    take(d.modes, "modes", 1, 1024);
    take(d.mu_samples, "mu_samples", 4, 512);
    take(d.azimuth_samples, "azimuth_samples", 1, 1024);
    take(d.optical_depth_samples_per_octave, "optical_depth_samples_per_octave", 1, 64);
    if (section.has("deepest_optical_depth"))
        d.deepest_optical_depth =
            section.number("deepest_optical_depth", 1e-3, 1e9, "in [1e-3, 1e9]");
    take(d.albedo_samples, "albedo_samples", 1, 512);
    if (section.has("scheme")) {
        const std::string scheme = section.text("scheme");
        require(scheme == "harmonic" || scheme == "classic", "recipe", "discretisation.scheme",
                "\"harmonic\" or \"classic\"", scheme);
        d.scheme = scheme == "classic" ? Scheme::classic : Scheme::harmonic;
    }
    return d;
}

std::string quoted(const std::string& text) {
    std::ostringstream out;
    out << toml::value<std::string>(text);
    return out.str();
}

}  // namespace

Recipe parse_recipe(const std::string& text, const std::string& directory,
                    std::vector<std::string>* notes) {
    toml::table parsed;
    try {
        parsed = toml::parse(text);
    } catch (const toml::parse_error& error) {
        std::ostringstream line;
        line << "recipe: line " << error.source().begin.line << ": " << error.description();
        throw std::invalid_argument(line.str());
    }
    const Section section(parsed, "",
                          {"title", "phase_function", "tolerance", "optical_depth", "albedo",
                           "sides", "orders", "discretisation"});
    Recipe recipe;
    recipe.text = text;
    if (section.has("title")) recipe.title = section.text("title");
    recipe.phase_text = section.text("phase_function");
    recipe.phase_function = parse_phase_function(recipe.phase_text, directory, notes);
    recipe.tolerance = section.number("tolerance", 1e-6, 0.1, "in [1e-6, 0.1]");
    recipe.optical_depth =
        read_range(section, "optical_depth", 1e-6, infinity, "in [1e-6, 1e9] or inf");
    for (const double depth : {recipe.optical_depth.min, recipe.optical_depth.max})
        require(depth <= 1e9 || std::isinf(depth), "recipe", "optical_depth",
                "in [1e-6, 1e9] or inf", depth);
    recipe.albedo = read_range(section, "albedo", 0, 1, "in [0, 1]");
    if (section.has("sides")) {
        recipe.reflection = recipe.transmission = false;
        const char* allowed = "a list out of \"reflection\", \"transmission\"";
        for (const std::string& side : section.texts("sides", allowed)) {
            require(side == "reflection" || side == "transmission", "recipe", "sides", allowed,
                    side);
            (side == "reflection" ? recipe.reflection : recipe.transmission) = true;
        }
        require(recipe.reflection || recipe.transmission, "recipe", "sides", allowed,
                "an empty list");
    }
    if (section.has("orders")) {
        const bool all = section.is("orders", "all");
        if (!all) recipe.orders = section.count("orders", 2, 100, "\"all\" or ");
    }
    if (recipe.optical_depth.min == infinity && recipe.transmission)
        throw std::invalid_argument(
            "recipe: sides must be [\"reflection\"] where optical_depth is inf alone: nothing is "
            "transmitted, got transmission");
    if (section.has("discretisation"))
        recipe.discretisation = read_discretisation(section.table("discretisation", "a table"));
    require(recipe.orders == 0 || recipe.discretisation.scheme == Scheme::harmonic, "recipe",
            "discretisation.scheme", "\"harmonic\" where orders are counted", "classic");
    const double deepest = recipe.discretisation.deepest_optical_depth;
    if (deepest > 0)
        require(std::isinf(recipe.optical_depth.max) && deepest >= recipe.optical_depth.min,
                "recipe", "discretisation.deepest_optical_depth",
                "at least optical_depth.min, in a recipe whose optical_depth.max is inf", deepest);
    return recipe;
}

Recipe read_recipe(const std::filesystem::path& path, std::vector<std::string>* notes) {
    std::ifstream file(path);
    if (!file || std::filesystem::is_directory(path))
        throw std::runtime_error(path.string() + ": cannot be read");
    std::ostringstream text;
    text << file.rdbuf();
    return parse_recipe(text.str(), path.parent_path().string(), notes);
}

std::string resolved_text(const Recipe& recipe) {
    std::ostringstream out;
    out.precision(17);
    auto range = [&](const char* key, Range r) {
        out << key << " = { min = " << r.min
            << (std::isinf(r.min) || r.min != std::floor(r.min) ? "" : ".0") << ", max = " << r.max
            << (std::isinf(r.max) || r.max != std::floor(r.max) ? "" : ".0") << " }\n";
    };
    const Discretisation& d = recipe.discretisation;
    out << "title = " << quoted(recipe.title) << "\n"
        << "phase_function = " << quoted(recipe.phase_function.text()) << "\n"
        << "tolerance = " << recipe.tolerance << "\n";
    range("optical_depth", recipe.optical_depth);
    range("albedo", recipe.albedo);
    out << "sides = [" << (recipe.reflection ? "\"reflection\"" : "")
        << (recipe.reflection && recipe.transmission ? ", " : "")
        << (recipe.transmission ? "\"transmission\"" : "") << "]\n"
        << "orders = " << (recipe.orders ? std::to_string(recipe.orders) : "\"all\"")
        << "\n[discretisation]\n"
        << "nodes = " << d.nodes << "\nmodes = " << d.modes << "\nmu_samples = " << d.mu_samples
        << "\nazimuth_samples = " << d.azimuth_samples;
    if (d.optical_depth_samples_per_octave)
        out << "\noptical_depth_samples_per_octave = " << d.optical_depth_samples_per_octave;
    if (d.deepest_optical_depth)
        out << "\ndeepest_optical_depth = " << d.deepest_optical_depth
            << (d.deepest_optical_depth == std::floor(d.deepest_optical_depth) ? ".0" : "");
    out << "\nalbedo_samples = " << d.albedo_samples
        << "\nscheme = " << (d.scheme == Scheme::classic ? "\"classic\"" : "\"harmonic\"") << "\n";
    return out.str();
}

}  // namespace stratus
