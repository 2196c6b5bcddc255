// Grounds that are no Lambert surface: wind-ruffled water, and the law of Rahman, Pinty and
// Verstraete for soil and plants.
//
// R is normalised as everywhere: 1 of a white Lambert surface, so that a BRDF is R / pi. All laws
// are reciprocal, and none reflects more than it receives.
#pragma once

#include <stratus/base/direction.h>

#include <memory>
#include <string>
#include <vector>

namespace stratus {

class GroundLaw {
  public:
    virtual ~GroundLaw() = default;

    /// R of the ground.
    ///
    /// Range    cosines (0, 1]; azimuth 0 is the forward side, that of the mirrored sun.
    virtual double operator()(const Geometry& geometry) const noexcept = 0;

    /// Returns the same of one pair of cosines at several azimuths, to `R`: laws that share work between
    /// these are faster.
    virtual void at_azimuths(double mu_in, double mu_out, const std::vector<double>& azimuths,
                             double* R) const noexcept;

    /// Reads back as this law, but that of a table.
    virtual std::string text() const = 0;
};

/// Reads `ocean:wind=W,index=N,albedo=A` or `rpv:rho0=R,k=K,theta=T,rho_c=C`.
///
/// ocean    facets whose slopes are normally distributed, of variance 0.003 + 0.00512 W, W the wind
///          in m/s 12.5 m above the sea (Cox and Munk 1954, without the wind's direction), which
///          mirror after Fresnel and shade each other after Smith, heights correlated:
///          R = F exp(-tan^2 b / v) / (4 v mu mu0 cos^4 b (1 + L(mu) + L(mu0))), b the tilt of the
///          facet and v the variance. `albedo` is a Lambert part, of foam and of light from below.
/// rpv      R = rho0 (mu mu0 (mu + mu0))^(k-1) (1 - T^2) / (1 + 2 T cos g + T^2)^(3/2)
///          (1 + (1 - rho_c) / (1 + G)), g the phase angle, G^2 = tan^2 i + tan^2 e
///          - 2 tan i tan e cos(azimuth between sun and eye) (Rahman, Pinty and Verstraete 1993).
///          Cosines below that at which it would reflect more than it receives count as that, and
///          as 1e-6 at least; where that is above 0.2, the law is refused.
/// Range    wind [0, 50], index [1, 3], by default 1.34, albedo [0, 1], by default 0; rho0 [0, 1],
///          k [0, 2], theta (-1, 1), rho_c [0, 1], by default rho0.
/// Errors   std::invalid_argument naming the argument; also where the law reflects more than it
///          receives otherwise.
std::shared_ptr<const GroundLaw> read_ground_law(const std::string& text);

/// The laws and their parameters, for `--help`.
std::string ground_law_help();

/// Modes of R over azimuth, R = R_0 + 2 sum R_m cos(m azimuth), by Gauss quadrature in intervals
/// that halve towards both ends.
class AzimuthalModes {
  public:
    /// For modes `first` to before `end`.
    AzimuthalModes(int first, int end);

    /// Returns these modes of a pair of cosines.
    ///
    /// Accuracy 1e-9 of R_0 (tests/layer) where peaks are wider than 1e-4 radians.
    std::vector<double> operator()(const GroundLaw& law, double mu_in, double mu_out) const;

  private:
    std::size_t count_;
    std::vector<double> azimuth_;
    std::vector<double> share_;  // of R at an azimuth in a mode: over (azimuth, mode)
};

/// The share of light at one cosine that the ground reflects.
double plane_albedo(const GroundLaw& law, double mu_in);

/// The share under uniform illumination.
double spherical_albedo(const GroundLaw& law);

}  // namespace stratus
