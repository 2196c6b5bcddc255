// The overlap of the ways in and out of a layer, and its integral over depth (opposition.h).
#pragma once

namespace stratus {

/// n O of particles of one radius at one phase angle.
class ShadowOverlap {
  public:
    /// Range    radius over mean free path (0, inf); sine and cosine of half the phase angle,
    ///          [0, 1].
    ShadowOverlap(double radius, double sine, double cosine) noexcept;

    /// Range    u = 2 t / (mu0 + mu), [0, inf).
    double operator()(double u) const noexcept;

    /// 2 int exp(-2 v) (exp(n O(eta v)) - 1) dv, v = t (1/mu0 + 1/mu) / 2 from begin to end.
    ///
    /// Range    eta = 4 mu mu0 / (mu + mu0)^2, (0, 1]; 0 <= begin <= end <= inf.
    /// Accuracy 1e-8.
    double brightening(double eta, double begin, double end) const noexcept;

  private:
    double far_, near_;  // b1, inf at phase angle 0; b2
};

}  // namespace stratus
