// A packed table for materials of renderers whose depth and albedo vary from place to place: lookups at
// any, and a few layers prepared to draw directions from.
//
// stratus_lookup.h is written by `stratus shader TABLE --language cpp -o DIR`.
#pragma once

#include "stratus_lookup.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <string>

/// A table, and grey layers of it that directions are drawn for: depths of all powers of two, a few
/// albedos. Each is prepared when it is first asked for.
class StratusTable {
  public:
    /// Errors   std::runtime_error for a file that is no packed table.
    explicit StratusTable(const std::string& path) : lookup(path) {}

    /// Returns the prepared layer nearest to one of this depth and albedo.
    const stratus_lookup::Layer& layer_near(float depth, float albedo) const {
        constexpr float between_powers_of_two = 1.41421356f, albedos[] = {0.5f, 0.8f, 0.95f, 1};
        int power = 0, brightness = 0;
        float nearest = shallowest;
        for (; power + 1 < depths && depth > nearest * between_powers_of_two; ++power) nearest *= 2;
        while (brightness < 3 && albedo > (albedos[brightness] + albedos[brightness + 1]) / 2)
            ++brightness;
        Prepared& one = prepared[power][brightness];
        std::call_once(one.once, [&] {
            const float tau = std::min(nearest, lookup.most_depth()),
                        w = std::clamp(albedos[brightness], lookup.least_albedo(),
                                       lookup.most_albedo());
            one.layer = std::make_unique<stratus_lookup::Layer>(
                lookup, stratus_lookup::vec3(tau, tau, tau), stratus_lookup::vec3(w, w, w));
        });
        return *one.layer;
    }

    const stratus_lookup::Table lookup;

  private:
    static constexpr int depths = 17;
    static constexpr float shallowest = 1.0f / 256;

    struct Prepared {
        std::once_flag once;
        std::unique_ptr<stratus_lookup::Layer> layer;
    };
    mutable Prepared prepared[depths][4];
};
