// Arguments of lookups: not-a-number gives not-a-number, all other numbers count as the nearest in
// range. Compiled with STRATUS_CHECKED, lookups refuse both instead: they end the program with a
// sentence on standard error. Lookups of slices bring theirs into range in base/light_path.h.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/base/direction.h>
#include <stratus/table/lookup.h>

#include "base/light_path.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <type_traits>

namespace stratus {

#ifdef STRATUS_CHECKED
constexpr bool lookups_are_checked = true;
#else
constexpr bool lookups_are_checked = false;
#endif

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

/// Ends the program unless `low` <= `value` <= `high`.
inline void refuse_outside(const char* argument, double low, double high, double value) noexcept {
    if (value >= low && value <= high) return;
    std::fprintf(stderr, "stratus lookup: %s must be in [%g, %g], got %.9g\n", argument, low, high,
                 value);
    std::abort();
}

/// The nearest number in range; not-a-number of not-a-number.
template <class Number>
Number in_range(const char* argument, Number low, Number high, Number value) noexcept {
    if constexpr (lookups_are_checked)
        refuse_outside(argument, double{low}, double{high}, double{value});
    return value > high ? high : value > low || value != value ? value : low;
}

template <class Number>
Number cosine_in_range(const char* argument, Number mu) noexcept {
    return std::max(in_range(argument, Number{0}, Number{1}, mu), Number{min_cosine});
}

/// Reduces an azimuth to [0, pi]; infinity gives not-a-number.
inline double azimuth_in_range(double azimuth) noexcept {
    if (azimuth >= 0 && azimuth <= pi) return azimuth;
    if constexpr (lookups_are_checked) {
        constexpr double most = std::numeric_limits<float>::max();
        refuse_outside("azimuth", -most, most, azimuth);
    }
    return std::abs(std::remainder(azimuth, 2 * pi));
}

/// Whether an argument is not-a-number.
template <class... Numbers>
bool is_unknown(Numbers... argument) noexcept {
    const auto sum = (argument + ...);
    return sum != sum && ((argument != argument) || ...);  // opposite infinities are known
}

/// 0, or not-a-number where an argument is that or infinite.
template <class... Numbers>
auto zero_or_nan(Numbers... argument) noexcept {
    return (argument + ...) * 0;
}

/// Arguments of a table's lookup in range.
struct TablePoint {
    double albedo, optical_depth;
    Geometry geometry;

    TablePoint(double w, double tau, const Geometry& g) noexcept
        : albedo(in_range("albedo", 0.0, 1.0, w)),
          optical_depth(in_range("optical_depth", 0.0, infinity, tau)),
          geometry{cosine_in_range("mu_in", g.mu_in), cosine_in_range("mu_out", g.mu_out),
                   azimuth_in_range(g.azimuth)} {}

    bool is_unknown() const noexcept {
        return stratus::is_unknown(albedo, optical_depth, geometry.mu_in, geometry.mu_out,
                                   geometry.azimuth);
    }
};

/// A value of one channel or three, from a number for each.
template <class Value>
Value from_channels(const float* x) noexcept {
    if constexpr (std::is_same_v<Value, float>)
        return *x;
    else
        return {x[0], x[1], x[2]};
}

template <class Value>
Value all_channels(float x) noexcept {
    const float same[] = {x, x, x};
    return from_channels<Value>(same);
}

/// Returns the light of a dark side: 0, or not-a-number where an argument is.
inline float dark_at(float mu_in, float mu_out, float azimuth) noexcept {
    return is_unknown(mu_in, mu_out, azimuth * 0) ? not_a_number : 0;
}

/// Light of the orders n >= 2 is not negative, wherever path laws or extrapolated samples are. Single scattering
/// may fall below 0 a little, where phase functions do; all light does not.
inline Scattered not_negative(const Scattered& light) noexcept {
    const Scattered kept{light.single, light.multiple < 0 ? 0 : light.multiple};
    return kept.total() < 0 ? Scattered{} : kept;
}

// Nothing unless lookups are checked.
inline void check_angles(float mu_in, float mu_out, float azimuth) noexcept {
    if constexpr (lookups_are_checked) TablePoint(0, 0, {mu_in, mu_out, azimuth});
}
inline void check_random_numbers(float u1, float u2, float u3) noexcept {
    if constexpr (lookups_are_checked) {
        in_range("u1", 0.0f, 1.0f, u1);
        in_range("u2", 0.0f, 1.0f, u2);
        in_range("u3", 0.0f, 1.0f, u3);
    }
}
inline void check_unit_length(const char* length, float x, float y, float z) noexcept {
    if constexpr (lookups_are_checked)
        refuse_outside(length, 0.999, 1.001, std::hypot(double{x}, double{y}, double{z}));
}
inline void check_vectors(const Vector& wi, const Vector& wo) noexcept {
    check_unit_length("length of wi", wi.x, wi.y, wi.z);
    check_unit_length("length of wo", wo.x, wo.y, wo.z);
}

}  // namespace stratus
