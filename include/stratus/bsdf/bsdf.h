// The density that directions are drawn from, then the BSDF that draws them.
//
// The density that a BSDF draws directions from (bsdf.h): linear between samples over incident
// cosine, outgoing cosine and azimuth, in coordinates that widen forward and backward peaks.
// Samples follow exactly the density that `pdf` returns.
//
// Peaks like Henyey-Greenstein's need few samples. Where these fall short of the light, as in the
// peak of a droplet's phase function, there are more, in coordinates that leave a share to each
// octave of the scattering angle.
//
// After construction no call allocates, throws or takes a lock.
#pragma once

#include <stratus/base/direction.h>
#include <stratus/bsdf/slice.h>
#include <stratus/layer/single_scattering.h>

#include <cstddef>
#include <functional>
#include <vector>

namespace stratus {

/// Density of directions over (incident cosine, side, outgoing cosine, azimuth), to be read and
/// drawn from.
class DirectionDensity {
  public:
    /// Light scattered between `count` pairs of directions, on any scale; arrays of x, y and z.
    /// Channel c of pair i lands in value[c * count + i].
    using Light = std::function<void(std::size_t count, const float* const wi[3],
                                     const float* const wo[3], float* value)>;

    /// A direction's angle to the normal. Both numbers, for either alone loses one end to rounding.
    struct Inclination {
        float cosine, sine_squared;
    };

    struct Direction {
        Side side;
        float mu, sine;
        float cos_azimuth, sin_azimuth;
        float pdf;  // per steradian; 0: nothing is scattered
    };

    /// With several channels the density follows the brightest, for each incident cosine, and others
    /// where it would fall so far below them that a weight, light / density, exceeded 4 times its
    /// mean in the channel.
    DirectionDensity(int channels, const Light& light);

    /// Cosine and sine of half the azimuth, neither negative, on any scale.
    struct HalfAzimuth {
        float cosine, sine;
        float square;  // the sum of their squares
    };

    float pdf(Side side, const Inclination& in, const Inclination& out,
              const HalfAzimuth& half) const noexcept;

    /// u1 draws the outgoing cosine and its side, u2 the azimuth, u3 which of the two nearest
    /// samples of the incident cosine is used.
    Direction sample(const Inclination& in, float u1, float u2, float u3) const noexcept;

    std::size_t bytes() const noexcept;

    /// Widths of the peaks of one side in the coordinate of cosines, and how that of mu_out is
    /// stretched around them.
    struct Peaks {
        float at_same_cosine;  // forward in transmission, backward in reflection
        float at_horizon;      // the other one, where both cosines are small
        float slope;           // of the coordinate where mu_out equals mu_in
        float half_over_bend;  // 1 / (2 (1 - slope))
    };

    const Peaks& peaks(Side side) const noexcept { return peaks_[side]; }

    /// True where samples lie in the coordinates of sharp peaks.
    bool is_peaked() const noexcept { return is_peaked_; }

    /// All samples, for those who draw elsewhere; a line has one mu_out.
    struct Samples {
        std::vector<float> density;        // over (mu_in, line, azimuth)
        std::vector<float> along_azimuth;  // cumulative, 0 to 1, in each line
        std::vector<float> over_lines;     // cumulative, 0 to 1, for each mu_in
    };
    const std::vector<float>& samples() const noexcept { return samples_.density; }
    const std::vector<float>& along_azimuth() const noexcept { return samples_.along_azimuth; }
    const std::vector<float>& over_lines() const noexcept { return samples_.over_lines; }

  private:
    PerSide<Peaks> peaks_;
    bool is_peaked_ = false;
    Samples samples_;
};

// A BSDF: a slice that can also draw directions in proportion to the light scattered into them.
//
// Vectors are in the local frame of the surface, z along its normal, unit length, both pointing
// away from the layer; they are not normalised, and arguments out of range count as in lookup.h.
// Light may come from either side (over ground and of stacks, from above alone). Angles are (mu_in,
// mu_out, azimuth) as in slices, light then comes from above. Densities are per steradian of outgoing
// directions. The directly transmitted beam is no part of a BSDF: see SliceOf::direct.
//
// Directions follow single scattering and all higher orders together, both sides at once. Colours
// are drawn together, by their envelope (bsdf.h).
//
// Accuracy  eval * cos / pdf varies by 1 to 9 % of its mean, up to 15 % within a few degrees of the
//           normal and the horizon for Henyey-Greenstein's g = 0.85, up to 25 % for g = 0.95; 15 %
//           at most in the peaks of droplets of 10 um, from any incident cosine >= 0.05. Of colours
//           of unlike depths it varies by 50 % of the mean in the brightest channel, and is not
//           more than 5 times the mean in any.
// Cost      to build: 3 to 8 ms, 150,000 lookups of the slice; 126 kB. Of colours twice the time.
//           With sharp peaks six times the lookups, and 0.84 MB.
// Threads   no call allocates, throws or takes a lock; any number of threads may share a BSDF.

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

    /// BRDF or BTDF, R / pi or T / pi; symmetric but for the T of a stack.
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
