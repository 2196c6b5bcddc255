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

/// The text of a recipe, the same for the same seed: a layer alone or over any ground, a family, a
/// stack, all directions or some.
class RandomRecipe {
  public:
    explicit RandomRecipe(unsigned seed) : random_(seed) {}

    std::string text() {
        const std::string tolerance = line("tolerance = %.2g\n", std::pow(10, between(-3, -1.7)));
        const double kind = between(0, 1);
        if (kind < 0.25) return tolerance + stack();
        if (kind < 0.35) return family() + tolerance + layers();
        std::string recipe = "phase_function = '" + phase_function() + "'\n";
        if (kind < 0.45) recipe += "second_phase_function = '" + phase_function() + "'\n";
        recipe += tolerance + layers();
        if (kind < 0.55) return recipe + directions();
        if (kind < 0.6) return recipe + "sides = ['transmission']\n";
        if (kind < 0.65) return recipe + line("orders = %.0f\n", std::floor(between(2, 20)));
        return kind < 0.85 ? recipe + "[below]\n" + ground() : recipe;
    }

  private:
    double between(double low, double high) {
        return low + (high - low) * static_cast<double>(random_()) / 4294967296.0;
    }
    bool chance(double share) { return between(0, 1) < share; }
    template <class... Values>
    static std::string line(const char* format, Values... values) {
        char text[160];
        std::snprintf(text, sizeof text, format, values...);
        return text;
    }

    std::string lobe() { return line("henyey_greenstein:g=%.3f", between(-0.7, 0.8)); }
    std::string phase_function() {
        switch (random_() % 7) {
            case 0: return lobe();
            case 1: return line("%.2f*", between(0.2, 0.8)) + lobe() + " + 0.4*" + lobe();
            case 2: return "rayleigh";
            case 3: return line("anisotropic:x=%.2f", between(-1, 1));
            case 4: return "isotropic";
            case 5: return "lambert_sphere";
            default: return line("henyey_greenstein:g=%.3f", between(0.8, 0.9));
        }
    }

    std::string layers() {
        const double shallowest = std::pow(10, between(-2, 0));
        const double deepest = shallowest * std::pow(10, between(0, 2.5));
        const double blackest = chance(0.3) ? 0 : between(0, 0.95);
        const double whitest = chance(0.7) ? 1 : blackest + 0.5 * (1 - blackest);
        return line("optical_depth = { min = %.3g, max = ", shallowest) +
               (chance(0.3) ? "inf" : line("%.3g", deepest)) + " }\n" +
               line("albedo = { min = %.3f, max = %.3f }\n", blackest, whitest);
    }

    std::string stack() {
        const bool over_ground = chance(0.4);
        std::string text;
        for (int left = chance(0.5) ? 2 : 1; left >= 0; --left) {
            text += "[[layers]]\nphase_function = '" + phase_function() + "'\n";
            text += line("albedo = %.3f\n", chance(0.2) ? 0 : chance(0.5) ? 1 : between(0, 1));
            text += "optical_depth = " + (left == 0 && !over_ground && chance(0.3)
                                              ? "inf\n"
                                              : line("%.3g\n", std::pow(10, between(-2, 1))));
        }
        return over_ground ? text + "[below]\n" + ground() : text;
    }

    std::string ground() {
        switch (random_() % 4) {
            case 0: return line("lambert_albedo = %.2f\n", chance(0.3) ? 1 : between(0, 1));
            case 1: return line("ground = 'ocean:wind=%.1f'\n", between(8, 30));
            case 2:
                return line("ground = 'rpv:rho0=%.3f,k=%.2f,theta=%.2f,rho_c=1'\n",
                            between(0.05, 0.3), between(0.9, 1.1), between(-0.3, 0.2));
            default:
                return "phase_function = '" + lobe() + line("'\nalbedo = %.2f\n", between(0, 1));
        }
    }

    std::string family() {
        const double least = between(-0.3, 0.5);
        return "phase_function = 'henyey_greenstein:g=0.3'\n" +
               line("family.g = [%.3f, %.3f]\n", least, least + between(0.05, 0.3));
    }

    std::string directions() {
        const double mu_in = between(0.05, 1), azimuth = between(20, 180);
        std::string text = chance(0.5)
                               ? line("mu_in = %.3f\n", mu_in)
                               : line("mu_in = { min = %.3f, max = %.3f }\n", mu_in / 2, mu_in);
        if (chance(0.5))
            text += line("azimuth_deg = { min = %.1f, max = %.1f }\n", azimuth / 3, azimuth);
        return text;
    }

    std::mt19937 random_;
};

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
