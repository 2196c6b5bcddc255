// Coordinates of directions, along which a BSDF samples and integrates its density: cosines by
// v = sqrt(1 - sqrt(mu)), outgoing cosines and azimuths stretched around the peaks.
#pragma once

#include <stratus/bsdf/bsdf.h>

#include "base/lanes.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace stratus {
namespace {

using Inclination = DirectionDensity::Inclination;
using Peaks = DirectionDensity::Peaks;
using Light = DirectionDensity::Light;

/// `low` for not-a-number. With branches, which are nearly always predicted.
[[gnu::always_inline]] inline float within(float low, float x, float high) noexcept {
    return x > low ? (x < high ? x : high) : low;
}

/// A cosine by its coordinate v = sqrt(1 - sqrt(mu)): half the angle to the normal near it, half
/// the root of the cosine below 1 near the horizon.
struct Cosine {
    float v, root_mu, mu;
};

// Both ends lie a little inside [0, 1], so that nothing is divided by 0.
constexpr float normal_v = 1e-6f, horizon_v = 1 - 5e-5f;

inline Cosine cosine_at(float v) noexcept {
    const float inside = within(normal_v, v, horizon_v);
    const float root_mu = (1 - inside) * (1 + inside);
    return {inside, root_mu, root_mu * root_mu};
}

inline Cosine to_cosine(const Inclination& to_normal) noexcept {
    const float mu = within(0, to_normal.cosine, 1);
    return cosine_at(square_root(to_normal.sine_squared / ((1 + mu) * (1 + square_root(mu)))));
}

/// Two cosines for one division.
struct Cosines {
    Cosine in, out;

    Cosines(const Inclination& from, const Inclination& to) noexcept {
        const float mu_in = within(0, from.cosine, 1), mu_out = within(0, to.cosine, 1);
        const float below_in = (1 + mu_in) * (1 + square_root(mu_in));
        const float below_out = (1 + mu_out) * (1 + square_root(mu_out));
        const float one_over = 1 / (below_in * below_out);
        in = cosine_at(square_root(from.sine_squared * below_out * one_over));
        out = cosine_at(square_root(to.sine_squared * below_in * one_over));
    }
};

inline Inclination inclination(float mu) noexcept {
    const float cosine = within(0, mu, 1);
    return {cosine, (1 - cosine) * (1 + cosine)};
}

inline float sine(const Cosine& cosine) noexcept {
    return cosine.v * square_root((1 + cosine.root_mu) * (1 + cosine.mu));
}

/// A quarter of the outgoing directions: of one side, from mu_in to the normal or to the horizon.
/// Numbers in place of choices, for a branch would mispredict.
struct SphereQuarter {
    int number;

    SphereQuarter(Side side, bool to_horizon) noexcept
        : number(2 * static_cast<int>(side) + (to_horizon ? 1 : 0)) {}
    explicit SphereQuarter(int number_) noexcept : number(number_) {}

    Side side() const noexcept { return static_cast<Side>(number / 2); }
    /// Signed distance in v from mu_in to the end of the quarter.
    float reach(const Cosine& in) const noexcept { return as_float(number % 2) - in.v; }
};

/// On the way from mu_in, s = 0, to an end of a quarter, s = 1.
struct OutgoingCosine {
    Cosine cosine;
    float stretch;  // |d mu / d s|
};

struct Azimuth {
    float cosine, sine;
    float stretch;  // d azimuth / d q
};

/// tan(azimuth / 2) = a q / (b (1 - q)), q in [0, 1].
struct AzimuthScale {
    float a, b;
};

/// Coordinates that suit peaks like Henyey-Greenstein's, by the names that all coordinates share.
struct LobeCoordinates {
    /// Incident cosines over [0, 1], the normal first: v, and its inverse.
    static float incident_v(float place) noexcept { return place; }
    static float incident_place(const Cosine& in) noexcept { return in.v - normal_v; }

    /// v - v_in = reach (slope s + (1 - slope) s^2).
    static OutgoingCosine outgoing_cosine(const SphereQuarter& quarter, const Peaks& peaks,
                                          const Cosine& in, float s) noexcept {
        const float reach = quarter.reach(in), slope = peaks.slope;
        const Cosine out = cosine_at(in.v + reach * s * (slope + (1 - slope) * s));
        return {out, std::abs(reach) * (slope + 2 * (1 - slope) * s) * (4 * out.v * out.root_mu)};
    }

    [[gnu::always_inline]] static AzimuthScale azimuth_scale(Side side, const Peaks& peaks,
                                                             const Cosine& in,
                                                             const Cosine& out) noexcept {
        // The smallest and the largest angle from the middle of either peak over all azimuths.
        const float apart = std::abs(in.v - out.v), sum = in.v + out.v;
        const float elevation = (in.mu + out.mu) * 0.5f;
        const float nearer = (peaks.at_same_cosine + apart) * (peaks.at_horizon + 1);
        const float farther = (peaks.at_same_cosine + sum) * (peaks.at_horizon + elevation);
        const float both[2] = {farther, nearer};
        const int index = static_cast<int>(side);
        return {both[index], both[1 - index]};
    }

    static Azimuth azimuth_at(const AzimuthScale& scale, float q) noexcept {
        const float x = scale.b * (1 - q), y = scale.a * q;
        const float one_over = 1 / (x * x + y * y);
        return {(x - y) * (x + y) * one_over, 2 * x * y * one_over,
                2 * scale.a * scale.b * one_over};
    }
};

/// A coordinate of distances in [0, 1], linear in the fourth root of `blur` + distance: places lie
/// densest at 0, and every octave of distances beyond `blur` has its share of them.
struct FourthRoot {
    float blur, from, length;

    explicit FourthRoot(float blur_) noexcept
        : blur(blur_),
          from(square_root(square_root(blur))),
          length(square_root(square_root(1 + blur)) - from) {}

    float distance(float place) const noexcept {
        const float root = from + place * length, square = root * root;
        return within(0, square * square - blur, 1);
    }
    /// d distance / d place.
    float stretch(float place) const noexcept {
        const float root = from + place * length;
        return 4 * length * root * root * root;
    }
    float place(float distance) const noexcept {
        return (square_root(square_root(blur + distance)) - from) / length;
    }
};

/// Coordinates for peaks that rise from a wide foot, as those of droplets: fourth roots of the
/// distance to the middle of the forward peak.
struct PeakedCoordinates {
    static constexpr float normal_slope = 0.1f;
    static constexpr float width = 0.005f;  // radians; a fraction of the narrowest peak's

    /// Densest at the normal, where a peak is a ring around it.
    static float incident_v(float place) noexcept {
        return place * (normal_slope + (1 - normal_slope) * place);
    }
    static float incident_place(const Cosine& in) noexcept {
        return 2 * in.v /
               (normal_slope +
                square_root(normal_slope * normal_slope + 4 * (1 - normal_slope) * in.v));
    }

    static FourthRoot cosine_root(const SphereQuarter& quarter, const Cosine& in) noexcept {
        constexpr float in_reflection = 0.5f;  // there the middle lies below the horizon
        const float blur =
            quarter.side() == Side::transmission ? width / (3 * in.root_mu + width) : in_reflection;
        return FourthRoot(blur / (std::abs(quarter.reach(in)) + blur));
    }

    static OutgoingCosine outgoing_cosine(const SphereQuarter& quarter, const Peaks& /*peaks*/,
                                          const Cosine& in, float s) noexcept {
        const FourthRoot root = cosine_root(quarter, in);
        const float reach = quarter.reach(in);
        const Cosine out = cosine_at(in.v + reach * root.distance(s));
        return {out, std::abs(reach) * root.stretch(s) * (4 * out.v * out.root_mu)};
    }

    /// Along tan(azimuth / 4).
    static FourthRoot azimuth_scale(Side side, const Peaks& /*peaks*/, const Cosine& in,
                                    const Cosine& out) noexcept {
        // The square of the smallest scattering angle over all azimuths.
        const float sine_in = sine(in), sine_out = sine(out), along = sine_in - sine_out;
        const float across = side == Side::transmission ? in.mu - out.mu : in.mu + out.mu;
        const float smallest = width * width + along * along + across * across;
        return FourthRoot(square_root(smallest / (16 * sine_in * sine_out + smallest)));
    }
    static Azimuth azimuth_at(const FourthRoot& root, float q) noexcept {
        const float t = root.distance(q), one_over = 1 / (1 + t * t);
        const float cosine = (1 - t) * (1 + t) * one_over, sine = 2 * t * one_over;  // of half
        return {(cosine - sine) * (cosine + sine), 2 * cosine * sine,
                4 * one_over * root.stretch(q)};
    }
};

/// Pairs of directions of one incident cosine, to be evaluated together.
class DirectionPairs {
  public:
    void add(Side side, const Cosine& in, const OutgoingCosine& out, const Azimuth& azimuth) {
        const float sine_out = sine(out.cosine);
        const bool reflected = side == Side::reflection;
        const float vectors[6] = {sine(in),
                                  0,
                                  in.mu,
                                  -sine_out * azimuth.cosine,
                                  sine_out * azimuth.sine,
                                  reflected ? out.cosine.mu : -out.cosine.mu};
        for (std::size_t i = 0; i < 6; ++i) vectors_[i].push_back(vectors[i]);
    }

    std::size_t count() const { return vectors_[0].size(); }

    void evaluate(const Light& light, float* value) const {
        const float* const in[3] = {vectors_[0].data(), vectors_[1].data(), vectors_[2].data()};
        const float* const out[3] = {vectors_[3].data(), vectors_[4].data(), vectors_[5].data()};
        light(count(), in, out, value);
    }

  private:
    std::array<std::vector<float>, 6> vectors_;
};

}  // namespace
}  // namespace stratus
