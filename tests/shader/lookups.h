// Random lookups of a packed table, by the C++ runtime and by others, and how far these are off.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/table/packed_table.h>

#include "../base/indices.h"
#include "../base/uniform.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace stratus::test {

struct Lookup {
    float albedo, optical_depth, mu_in, mu_out, azimuth;

    Geometry geometry() const { return {double{mu_in}, double{mu_out}, double{azimuth}}; }
};

/// R and T, each of light scattered once and more often.
using Light = std::array<float, 4>;

/// Albedos and depths over all of the table's range and some beyond, depths evenly in their
/// logarithm; of a stack its own.
inline std::vector<Lookup> random_lookups(const PackedTable& table, int count) {
    const TableView view = table.view();
    const AxisView &albedo = view.albedo, &depth = view.optical_depth;
    const double shallowest = depth.lowest / (view.is_stack() ? 1 : 2),
                 deepest = depth.highest * (depth.ends_at_infinity ? 4 : 1);
    Uniform uniform(1);
    std::vector<Lookup> all;
    for (int n = 0; n < count; ++n) {
        const auto between = [&](double low, double high) {
            return static_cast<float>(low + (high - low) * uniform());
        };
        const float optical_depth =
            depth.count == 0 ? static_cast<float>(infinity)
                             : std::exp(between(std::log(shallowest), std::log(deepest)));
        all.push_back({between(albedo.lowest, albedo.highest), optical_depth, between(0.02, 1),
                       between(0.02, 1), between(0, 2 * pi)});
    }
    return all;
}

inline std::vector<Light> by_runtime(const PackedTable& table, const std::vector<Lookup>& lookups,
                                     double mixture = 1) {
    std::vector<Light> all;
    for (const Lookup& at : lookups) {
        const double w = double{at.albedo}, tau = double{at.optical_depth};
        const Scattered r = table.reflection(w, tau, at.geometry(), mixture),
                        t = table.transmission(w, tau, at.geometry(), mixture);
        all.push_back({static_cast<float>(r.single), static_cast<float>(r.multiple),
                       static_cast<float>(t.single), static_cast<float>(t.multiple)});
    }
    return all;
}

struct Differences {
    double median, usual, worst;  // usual: all but one in a thousand are smaller
};

/// Of R and T, all orders, relative to the runtime's but not to less than `floor`, by default a
/// millionth of a white surface. Numbers that are none are infinitely wrong.
inline Differences differences(const std::vector<Light>& found, const std::vector<Light>& expected,
                               double floor = 1e-6) {
    std::vector<double> all;
    for (const auto n : indices(expected))
        for (const std::size_t side : {std::size_t{0}, std::size_t{2}}) {
            const auto total = [&](const std::vector<Light>& light) {
                return double{light[n][side]} + double{light[n][side + 1]};
            };
            if (total(expected) == 0 && total(found) == 0) continue;  // a side that nothing leaves
            const double off = std::abs(total(found) - total(expected)) /
                               std::max(floor, std::abs(total(expected)));
            all.push_back(off >= 0 ? off : infinity);
        }
    std::ranges::sort(all);
    return {all[all.size() / 2], all[all.size() * 999 / 1000], all.back()};
}

}  // namespace stratus::test
