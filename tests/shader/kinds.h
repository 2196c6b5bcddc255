// Small tables of every kind that lookups differ for: no solution, but smooth functions in their place.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/phase/path_law.h>
#include <stratus/table/packed_table.h>

#include "small_table.h"

#include <cmath>
#include <string>
#include <vector>

namespace stratus::test {

/// A kind of table: what lookups do differs from one to another.
struct Kind {
    const char* name;
    const char* phase;
    bool to_infinity = true;
    int azimuths = 9;
    LowerBoundary below = {};
    bool narrowed = false, one_side = false;
    std::vector<StackLayer> layers = {};
    bool ridges = false;
    double deepest = 8, tolerance = 1e-3;
};

inline Table table_of(const Kind& kind) {
    const bool over = kind.below.is_present();
    const Depths depths{0.05, kind.deepest, kind.to_infinity && !over};
    Table table = empty_table(
        kind.ridges ? samples_of_ridges : Counts{6, 9, 12, kind.narrowed ? 7 : 12, kind.azimuths},
        depths);
    const FunctionOfPoint function = kind.ridges ? ridge : smooth_shape;
    if (kind.layers.empty()) table.phase_function = parse_phase_function(kind.phase);
    table.lower_boundary = kind.below;
    table.tolerance = kind.tolerance;
    if (!kind.layers.empty()) {
        const StackLayer mean = mean_layer(kind.layers);
        table.layers = kind.layers;
        table.phase_function = mean.phase_function;
        table.albedo.values = {mean.albedo};
        table.optical_depth.values = {mean.optical_depth};
        table.diffusion_exponent = {small_table_exponent(mean.albedo)};
    }
    if (kind.narrowed) {
        table.mu_out = make_axis(table.mu_out.scale, 0.2, 0.8, 7);
        table.azimuth = make_axis(AxisScale::square_root, 0.3, 2, kind.azimuths);
    }
    table.reflection_multiple = tabulate(table, [&](const SamplePoint& p) {
        return over ? shape_over_boundary(p) : small_table_scale(Side::reflection, p) * function(p);
    });
    if (!over && !kind.one_side)
        table.transmission_multiple = tabulate(table, [&](const SamplePoint& p) {
            return std::isinf(p.optical_depth)
                       ? 0
                       : small_table_scale(Side::transmission, p) * function(p);
        });
    table.path_law = PathOrders::of(table.phase_function);
    prepare(table);
    return table;
}

inline const std::vector<Kind>& kinds() {
    static const std::vector<Kind> all{
        {"rings", "0.6*henyey_greenstein:g=-0.5 + 0.4*henyey_greenstein:g=0.5"},
        {"isotropic", "isotropic", true, 1},
        {"finite", "rayleigh", false},
        {"path_law", "henyey_greenstein:g=0.9", false},
        {"sampled_phase", "tabulated:points=0 3/30 1.5/90 0.5/180 1"},
        {"over_surface", "rayleigh", false, 9, LowerBoundary::surface(0.3)},
        {"over_layer", "rayleigh", false, 9, LowerBoundary::layer(PhaseFunction::rayleigh(), 0.6)},
        {"narrowed", "rayleigh", true, 7, {}, true},
        {"one_side", "rayleigh", true, 9, {}, false, true},
        {"over_ocean", "rayleigh", false, 9,
         LowerBoundary::ground(read_ground_law("ocean:wind=10"))},
        {"ridges", "rayleigh", true, 9, {}, false, false, {}, true}};
    return all;
}

inline const std::vector<StackLayer> haze{
    {PhaseFunction::rayleigh(), 1, 0.2},
    {parse_phase_function("tabulated:points=0 3/30 1.5/90 0.5/180 1"), 0.7, 0.3},
    {PhaseFunction::henyey_greenstein(0.6), 0.95, 1.5}};

/// One material, all depths its own.
inline const std::vector<Kind>& stacks() {
    static const std::vector<Kind> all = [] {
        std::vector<StackLayer> endless = haze;
        endless.back().optical_depth = infinity;
        const auto ground = LowerBoundary::surface(0.3);
        const auto dust = LowerBoundary::layer(PhaseFunction::rayleigh(), 0.6);
        return std::vector<Kind>{{"stack", "", false, 9, {}, false, false, haze},
                                 {"stack_over_surface", "", false, 9, ground, false, false, haze},
                                 {"stack_over_layer", "", false, 9, dust, false, false, haze},
                                 {"endless_stack", "", false, 9, {}, false, true, endless}};
    }();
    return all;
}

/// Light in so narrow a peak that directions are drawn in other coordinates, and so deep that its
/// path law is the difference of numbers nearly alike.
inline const Kind droplets{"droplets",
                           "mie:radius=10um,variance=0.1,wavelength=0.55um,material=water", false};

/// Of all of these, by their names.
inline std::vector<Kind> kinds_of(const std::vector<std::string>& names) {
    std::vector<Kind> all = kinds(), found;
    all.insert(all.end(), stacks().begin(), stacks().end());
    all.push_back(droplets);
    for (const std::string& name : names)
        for (const Kind& kind : all)
            if (kind.name == name) found.push_back(kind);
    return found;
}
inline Kind kind_of(const std::string& name) { return kinds_of({name}).at(0); }

}  // namespace stratus::test
