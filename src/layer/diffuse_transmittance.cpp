#include <stratus/layer/diffuse_transmittance.h>

#include <stratus/base/gauss_legendre.h>
#include <stratus/layer/single_scattering.h>

#include <array>

namespace stratus {
namespace {

constexpr int moments = 64, nodes = 48;

/// P_0 .. P_moments-1, by upward recurrence.
using Legendre = std::array<double, moments>;

Legendre legendre(double x) noexcept {
    Legendre p{1, x};
    for (std::size_t l = 2; l < p.size(); ++l) {
        const auto n = static_cast<double>(l);
        p[l] = ((2 * n - 1) * x * p[l - 1] - (n - 1) * p[l - 2]) / n;
    }
    return p;
}

/// Gauss-Legendre on (0, 1).
struct Node {
    double mu, weight;
    Legendre legendre;
};

std::array<Node, nodes> gauss_nodes() {
    const GaussLegendre gauss(nodes);
    std::array<Node, nodes> rule;
    for (std::size_t i = 0; i < rule.size(); ++i) {
        const double mu = (1 + gauss.x[i]) / 2;
        rule[i] = {mu, gauss.weight[i] / 2, legendre(mu)};
    }
    return rule;
}

}  // namespace

SingleDiffuseTransmittance::SingleDiffuseTransmittance(const PhaseFunction& phase_function)
    : moment_(phase_function.moments(moments + 1)) {
    forward_peak_ = moment_.back();  // [W77]
    moment_.pop_back();
    for (std::size_t l = 0; l < moment_.size(); ++l)
        moment_[l] = static_cast<double>(2 * l + 1) * (moment_[l] - forward_peak_);
}

double SingleDiffuseTransmittance::operator()(double optical_depth, double mu,
                                              double below) const noexcept {
    static const std::array<Node, nodes> rule = gauss_nodes();
    Legendre series = legendre(mu);
    for (std::size_t l = 0; l < series.size(); ++l) series[l] *= moment_[l];
    double sum = 0;
    for (const Node& node : rule) {
        double phase = 0;  // its mean over azimuth
        for (std::size_t l = 0; l < series.size(); ++l) phase += series[l] * node.legendre[l];
        sum += node.weight * node.mu * direct_transmittance(below, node.mu) *
               single_transmission(phase, 1, optical_depth, mu, node.mu);
    }
    const double path = optical_depth / mu, beam = direct_transmittance(optical_depth + below, mu);
    return 2 * sum + (beam > 0 ? forward_peak_ * path * beam : 0);
}

}  // namespace stratus
