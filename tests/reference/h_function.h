// Chandrasekhar's H function for isotropic scattering, from its own integral equation: independent
// of the solver in quadrature, equations and code.
//
//     1/H(mu) = sqrt(1 - w) + (w/2) int_0^1 mu' H(mu') / (mu + mu') dmu'          [C60] V, 36
#pragma once

#include <vector>

namespace stratus::test {

class HFunction {
  public:
    explicit HFunction(double albedo);

    /// H at a cosine in [0.01, 1], to 1e-13.
    double operator()(double mu) const;

    /// Integral of mu^order H over (0, 1), to 1e-13.
    double moment(int order) const;

  private:
    double albedo_;
    std::vector<double> mu_, weight_, H_;
};

}  // namespace stratus::test
