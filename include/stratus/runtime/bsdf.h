// A BSDF: a slice that can also draw directions in proportion to the light scattered into them.
//
// Vectors are in the local frame of the surface, z along its normal, unit length, both pointing
// away from the layer; light may come from either side (over ground, from above alone). Angles are
// (mu_in, mu_out, azimuth) as in slices, light then comes from above. Densities are per steradian
// of outgoing directions. The beam that passes straight through is no part of a BSDF: see
// SliceOf::direct and SliceOf::background.
//
// Directions follow single scattering and all higher orders together, both sides at once, the mean
// over channels. Their density is linear between samples over incident cosine, outgoing cosine and
// azimuth, in coordinates that widen the slice's forward and backward peaks; what is drawn and what
// `pdf` says are one and the same function.
//
// Accuracy  eval * cos / pdf varies by 1 to 9 % of its mean, up to 15 % within a few degrees of the
//           normal and the horizon for Henyey-Greenstein's g = 0.85, up to 25 % for g = 0.95.
// Cost      to build: 3 to 8 ms, a hundred and fifty thousand lookups of the slice; 126 kB.
// Threads   no call allocates, throws or takes a lock; any number of threads may share a BSDF.
#pragma once

#include <stratus/runtime/direction.h>
#include <stratus/runtime/single_scattering.h>
#include <stratus/runtime/slice.h>

#include <cstddef>
#include <functional>
#include <vector>

namespace stratus {

/// Density of directions over (incident cosine, side, outgoing cosine, azimuth), to be read and
/// drawn from.
class DirectionDensity {
  public:
    /// What `count` pairs of directions scatter, on any scale; arrays of x, y and z.
    using Light = std::function<void(std::size_t count, const float* const wi[3],
                                     const float* const wo[3], float* value)>;

    /// A direction's angle to the normal; both, for either alone loses one end to rounding.
    struct Inclination {
        float cosine, sine_squared;
    };

    struct Direction {
        Side side;
        float mu, sine;
        float cos_azimuth, sin_azimuth;
        float pdf;  // per steradian; 0: nothing is scattered
    };

    explicit DirectionDensity(const Light& light);

    /// Cosine and sine of half the azimuth, neither negative, on any scale.
    struct HalfAzimuth {
        float cosine, sine;
        float square;  // the sum of their squares
    };

    float pdf(Side side, const Inclination& in, const Inclination& out,
              const HalfAzimuth& half) const noexcept;

    /// u1 draws the outgoing cosine and its side, u2 the azimuth, u3 which of the two nearest
    /// samples of the incident cosine speaks.
    Direction sample(const Inclination& in, float u1, float u2, float u3) const noexcept;

    std::size_t bytes() const noexcept;

    /// How wide the peaks of one side are, in the coordinate of cosines, and how that of mu_out is
    /// widened around them.
    struct Peaks {
        float at_same_cosine;  // straight on through the layer, or straight back
        float at_horizon;      // the other one, met where both cosines are small
        float slope;           // of the coordinate where mu_out equals mu_in
        float half_over_bend;  // 1 / (2 (1 - slope))
    };

    const Peaks& peaks(Side side) const noexcept { return peaks_[static_cast<int>(side)]; }

  private:
    struct Place;
    struct Draw;
    float at(const Place& place) const noexcept;
    template <Side side>
    Direction draw(const Draw& given) const noexcept;

    Peaks peaks_[2];                    // over Leaves
    std::vector<float> density_;        // over (mu_in, line, azimuth); a line is a place of mu_out
    std::vector<float> along_azimuth_;  // cumulative, 0 to 1, in each line
    std::vector<float> over_lines_;     // cumulative, 0 to 1, for each mu_in
};

/// What a layer makes of a beam, as shares of it; the rest passes straight through or is absorbed.
template <class Value>
struct ScatteredShares {
    Value reflected, transmitted;  // without the beam itself
};

template <int channels>
class BsdfOf {
  public:
    using Value = typename SliceOf<channels>::Value;

    struct Sample {
        Vector wo;
        Value value;  // eval(wi, wo)
        float pdf;    // 0: nothing is scattered, and the other numbers mean nothing
    };
    struct SampleOfAngles {
        Side side;
        float mu_out, azimuth;
        Value value;
        float pdf;
    };

    /// Takes the slice over: a BSDF is all that a material needs to keep.
    ///
    ///     const Bsdf bsdf(bind(table.view(), optical_depth, albedo));
    explicit BsdfOf(SliceOf<channels> slice);

    /// BRDF or BTDF, R / pi or T / pi; symmetric.
    Value eval(const Vector& wi, const Vector& wo) const noexcept { return slice_.eval(wi, wo); }
    Value eval(Side side, float mu_in, float mu_out, float azimuth) const noexcept;

    /// Density with which `sample` draws wo.
    float pdf(const Vector& wi, const Vector& wo) const noexcept;
    float pdf(Side side, float mu_in, float mu_out, float azimuth) const noexcept;

    /// Draws a direction: u1 the cosine and its side, u2 the azimuth, u3 one of two tabulated
    /// incident cosines. Points that are evenly spread stay so.
    ///
    /// Range    [0, 1) each; values outside count as the nearest inside.
    Sample sample(const Vector& wi, float u1, float u2, float u3) const noexcept;
    SampleOfAngles sample(float mu_in, float u1, float u2, float u3) const noexcept;

    /// Light scattered to either side, as shares of a beam.
    ScatteredShares<Value> albedo(const Vector& wi) const noexcept;
    ScatteredShares<Value> albedo(float mu_in) const noexcept;

    const SliceOf<channels>& slice() const noexcept { return slice_; }

    /// Memory that calls read, the slice's included.
    std::size_t bytes() const noexcept;

  private:
    bool is_lit(const Vector& wi) const noexcept;

    SliceOf<channels> slice_;
    DirectionDensity density_;
    std::vector<float> albedo_;  // over (mu_in, Leaves, channel), per share of light intercepted
};

using Bsdf = BsdfOf<1>;
using RgbBsdf = BsdfOf<3>;

extern template class BsdfOf<1>;
extern template class BsdfOf<3>;

}  // namespace stratus
