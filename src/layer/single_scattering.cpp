#include <stratus/layer/single_scattering.h>

#include <stratus/base/gauss_legendre.h>
#include <stratus/layer/diffusion.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace stratus {
double single_reflection(double phase_value, double albedo, double optical_depth, double mu_in,
                         double mu_out) noexcept {
    const double path = optical_depth * (1 / mu_in + 1 / mu_out);
    return albedo / 4 * phase_value * -std::expm1(-path) / (mu_in + mu_out);  // [Blinn82] 2.4
}

double single_transmission(double phase_value, double albedo, double optical_depth, double mu_in,
                           double mu_out) noexcept {
    // The beam that decays more slowly is taken out of the difference of [Blinn82] 2.4; what is
    // left, (1 - exp(-z)) / z, is regular at equal cosines.
    const double steep = std::max(mu_in, mu_out);  // not-a-number stays in one of both
    const double shallow = std::min(mu_out, mu_in);
    const double beam = std::exp(-optical_depth / steep);
    if (beam == 0)  // infinite depth, and every depth that transmits nothing
        return 0 * (phase_value * albedo * shallow);
    const double z = optical_depth * ((steep - shallow) / (steep * shallow));
    return albedo / 4 * phase_value * (beam * optical_depth) * mean_of_exponential(z) /
           (steep * shallow);
}

double single_scattering(Side side, double phase_value, double albedo, double optical_depth,
                         double mu_in, double mu_out) noexcept {
    return (side == Side::reflection ? single_reflection : single_transmission)(
        phase_value, albedo, optical_depth, mu_in, mu_out);
}

double direct_transmittance(double optical_depth, double mu) noexcept {
    return std::exp(-optical_depth / mu);
}

double intercepted_share(double optical_depth, double mu) noexcept {
    return -std::expm1(-optical_depth / mu);
}

double source_seen_through(double forward_phase_value, double albedo, double optical_depth,
                           double mu) noexcept {
    const double path = optical_depth / mu;
    const double beam = std::exp(-path);
    if (beam == 0) return 0 * (albedo * forward_phase_value);  // infinite depth
    return beam + albedo * forward_phase_value * path * beam;  // [Blinn82] 2.5
}

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
