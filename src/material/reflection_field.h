// R of one colour at any geometry, from a solution at cosines that are dense everywhere: single
// scattering in closed form, the rest by polynomials through six samples of cosine and azimuth.
#pragma once

#include "solved_stack.h"

#include <vector>

namespace stratus {

/// Single scattering of a stack lit from above, its ground included.
double single_reflection(const Stack& stack, const Geometry& geometry);

class ReflectionField {
  public:
    /// Cosines even in s = (2/pi asin(mu))^(2/3), of [0, 1], `count` of them: for solutions that
    /// this is made of. The first stands for the limit 0.
    static std::vector<double> cosines(int count);

    /// Takes a solution at `cosines(count)`.
    ReflectionField(const Stack& stack, const SolvedStack& solved, const std::vector<double>& mu,
                    int threads);

    /// R with mu_out the cosine of place `out`, any mu_in of [0, 1], azimuth of [0, pi].
    double operator()(double mu_in, int out, double azimuth) const;

  private:
    static constexpr int azimuth_intervals = 128;

    const Stack& stack_;
    const std::vector<double>& mu_;
    std::vector<double> rest_;  // orders n >= 2 over (out, in, azimuth)
};

}  // namespace stratus
