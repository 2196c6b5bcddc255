#include "recipe_sections.h"

#include <stratus/base/number_text.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace stratus {

namespace {

constexpr std::size_t most_values = 64;

bool is_length(PhaseParameter parameter) { return std::string(parameter_unit(parameter)) == "um"; }

/// A length with its unit, in um.
double read_length(const Section& section, const char* key, const char* caller,
                   const std::string& text) {
    double value = 0;
    const std::size_t end = read_number(text, value);
    const std::string unit = end > 0 ? text.substr(end) : "";
    require((unit == "um" || unit == "nm") && value > 0 && std::isfinite(value), caller,
            section.at(key), "lengths above 0 in um or nm, as in \"10um\"", '"' + text + '"');
    return unit == "um" ? value : value / 1000;
}

/// The numbers of a list, lengths in um.
std::vector<double> read_list(const Section& section, const char* key, const char* caller,
                              PhaseParameter parameter, std::size_t least, std::size_t most) {
    if (!is_length(parameter)) return section.numbers(key, least, most);
    std::vector<double> lengths;
    for (const std::string& text : section.texts(key, least, most))
        lengths.push_back(read_length(section, key, caller, text));
    return lengths;
}

/// `[min, max]`, or `{ values = [...] }`.
FamilyRange read_axis(const Section& family, const char* caller, PhaseParameter parameter) {
    const char* const key = parameter_name(parameter);
    std::vector<double> values;
    if (!family.is_table(key)) {
        values = read_list(family, key, caller, parameter, 2, 2);
        require(values[0] < values[1], caller, family.at(key), "a range, its end above its start",
                values[1]);
        return {parameter, {values[0], values[1]}, {}};
    }
    const Section section = family.section(key);
    values = read_list(section, "values", caller, parameter, 2, most_values);
    for (std::size_t n = 1; n < values.size(); ++n)
        require(values[n] > values[n - 1], caller, section.at("values"), "ascending", values[n]);
    return {parameter, {values.front(), values.back()}, values};
}

/// The range of mixtures given at the top of a recipe; all of them unless it is given.
Range read_mixture(const Section& file, const char* caller) {
    if (!file.has("mixture")) return {0, 1};
    const Section section = file.section("mixture");
    const Range range{section.number("min"), section.number("max")};
    require(range.min < range.max, caller, section.at("max"),
            "above min: one mixture alone is a sum in phase_function", range.max);
    require(range.max - range.min >= 1e-9, caller, section.at("max"), "1e-9 above min", range.max);
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

}  // namespace

std::string samples_key(PhaseParameter parameter) {
    return std::string(parameter_name(parameter)) + "_samples";
}

void read_family(const Section& file, const char* caller, const PhaseSource& source,
                 Recipe& recipe) {
    const Section family = file.section("family");
    const Section discretisation = file.section("discretisation");
    const bool mixes = file.has("second_phase_function");
    if (mixes)
        recipe.second_phase_function =
            file.phase_function("second_phase_function", source.directory, source.notes);
    require(mixes || !file.has("mixture"), caller, file.at("mixture"),
            "absent where there is no second_phase_function", "given");
    require(mixes || !family.has("mixture"), caller, family.at("mixture"),
            "absent where there is no second_phase_function", "given");
    require(!file.has("mixture") || !family.has("mixture"), caller, family.at("mixture"),
            "given once, here or at the top", "both");
    for (const PhaseParameter parameter : all_parameters) {
        const char* const key = parameter_name(parameter);
        const std::string samples = samples_key(parameter);
        const bool is_mixed = parameter == PhaseParameter::mixture && mixes;
        const bool is_given = family.has(key);
        if (is_given)
            recipe.family.push_back(read_axis(family, caller, parameter));
        else if (is_mixed)
            recipe.family.push_back({parameter, read_mixture(file, caller), {}});
        const bool is_range = !recipe.family.empty() &&
                              recipe.family.back().parameter == parameter &&
                              recipe.family.back().values.empty();
        if (discretisation.has(samples.c_str())) {
            const int count = discretisation.count(samples.c_str());
            require(is_range, caller, discretisation.at(samples.c_str()),
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
    require(
        recipe.family.empty() || is_mixture_alone(recipe) || !file.is("albedo", "phase_function"),
        caller, file.at("albedo"), "a table { min = ..., max = ... } where there is [family]",
        "\"phase_function\"");
}

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

}  // namespace stratus
