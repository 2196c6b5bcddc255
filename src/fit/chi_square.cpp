#include "chi_square.h"

#include <cmath>
#include <numbers>

namespace stratus {

// Q(a + 1, x) = Q(a, x) + x^a e^-x / Gamma(a + 1), from Q(1/2, x) = erfc(sqrt x) or Q(1, x) = e^-x.
double chi_square_probability(double chi_square, int degrees_of_freedom) noexcept {
    const double x = chi_square / 2;
    if (x == 0) return 1;
    if (std::isinf(x)) return 0;
    const bool odd = degrees_of_freedom % 2 == 1;
    double a = odd ? 0.5 : 1;
    double probability = odd ? std::erfc(std::sqrt(x)) : std::exp(-x);
    const double log_gamma = odd ? std::log(std::numbers::pi) / 2 - std::numbers::ln2 : 0;
    double log_term = a * std::log(x) - x - log_gamma;  // x^a e^-x / Gamma(a + 1)
    for (; a < degrees_of_freedom / 2.0; a += 1) {
        probability += std::exp(log_term);
        log_term += std::log(x / (a + 1));
    }
    return std::fmin(probability, 1);
}

}  // namespace stratus
