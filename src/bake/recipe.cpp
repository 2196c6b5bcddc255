#include <stratus/bake/recipe.h>

#include <stratus/bake/axes.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include "recipe_sections.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

namespace stratus {

namespace {

constexpr const char* caller = "recipe";

/// Tables know no thinner layers.
constexpr double min_stack_depth = 1e-6;

Range read_range(const Section& recipe, const char* key) {
    const Section section = recipe.section(key);
    const Range range{section.number("min"), section.number("max")};
    section.require(range.min <= range.max, "min", "at most max", range.min);
    const double width = range.max - range.min;
    section.require(range.min == range.max || width >= 1e-9, "max", "equal to min or 1e-9 above it",
                    range.max);
    return range;
}

/// A range, or one value alone: `mu_in = 0.4`.
Range read_directions(const Section& recipe, const char* key) {
    if (recipe.is_table(key)) return read_range(recipe, key);
    const double value = recipe.number(key);
    return {value, value};
}

/// A range, or that of the droplets alone: `albedo = "phase_function"`.
Range read_albedo(const Section& recipe, const PhaseFunction& phase_function) {
    if (!recipe.is("albedo", "phase_function")) return read_range(recipe, "albedo");
    const std::optional<double> albedo = phase_function.albedo();
    recipe.require(albedo.has_value(), "albedo",
                   "a table { min = ..., max = ... } unless the phase function is of "
                   "droplets (mie) or has a geometric_albedo",
                   "\"phase_function\"");
    return {*albedo, *albedo};
}

void take(const Section& section, const char* key, int& into) {
    if (section.has(key)) into = section.count(key);
}

void take_scale(const Section& section, const char* key, std::optional<AxisScale>& into,
                AxisScale one, AxisScale other) {
    if (!section.has(key)) return;
    const std::string first = axis_scale_name(one), second = axis_scale_name(other);
    into = section.choice(key, {first, second}) == first ? one : other;
}

/// How directions are solved and sampled.
void read_directional(const Section& section, Discretisation& d) {
    take(section, "nodes", d.nodes);
    take(section, "modes", d.modes);
    take(section, "mu_samples", d.mu_samples);
    take(section, "azimuth_samples", d.azimuth_samples);
    take_scale(section, "azimuth_scale", d.azimuth_scale, AxisScale::linear,
               AxisScale::square_root);
}

Discretisation read_discretisation(const Section& section) {
    Discretisation d;
    read_directional(section, d);
    take_scale(section, "albedo_scale", d.albedo_scale, AxisScale::square_root_of_complement,
               AxisScale::fourth_root_of_complement);
    take(section, "optical_depth_samples_per_octave", d.optical_depth_samples_per_octave);
    if (section.has("deepest_optical_depth"))
        d.deepest_optical_depth = section.number("deepest_optical_depth");
    take(section, "albedo_samples", d.albedo_samples);
    d.scheme = section.choice("scheme", {"harmonic", "classic"}) == "classic" ? Scheme::classic
                                                                              : Scheme::harmonic;
    return d;
}

void read_sides(const Section& section, Recipe& recipe) {
    if (!section.has("sides")) return;
    recipe.reflection = recipe.transmission = false;
    for (const std::string& side : section.texts("sides", 1, 2)) {
        section.require(side == "reflection" || side == "transmission", "sides",
                        "a list out of \"reflection\", \"transmission\"", side);
        (side == "reflection" ? recipe.reflection : recipe.transmission) = true;
    }
}

std::string quoted(const std::string& text) {
    std::ostringstream out;
    out << toml::value<std::string>(text);
    return out.str();
}

// ---- [family]

constexpr std::size_t most_values = 64;

bool is_length(PhaseParameter parameter) { return std::string(parameter_unit(parameter)) == "um"; }

/// A length with its unit, in um.
double read_length(const Section& section, const char* key, const std::string& text) {
    double value = 0;
    const std::size_t end = read_number(text, value);
    const std::string unit = end > 0 ? text.substr(end) : "";
    section.require((unit == "um" || unit == "nm") && value > 0 && std::isfinite(value), key,
                    "lengths above 0 in um or nm, as in \"10um\"", '"' + text + '"');
    return unit == "um" ? value : value / 1000;
}

/// The numbers of a list, from two to `most`; lengths in um.
std::vector<double> read_list(const Section& section, const char* key, PhaseParameter parameter,
                              std::size_t most) {
    if (!is_length(parameter)) return section.numbers(key, 2, most);
    std::vector<double> lengths;
    for (const std::string& text : section.texts(key, 2, most))
        lengths.push_back(read_length(section, key, text));
    return lengths;
}

/// `[min, max]`, or `{ values = [...] }`.
FamilyRange read_axis(const Section& family, PhaseParameter parameter) {
    const char* const key = parameter_name(parameter);
    std::vector<double> values;
    if (!family.is_table(key)) {
        values = read_list(family, key, parameter, 2);
        family.require(values[0] < values[1], key, "a range, its end above its start", values[1]);
        return {parameter, {values[0], values[1]}, {}};
    }
    const Section section = family.section(key);
    values = read_list(section, "values", parameter, most_values);
    for (std::size_t n = 1; n < values.size(); ++n)
        section.require(values[n] > values[n - 1], "values", "ascending", values[n]);
    return {parameter, {values.front(), values.back()}, values};
}

/// The range of mixtures given at the top of a recipe; all of them unless it is given.
Range read_mixture(const Section& file) {
    if (!file.has("mixture")) return {0, 1};
    const Section section = file.section("mixture");
    const Range range{section.number("min"), section.number("max")};
    section.require(range.min < range.max, "max",
                    "above min: one mixture alone is a sum in phase_function", range.max);
    section.require(range.max - range.min >= 1e-9, "max", "1e-9 above min", range.max);
    return range;
}

std::string value_text(PhaseParameter parameter, double value) {
    const std::string number = shortest_text(value);
    if (is_length(parameter)) return '"' + number + "um\"";
    return number.find_first_not_of("-0123456789") == std::string::npos ? number + ".0" : number;
}

std::string list_text(PhaseParameter parameter, const std::vector<double>& values) {
    std::vector<std::string> texts;
    for (const double value : values) texts.push_back(value_text(parameter, value));
    return std::string("[").append(joined(texts)).append("]");
}

/// Reads [family], or second_phase_function with or without `mixture`, into a recipe whose phase
/// function and discretisation have been read. Axes lie in the order of PhaseParameter.
void read_family(const Section& file, const PhaseSource& source, Recipe& recipe) {
    const Section family = file.section("family");
    const Section discretisation = file.section("discretisation");
    const bool mixes = file.has("second_phase_function");
    if (mixes) recipe.second_phase_function = file.phase_function("second_phase_function", source);
    for (const Section* const section : {&file, &family})
        section->require(mixes || !section->has("mixture"), "mixture",
                         "absent where there is no second_phase_function", "given");
    family.require(!file.has("mixture") || !family.has("mixture"), "mixture",
                   "given once, here or at the top", "both");
    for (const PhaseParameter parameter : all_parameters) {
        const char* const key = parameter_name(parameter);
        const std::string samples = samples_key(parameter);
        const bool is_mixed = parameter == PhaseParameter::mixture && mixes;
        const bool is_given = family.has(key);
        if (is_given)
            recipe.family.push_back(read_axis(family, parameter));
        else if (is_mixed)
            recipe.family.push_back({parameter, read_mixture(file), {}});
        const bool is_range = !recipe.family.empty() &&
                              recipe.family.back().parameter == parameter &&
                              recipe.family.back().values.empty();
        if (discretisation.has(samples.c_str())) {
            const int count = discretisation.count(samples.c_str());
            discretisation.require(
                is_range, samples.c_str(),
                parameter == PhaseParameter::mixture
                    ? "absent where there is no second_phase_function"
                    : std::string("absent where [family] has no range of ") + key,
                count);
            if (recipe.family.size() <= max_family_axes)
                recipe.discretisation.family_samples[recipe.family.size() - 1] = count;
        }
    }
    require(recipe.family.size() <= max_family_axes, caller, family.here(),
            "of one or two parameters", recipe.family.size());
    for (const FamilyRange& axis : recipe.family) {
        if (axis.parameter == PhaseParameter::mixture) continue;
        for (const double value : {axis.range.min, axis.range.max})
            family.placed(parameter_name(axis.parameter), [&] {
                return with_parameter(recipe.phase_function, axis.parameter, value);
            });
    }
    file.require(
        recipe.family.empty() || is_mixture_alone(recipe) || !file.is("albedo", "phase_function"),
        "albedo", "a table { min = ..., max = ... } where there is [family]", "\"phase_function\"");
}

/// The lines that `read_family` reads, of a resolved recipe.
std::string family_text(const Recipe& recipe) {
    if (recipe.family.empty()) return "";
    std::ostringstream out;
    out << "[family]\n";
    for (const FamilyRange& axis : recipe.family) {
        out << parameter_name(axis.parameter) << " = ";
        if (axis.values.empty())
            out << list_text(axis.parameter, {axis.range.min, axis.range.max}) << "\n";
        else
            out << "{ values = " << list_text(axis.parameter, axis.values) << " }\n";
    }
    return out.str();
}

}  // namespace

std::string samples_key(PhaseParameter parameter) {
    return std::string(parameter_name(parameter)) + "_samples";
}

Recipe recipe_of_stack(StackLayers layers, const LowerBoundary& lower_boundary) {
    check_layers(layers, lower_boundary.is_present(), caller);
    const StackLayer mean = mean_layer(layers);
    require(mean.optical_depth >= min_stack_depth, caller, "optical depth of all layers",
            "at least " + short_number(min_stack_depth), mean.optical_depth);
    Recipe recipe;
    recipe.layers = std::move(layers);
    recipe.lower_boundary = lower_boundary;
    recipe.phase_function = mean.phase_function;
    recipe.phase_text = mean.phase_function.text();
    recipe.optical_depth = {mean.optical_depth, mean.optical_depth};
    recipe.albedo = {mean.albedo, mean.albedo};
    recipe.transmission = mean.optical_depth < infinity && !lower_boundary.is_present();
    recipe.discretisation.albedo_samples = 1;
    return recipe;
}

namespace {

/// One layer: phase function, ranges of depth and albedo, what it lies on.
Recipe read_layer(const Section& section, const PhaseSource& source) {
    Recipe recipe;
    recipe.phase_text = section.text("phase_function");
    recipe.phase_function = section.phase_function("phase_function", source);
    recipe.optical_depth = read_range(section, "optical_depth");
    recipe.albedo = read_albedo(section, recipe.phase_function);
    if (section.has("below")) recipe.lower_boundary = read_lower_boundary(section, caller, source);
    recipe.transmission =
        recipe.optical_depth.min < infinity && !recipe.lower_boundary.is_present();
    if (!section.is("orders", "all") && section.has("orders"))
        recipe.orders = section.count("orders");
    return recipe;
}

/// Reads the keys that only a single layer has.
void read_layer_choices(const Section& section, const PhaseSource& source, Recipe& recipe) {
    const Section discretisation = section.section("discretisation");
    recipe.discretisation = read_discretisation(discretisation);
    read_family(section, source, recipe);
    section.require(recipe.orders == 0 || !recipe.lower_boundary.is_present(), "orders",
                    "\"all\" where there is [below]", recipe.orders);
    discretisation.require(recipe.orders == 0 || recipe.discretisation.scheme == Scheme::harmonic,
                           "scheme", "\"harmonic\" where orders are counted", "classic");
    discretisation.require(
        recipe.albedo.min == recipe.albedo.max || recipe.discretisation.albedo_samples != 1,
        "albedo_samples", "2 or more over a range of albedos", 1);
    const double deepest = recipe.discretisation.deepest_optical_depth;
    if (deepest > 0)
        discretisation.require(
            std::isinf(recipe.optical_depth.max) && deepest >= recipe.optical_depth.min,
            "deepest_optical_depth",
            "at least optical_depth.min, in a recipe whose optical_depth.max is inf", deepest);
}

}  // namespace

Recipe make_recipe(const toml::table& parsed, const TomlFile& file, const PhaseSource& source) {
    if (const toml::node* const sweep = parsed.get("sweep"))
        require(false, caller, file.place(*sweep) + "sweep",
                "absent but for `stratus bake`, which bakes a table for each of its rows",
                "a section");
    const bool is_stack = parsed.contains("layers");
    const Section section(parsed, file, is_stack ? stack_keys() : recipe_keys());
    Recipe recipe;
    if (is_stack) {
        const Stack stack = read_layers(section, file, source);
        recipe = section.placed(
            "layers", [&] { return recipe_of_stack(stack.layers, stack.lower_boundary); });
    } else {
        recipe = read_layer(section, source);
    }
    recipe.title = section.text("title");
    recipe.tolerance = section.number("tolerance");
    for (const auto& [key, range] :
         {std::pair("mu_in", &recipe.mu_in), std::pair("mu_out", &recipe.mu_out),
          std::pair("azimuth_deg", &recipe.azimuth)})
        if (section.has(key)) {
            *range = read_directions(section, key);
            section.placed(key, [&] { check_directions(recipe); });
        }
    read_sides(section, recipe);
    const LowerBoundary& below = recipe.lower_boundary;
    section.require(!below.law || !below.law->text().starts_with("table:"), "below",
                    "ocean or rpv in recipes, for tables name no other file", "a table");
    section.require(!below.is_present() || !recipe.transmission, "sides",
                    "[\"reflection\"] where there is [below], which lets nothing pass",
                    "transmission");
    section.require(recipe.optical_depth.min < infinity || !recipe.transmission, "sides",
                    "[\"reflection\"] where optical_depth is inf alone: nothing is transmitted",
                    "transmission");
    if (is_stack)
        read_directional(section.section("discretisation"), recipe.discretisation);
    else
        read_layer_choices(section, source, recipe);
    return recipe;
}

Recipe parse_recipe(const std::string& text, const std::string& directory,
                    std::vector<std::string>* notes, const std::string& name) {
    const TomlFile file{caller, name};
    Recipe recipe = make_recipe(parse_toml(text, file), file, {directory, notes});
    recipe.text = text;
    return recipe;
}

Recipe read_recipe(const std::filesystem::path& path, std::vector<std::string>* notes) {
    return parse_recipe(read_text(path), path.parent_path().string(), notes, path.string());
}

void check_directions(const Recipe& recipe) {
    const auto check = [](const std::string& key, Range range, double max, double least) {
        require(range.max >= least && range.max <= max, caller, key + ".max",
                "in [" + short_number(least) + ", " + short_number(max, 3) + "]", range.max);
        require(range.min >= 0 && range.min <= range.max, caller, key + ".min",
                "in [0, " + key + ".max]", range.min);
        const double narrowest = 1e-6 * max;
        require(range.min == range.max || range.max - range.min >= narrowest, caller, key + ".max",
                "equal to min or " + short_number(narrowest) + " above it", range.max);
    };
    check("mu_in", recipe.mu_in, 1, min_mu);
    check("mu_out", recipe.mu_out, 1, min_mu);
    check("azimuth_deg", recipe.azimuth, 180, min_azimuth);
}

Recipe at_member(const Recipe& recipe, const FamilyPoint& point) {
    if (recipe.family.empty()) return recipe;
    Recipe alone = recipe;
    alone.phase_function = phase_function_at(recipe.phase_function, recipe.second_phase_function,
                                             recipe.family, point);
    alone.phase_text = alone.phase_function.text();
    alone.leaves_path_law = leaves_path_law(recipe);
    alone.family.clear();
    alone.discretisation.family_samples = {};
    return alone;
}

const Range* mixture_range(const Recipe& recipe) noexcept {
    for (const FamilyRange& axis : recipe.family)
        if (axis.parameter == PhaseParameter::mixture) return &axis.range;
    return nullptr;
}

Range* mixture_range(Recipe& recipe) noexcept {
    return const_cast<Range*>(mixture_range(std::as_const(recipe)));
}

bool is_mixture_alone(const Recipe& recipe) noexcept {
    return recipe.family.size() == 1 && mixture_range(recipe) != nullptr &&
           recipe.family[0].values.empty();
}

void set_mixture(Recipe& recipe, const PhaseFunction& second, Range shares) {
    recipe.second_phase_function = second;
    recipe.family = {{PhaseParameter::mixture, shares, {}}};
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
    out << "title = " << quoted(recipe.title) << "\n";
    if (recipe.layers.empty())
        out << "phase_function = " << quoted(recipe.phase_function.text()) << "\n";
    out << "tolerance = " << recipe.tolerance << "\n";
    if (const Range* const mixture = mixture_range(recipe)) {
        out << "second_phase_function = " << quoted(recipe.second_phase_function.text()) << "\n";
        if (is_mixture_alone(recipe)) range("mixture", *mixture);
    }
    if (recipe.layers.empty()) {
        range("optical_depth", recipe.optical_depth);
        range("albedo", recipe.albedo);
    }
    if (is_narrow(recipe.mu_in, all_cosines)) range("mu_in", recipe.mu_in);
    if (is_narrow(recipe.mu_out, all_cosines)) range("mu_out", recipe.mu_out);
    if (is_narrow(recipe.azimuth, all_azimuths)) range("azimuth_deg", recipe.azimuth);
    out << "sides = [" << (recipe.reflection ? "\"reflection\"" : "")
        << (recipe.reflection && recipe.transmission ? ", " : "")
        << (recipe.transmission ? "\"transmission\"" : "") << "]\n";
    if (recipe.layers.empty())
        out << "orders = " << (recipe.orders ? std::to_string(recipe.orders) : "\"all\"") << "\n";
    for (const StackLayer& layer : recipe.layers)
        out << "[[layers]]\nphase_function = " << quoted(layer.phase_function.text())
            << "\nalbedo = " << layer.albedo << "\noptical_depth = " << layer.optical_depth << "\n";
    out << "[discretisation]\n";
    auto choice = [&](const char* key, double value, const char* of_whole = "") {
        if (value == 0) return;
        out << key << " = " << value << (value == std::floor(value) ? of_whole : "") << "\n";
    };
    choice("nodes", d.nodes);
    choice("modes", d.modes);
    choice("mu_samples", d.mu_samples);
    choice("azimuth_samples", d.azimuth_samples);
    if (d.azimuth_scale)
        out << "azimuth_scale = " << quoted(axis_scale_name(*d.azimuth_scale)) << "\n";
    if (recipe.layers.empty()) {
        choice("optical_depth_samples_per_octave", d.optical_depth_samples_per_octave);
        choice("deepest_optical_depth", d.deepest_optical_depth, ".0");
        choice("albedo_samples", d.albedo_samples);
        if (d.albedo_scale)
            out << "albedo_scale = " << quoted(axis_scale_name(*d.albedo_scale)) << "\n";
        for (std::size_t k = 0; k < recipe.family.size(); ++k)
            if (recipe.family[k].values.empty())
                choice(samples_key(recipe.family[k].parameter).c_str(), d.family_samples[k]);
        out << "scheme = " << (d.scheme == Scheme::classic ? "\"classic\"" : "\"harmonic\"")
            << "\n";
    }
    if (!is_mixture_alone(recipe)) out << family_text(recipe);
    if (recipe.lower_boundary.is_surface())
        out << "[below]\nlambert_albedo = " << recipe.lower_boundary.albedo << "\n";
    if (recipe.lower_boundary.law)
        out << "[below]\nground = " << quoted(recipe.lower_boundary.law->text()) << "\n";
    if (recipe.lower_boundary.is_layer())
        out << "[below]\nphase_function = " << quoted(recipe.lower_boundary.phase_function.text())
            << "\nalbedo = " << recipe.lower_boundary.albedo << "\n";
    return out.str();
}

}  // namespace stratus
