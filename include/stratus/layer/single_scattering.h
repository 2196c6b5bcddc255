// Single scattering in closed form: a plane-parallel layer lit by a beam, light scattered exactly
// once.
//
// Follows [Blinn82] sections 2.4 to 2.7 in the normalisation of this project: R = pi I / (mu0 F0),
// so that a white Lambert surface has R = 1, a BRDF is R / pi, and Blinn's brightness is
// B = 4 mu0 R. mu0 (`mu_in`) and mu (`mu_out`) are cosines in (0, 1]; the function's name says
// which side. `azimuth` is between the two directions of *propagation*, 0 = forward side.
// Optical depth may be infinity. Not-a-number gives not-a-number; nothing is brought into its range,
// for delta-M [W77] asks for albedos above 1. Lookups of tables and slices do that (lookup.h).
#pragma once

#include <stratus/base/direction.h>
#include <stratus/phase/phase_function.h>

#include <vector>

namespace stratus {

/// R of order 1, (w/4) phi (1 - exp(-tau (1/mu + 1/mu0))) / (mu + mu0). [Blinn82] 2.4, top lit
///
/// Range    albedo [0, 1], optical_depth [0, inf], cosines (0, 1]; `phase_value` = phi(Theta).
/// Accuracy 1e-15 relative for thin layers too (expm1).
double single_reflection(double phase_value, double albedo, double optical_depth, double mu_in,
                         double mu_out) noexcept;

/// T of order 1 (diffuse), (w/4) phi (exp(-tau/mu0) - exp(-tau/mu)) / (mu0 - mu). [Blinn82] 2.4,
/// bottom lit
///
/// Regular at mu = mu0, where it is (w/4) phi (tau/mu^2) exp(-tau/mu); 0 at infinite depth.
double single_transmission(double phase_value, double albedo, double optical_depth, double mu_in,
                           double mu_out) noexcept;

/// R or diffuse T of order 1, by the side.
double single_scattering(Side side, double phase_value, double albedo, double optical_depth,
                         double mu_in, double mu_out) noexcept;

/// The unscattered beam, exp(-tau / mu).
double direct_transmittance(double optical_depth, double mu) noexcept;

/// The share of a beam that a layer extinguishes, 1 - exp(-tau / mu), exact for thin layers too.
double intercepted_share(double optical_depth, double mu) noexcept;

/// A small bright source straight behind the layer, as [Blinn82] 2.5 has it: the beam exp(-tau/mu)
/// and the light scattered forward once, w phi(Theta = 0) (tau/mu) exp(-tau/mu). The latter is
/// radiance for each steradian of the source, so the sum is no share and may exceed 1; a uniform
/// background is SliceOf::background.
///
/// The paper adds the constant w phi, which would not vanish for an empty layer; this is the limit
/// of its own bottom-lit formula at mu = mu0 (B with F0 = 1).
double source_seen_through(double forward_phase_value, double albedo, double optical_depth,
                           double mu) noexcept;

// Diffuse transmittance t: the share of a beam that leaves the far side of a layer scattered. By
// reciprocity it is also the share of a uniform background that reaches the viewer scattered; with
// the beam, exp(-tau/mu) + t of such a background is seen through the layer. At albedo 1 this and
// the plane albedo sum to 1.

/// t of order 1 for any layer of one phase function: (1/pi) times the integral of T mu over the
/// hemisphere, T of order 1 [Blinn82] 2.4. The azimuth average of phi is its Legendre series, cut
/// short as in delta-M [W77].
class SingleDiffuseTransmittance {
  public:
    explicit SingleDiffuseTransmittance(const PhaseFunction& phase_function);

    /// At albedo 1; in proportion to the albedo otherwise. `below`: the optical depth of what
    /// attenuates the light that has left the layer.
    ///
    /// Range    optical_depth [0, inf], mu (0, 1], below [0, inf).
    /// Accuracy 1e-4 absolute to asymmetry 0.9; of sharper peaks at mu < 0.1 up to 1e-2.
    /// Cost     some microseconds.
    double operator()(double optical_depth, double mu, double below = 0) const noexcept;

  private:
    double forward_peak_;         // scattered by less than the moments resolve
    std::vector<double> moment_;  // of the rest, times 2 l + 1
};

}  // namespace stratus
