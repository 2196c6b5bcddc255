// A BSDF: a slice that can also draw directions in proportion to the light scattered into them.
//
// Vectors are in the local frame of the surface, z along its normal, unit length, both pointing
// away from the layer; they are not normalised, and arguments out of range count as in lookup.h.
// Light may come from either side (over ground, from above alone). Angles are (mu_in, mu_out,
// azimuth) as in slices, light then comes from above. Densities are per steradian of outgoing
// directions. The directly transmitted beam is no part of a BSDF: see SliceOf::direct.
//
// Directions follow single scattering and all higher orders together, both sides at once. Colours
// are drawn together, by their envelope (direction_density.h).
//
// Accuracy  eval * cos / pdf varies by 1 to 9 % of its mean, up to 15 % within a few degrees of the
//           normal and the horizon for Henyey-Greenstein's g = 0.85, up to 25 % for g = 0.95; 15 %
//           at most in the peaks of droplets of 10 um, from any incident cosine >= 0.05. Of colours
//           of unlike depths it varies by 50 % of the mean in the brightest channel, and is not
//           more than 5 times the mean in any.
// Cost      to build: 3 to 8 ms, 150,000 lookups of the slice; 126 kB. Of colours twice the time.
//           With sharp peaks six times the lookups, and 0.84 MB.
// Threads   no call allocates, throws or takes a lock; any number of threads may share a BSDF.
#pragma once

#include <stratus/base/direction.h>
#include <stratus/bsdf/direction_density.h>
#include <stratus/bsdf/slice.h>
#include <stratus/layer/single_scattering.h>

#include <cstddef>
#include <vector>

namespace stratus {

/// Shares of a beam that a layer scatters; the rest is transmitted directly or absorbed.
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
        float pdf;    // 0: nothing is scattered, and the rest is undefined
    };
    struct SampleOfAngles {
        Side side;
        float mu_out, azimuth;
        Value value;
        float pdf;
    };

    /// Owns the slice: a material needs to keep nothing else.
    ///
    ///     const Bsdf bsdf(bind(table.view(), optical_depth, albedo));
    ///
    /// Errors   std::invalid_argument for a slice of a table that was narrowed to some directions.
    explicit BsdfOf(SliceOf<channels> slice);

    /// BRDF or BTDF, R / pi or T / pi; symmetric.
    Value eval(const Vector& wi, const Vector& wo) const noexcept { return slice_.eval(wi, wo); }
    Value eval(Side side, float mu_in, float mu_out, float azimuth) const noexcept;

    /// Density with which `sample` draws wo: exact, in the peaks too.
    float pdf(const Vector& wi, const Vector& wo) const noexcept;
    float pdf(Side side, float mu_in, float mu_out, float azimuth) const noexcept;

    /// Draws a direction: u1 the cosine and its side, u2 the azimuth, u3 one of two tabulated
    /// incident cosines. Evenly spread random numbers give evenly spread directions.
    ///
    /// Range    [0, 1) each; others are clamped. Not-a-number gives a sample of nothing else.
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
    template <class Coordinates, int cosines, int azimuths>
    void integrate_albedo();

    SliceOf<channels> slice_;
    DirectionDensity density_;
    std::vector<float> albedo_;  // over (mu_in, Side, channel), per share of light intercepted
};

using Bsdf = BsdfOf<1>;
using RgbBsdf = BsdfOf<3>;

extern template class BsdfOf<1>;
extern template class BsdfOf<3>;

}  // namespace stratus
