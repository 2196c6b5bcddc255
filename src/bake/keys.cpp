#include <stratus/bake/toml_section.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <set>
#include <vector>

namespace stratus {

std::string key_columns(Keys keys) {
    using Line = std::array<std::string, 6>;
    std::vector<Line> lines{{"key", "form", "unit", "range", "default", "meaning"}};
    for (const Key& key : keys)
        lines.push_back({key.name, key.form, key.unit, key.range, key.default_value, key.meaning});
    std::array<std::size_t, 6> widths{};
    for (const Line& line : lines)
        for (std::size_t c = 0; c < line.size(); ++c)
            widths[c] = std::max(widths[c], line[c].size());
    std::string text;
    for (const Line& line : lines) {
        for (std::size_t c = 0; c + 1 < line.size(); ++c)
            text += line[c] + std::string(widths[c] + 2 - line[c].size(), ' ');
        text += line.back() + "\n";
    }
    return text;
}

Keys recipe_keys() {
    constexpr const char* depth = "[1e-6, 1e9] or inf";
    static constexpr Key keys[] = {
        {"title", "string", "-", "-", "\"\"", "kept with the table"},
        {"phase_function", "string", "-", "a phase function", "(required)", "the layer's"},
        {"second_phase_function", "string", "-", "a phase function", "(none)",
         "adds an axis: f phi1 + (1 - f) phi2, f = w1 / (w1 + w2)"},
        {"mixture", "table { min, max }", "-", "-", "(all of [0, 1])",
         "range of f, with a second phase function"},
        {"mixture.min", "number", "-", "[0, 1]", "(required)", "smallest f"},
        {"mixture.max", "number", "-", "[0, 1]", "(required)", "largest f, above min"},
        {"family", "table", "-", "-", "(none)",
         "one or two axes over parameters of the phase function: ranges, sampled as the tolerance "
         "asks, or just some values, of which lookups take one"},
        {"family.mixture", "list [min, max] or table { values }", "-", "[0, 1]", "(none)",
         "in place of the key mixture, for a second axis beside it"},
        {"family.mixture.values", "list of numbers", "-", "[0, 1]", "(required)", "ascending"},
        {"family.g", "list [min, max] or table { values }", "-", "(-1, 1)", "(none)",
         "of henyey_greenstein"},
        {"family.g.values", "list of numbers", "-", "(-1, 1)", "(required)", "ascending"},
        {"family.radius", "list [min, max] or table { values }", "um or nm", "-", "(none)",
         "of mie, as in [\"4um\", \"20um\"]"},
        {"family.radius.values", "list of strings", "um or nm", "-", "(required)", "ascending"},
        {"family.wavelength", "list [min, max] or table { values }", "um or nm", "-", "(none)",
         "of mie"},
        {"family.wavelength.values", "list of strings", "um or nm", "-", "(required)", "ascending"},
        {"family.variance", "list [min, max] or table { values }", "-", "[1e-6, 0.5]", "(none)",
         "of mie"},
        {"family.variance.values", "list of numbers", "-", "[1e-6, 0.5]", "(required)",
         "ascending"},
        {"tolerance", "number", "-", "[1e-6, 0.1]", "(required)", "relative error of R and T"},
        {"optical_depth", "table { min, max }", "-", "-", "(required)", "range of tau"},
        {"optical_depth.min", "number", "-", depth, "(required)", "smallest tau"},
        {"optical_depth.max", "number", "-", depth, "(required)", "largest tau"},
        {"albedo", "table { min, max } or \"phase_function\"", "-", "-", "(required)",
         "range of w; \"phase_function\": that of the droplets (mie) alone"},
        {"albedo.min", "number", "-", "[0, 1]", "(required)", "smallest w"},
        {"albedo.max", "number", "-", "[0, 1]", "(required)", "largest w"},
        {"mu_in", "number or table { min, max }", "-", "[0, 1]", "(all)",
         "incident cosines that the table is to know"},
        {"mu_in.min", "number", "-", "[0, 1]", "(required)", "smallest"},
        {"mu_in.max", "number", "-", "[0, 1]", "(required)", "largest"},
        {"mu_out", "number or table { min, max }", "-", "[0, 1]", "(all)",
         "outgoing cosines that the table is to know"},
        {"mu_out.min", "number", "-", "[0, 1]", "(required)", "smallest"},
        {"mu_out.max", "number", "-", "[0, 1]", "(required)", "largest"},
        {"azimuth_deg", "number or table { min, max }", "degrees", "[0, 180]", "(all)",
         "azimuths that the table is to know"},
        {"azimuth_deg.min", "number", "degrees", "[0, 180]", "(required)", "smallest"},
        {"azimuth_deg.max", "number", "degrees", "[0, 180]", "(required)", "largest"},
        {"sides", "list of strings", "-", "\"reflection\", \"transmission\" or both",
         "(both where anything passes)", "which sides of the layer the table has"},
        {"orders", "\"all\" or a whole number", "-", "[2, 100]", "\"all\"",
         "n: the Neumann series stops at order n"},
        {"below", "table", "-", "-", "(nothing)",
         "what the layer lies on; the table is then that of both, reflection alone"},
        {"below.lambert_albedo", "number", "-", "[0, 1]", "(or another ground)",
         "of a Lambert surface"},
        {"below.ground", "string", "-", "a ground", "(or another ground)",
         "a law of reflection, or a layer of a packed table"},
        {"below.phase_function", "string", "-", "a phase function", "(or another ground)",
         "of a semi-infinite layer"},
        {"below.albedo", "number", "-", "[0, 1]", "(or another ground)",
         "of a semi-infinite layer"},
        {"discretisation", "table", "-", "-", "(by measurement)", "overrides any choice"},
        {"discretisation.nodes", "whole number", "-", "[1, 512]", "(by measurement)",
         "Gauss nodes of the solver"},
        {"discretisation.modes", "whole number", "-", "[1, 1024]", "(by measurement)",
         "azimuthal modes"},
        {"discretisation.mu_samples", "whole number", "-", "[4, 512]", "(by measurement)",
         "of mu_in and mu_out alike"},
        {"discretisation.azimuth_samples", "whole number", "-", "[1, 1024]", "(by measurement)",
         "over 0 to 180 degrees, ends included"},
        {"discretisation.azimuth_scale", "string", "-", "\"linear\" or \"square_root\"",
         "(the cheaper; linear with azimuth_samples)", "what azimuths are even in"},
        {"discretisation.optical_depth_samples_per_octave", "whole number", "-", "[1, 64]",
         "(by measurement)", "octaves are factors of 2"},
        {"discretisation.deepest_optical_depth", "number", "-", "[1e-3, 1e9]", "(by measurement)",
         "last finite sample where optical_depth.max is inf"},
        {"discretisation.albedo_samples", "whole number", "-", "[1, 512]", "(by measurement)",
         "of w"},
        {"discretisation.albedo_scale", "string", "-",
         "\"square_root_of_complement\" or \"fourth_root_of_complement\"",
         "(the cheaper; the former with albedo_samples)", "what albedos are even in, of 1 - w"},
        {"discretisation.mixture_samples", "whole number", "-", "[2, 64]", "(by measurement)",
         "of f, with a second phase function"},
        {"discretisation.g_samples", "whole number", "-", "[2, 64]", "(by measurement)",
         "along its range in [family]"},
        {"discretisation.radius_samples", "whole number", "-", "[2, 64]", "(by measurement)",
         "along its range in [family]"},
        {"discretisation.wavelength_samples", "whole number", "-", "[2, 64]", "(by measurement)",
         "along its range in [family]"},
        {"discretisation.variance_samples", "whole number", "-", "[2, 64]", "(by measurement)",
         "along its range in [family]"},
        {"discretisation.scheme", "string", "-", "\"harmonic\" or \"classic\"", "\"harmonic\"",
         "the solver"},
    };
    return keys;
}

Keys stack_keys() {
    static const std::vector<Key> keys = [] {
        std::vector<Key> all{
            {"layers", "tables [[layers]]", "-", "-", "(required)", "the layers, top first"},
            {"layers.phase_function", "string or a list of three", "-", "a phase function",
             "(required)",
             "docs/recipes.md; three, in scenes and exports, are of red, green and blue"},
            {"layers.albedo", "number or three numbers", "-", "[0, 1]", "(required)",
             "single scattering"},
            {"layers.optical_depth", "number or three numbers", "-", "[0, inf]", "(required)",
             "finite where anything lies below, and where there are three"},
            {"below", "table", "-", "-", "(nothing)", "what the lowest layer lies on"},
        };
        // Keys for baking the stack as one material, as in recipes.
        const auto is_shared = [](const Key& key) {
            const std::string name = key.name, section = name.substr(0, name.find('.'));
            const std::set<std::string> top{"title",       "tolerance", "mu_in",         "mu_out",
                                            "azimuth_deg", "sides",     "discretisation"},
                choices{"nodes", "modes", "mu_samples", "azimuth_samples", "azimuth_scale"};
            return section == name               ? top.contains(name)
                   : section == "discretisation" ? choices.contains(key.own_name())
                                                 : section == "below" || top.contains(section);
        };
        std::ranges::copy_if(recipe_keys(), std::back_inserter(all), is_shared);
        for (Key& key : all)
            if (key.name == std::string("tolerance")) key.default_value = "1e-3";
        return all;
    }();
    return keys;
}

}  // namespace stratus
