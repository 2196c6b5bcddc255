// Recipes that nobody chose: any phase function, range and tolerance that a bake of seconds serves.
#pragma once

#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>
#include <stratus/table/packed_table.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

namespace stratus::test {

/// The text of a recipe, the same for the same seed.
inline std::string random_recipe(unsigned seed) {
    std::mt19937 random(seed);
    const auto between = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
    };
    const auto chance = [&](double share) { return between(0, 1) < share; };
    const auto text = [](const char* format, auto... values) {
        char line[160];
        std::snprintf(line, sizeof line, format, values...);
        return std::string(line);
    };
    const auto lobe = [&] { return text("henyey_greenstein:g=%.3f", between(-0.7, 0.8)); };
    std::string phase;
    switch (random() % 5) {
        case 0: phase = lobe(); break;
        case 1: phase = text("%.2f*", between(0.2, 0.8)) + lobe() + " + 0.4*" + lobe(); break;
        case 2: phase = "rayleigh"; break;
        case 3: phase = text("anisotropic:x=%.2f", between(-1, 1)); break;
        default: phase = text("henyey_greenstein:g=%.3f", between(0.8, 0.9)); break;
    }
    const double shallowest = std::pow(10, between(-2, 0));
    const double deepest = shallowest * std::pow(10, between(0.5, 2.5));
    const double blackest = chance(0.3) ? 0 : between(0, 0.95);
    std::string recipe = "phase_function = '" + phase + "'\n";
    recipe += text("tolerance = %.2g\n", std::pow(10, between(-3, -1.7)));
    recipe += text("optical_depth = { min = %.3g, max = ", shallowest) +
              (chance(0.3) ? "inf" : text("%.3g", deepest)) + " }\n";
    recipe += text("albedo = { min = %.3f, max = %.3f }\n", blackest,
                   chance(0.7) ? 1.0 : blackest + 0.5 * (1 - blackest));
    if (chance(0.2))
        recipe += text("[below]\nlambert_albedo = %.2f\n", between(0, 1));
    return recipe;
}

/// A recipe baked straight into a packed table, and its lookups verified at points of their own.
struct PackedBake {
    Table header;
    std::vector<char> file;
    Verification verification;

    explicit PackedBake(const Recipe& recipe, int samples = 2000) {
        BakeOptions options;
        options.packed = &file;
        header = bake(recipe, options);
        const PackedTable packed(file);
        VerifyOptions check;
        check.samples = samples;
        check.fluxes = false;
        check.packed = &packed;
        verification = verify(header, check);
    }

    bool meets() const { return verification.meets(header.tolerance); }
};

}  // namespace stratus::test
