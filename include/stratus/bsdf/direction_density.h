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

    const Peaks& peaks(Side side) const noexcept { return peaks_[static_cast<int>(side)]; }

    /// True where samples lie in the coordinates of sharp peaks.
    bool is_peaked() const noexcept { return is_peaked_; }

    /// All samples, for those who draw elsewhere: over (mu_in, line, azimuth), and what is
    /// cumulative over (mu_in, line, azimuth and its end) and over (mu_in, line and its end).
    const std::vector<float>& samples() const noexcept { return density_; }
    const std::vector<float>& along_azimuth() const noexcept { return along_azimuth_; }
    const std::vector<float>& over_lines() const noexcept { return over_lines_; }

  private:
    struct LobeGrid;
    struct PeakedGrid;
    template <class Grid>
    struct SamplePlace;
    struct DrawnLine;
    template <class Grid>
    double fill(int channels, const Light& light);
    template <class Grid>
    float at(const SamplePlace<Grid>& place) const noexcept;
    template <class Grid, Side side>
    Direction draw(const DrawnLine& given) const noexcept;
    template <class Grid>
    Direction sample_grid(const Inclination& in, float u1, float u2, float u3) const noexcept;
    float lobe_pdf(Side side, const Inclination& in, const Inclination& out,
                   const HalfAzimuth& half) const noexcept;
    float peaked_pdf(Side side, const Inclination& in, const Inclination& out,
                     const HalfAzimuth& half) const noexcept;

    Peaks peaks_[2];  // over Side
    bool is_peaked_ = false;
    std::vector<float> density_;        // over (mu_in, line, azimuth); a line has one mu_out
    std::vector<float> along_azimuth_;  // cumulative, 0 to 1, in each line
    std::vector<float> over_lines_;     // cumulative, 0 to 1, for each mu_in
};

}  // namespace stratus
