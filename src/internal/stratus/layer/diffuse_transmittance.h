// Diffuse transmittance t: the share of a beam that leaves the far side of a layer scattered. By
// reciprocity it is also the share of a uniform background that reaches the viewer scattered; with
// the beam, exp(-tau/mu) + t of such a background is seen through the layer. At albedo 1 this and
// the plane albedo sum to 1.
#pragma once

#include <stratus/phase/phase_function.h>

#include <vector>

namespace stratus {

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
