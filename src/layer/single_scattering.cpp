#include <stratus/layer/single_scattering.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

/// (1 - exp(-z)) / z for z >= 0, 1 at z = 0.
double mean_of_exponential(double z) noexcept { return z == 0 ? 1 : -std::expm1(-z) / z; }

}  // namespace

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

}  // namespace stratus
