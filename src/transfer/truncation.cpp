#include <stratus/transfer/truncation.h>

namespace stratus {

double Truncation::optical_depth(double tau, double albedo) const {
    return (1 - albedo * fraction) * tau;
}

double Truncation::albedo(double albedo) const {
    return albedo * (1 - fraction) / (1 - albedo * fraction);
}

double Truncation::co_albedo(double albedo) const { return (1 - albedo) / (1 - albedo * fraction); }

double Truncation::single_scattering_albedo(double albedo) const {
    return albedo / (1 - albedo * fraction);
}

Truncation delta_m(const PhaseFunction& phase_function, int moment_count) {
    const auto L = static_cast<std::size_t>(moment_count);
    std::vector<double> moments = phase_function.moments(moment_count + 2);
    const double f = moments[L];
    const bool forward = f > 1e-15 && moments[L + 1] > 0;  // a backward peak alternates in sign
    moments.resize(L);
    if (!forward) return {0, std::move(moments)};
    for (double& chi : moments) chi = (chi - f) / (1 - f);
    return {f, std::move(moments)};
}

Truncation no_truncation(const PhaseFunction& phase_function, int moment_count) {
    return {0, phase_function.moments(moment_count)};
}

}  // namespace stratus
