#include "h_function.h"

#include <cmath>

namespace stratus::test {

namespace {

// H behaves as mu log(mu) near 0, and 1/(mu + mu') varies there over a distance mu. The
// double-exponential rule, mu = 1 / (1 + exp(-pi sinh t)), is uniform in log(mu) at that end: the
// nearest singularity, mu' = -mu, stays pi / (pi cosh t) off the real axis, and a step of 1/64
// leaves exp(-2 pi 64 / cosh t), below rounding for all mu above exp(-30).
constexpr double step = 1.0 / 64;
constexpr int steps = 192;  // to t = 3: mu = 2e-14, weighted by mu'

// In the mean of log H and its image every error shrinks to half or less: the linearised map has
// its eigenvalues in [-1, 0].
constexpr int iterations = 70;

}  // namespace

HFunction::HFunction(double albedo) : albedo_(albedo) {
    const double pi = std::acos(-1.0);
    for (int i = -steps; i <= steps; ++i) {
        const double t = i * step, e = std::exp(-pi * std::sinh(t));
        mu_.push_back(1 / (1 + e));
        weight_.push_back(step * pi * std::cosh(t) * e / ((1 + e) * (1 + e)));
    }
    H_.assign(mu_.size(), 1);
    for (int n = 0; n < iterations; ++n) {
        std::vector<double> next;
        for (std::size_t i = 0; i < mu_.size(); ++i)
            next.push_back(std::sqrt(H_[i] * (*this)(mu_[i])));
        H_ = next;
    }
}

double HFunction::operator()(double mu) const {
    double sum = 0;
    for (std::size_t i = 0; i < mu_.size(); ++i) sum += weight_[i] * mu_[i] * H_[i] / (mu + mu_[i]);
    return 1 / (std::sqrt(1 - albedo_) + albedo_ / 2 * sum);
}

double HFunction::moment(int order) const {
    double sum = 0;
    for (std::size_t i = 0; i < mu_.size(); ++i)
        sum += weight_[i] * std::pow(mu_[i], order) * H_[i];
    return sum;
}

}  // namespace stratus::test
