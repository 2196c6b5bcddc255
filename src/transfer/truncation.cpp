#include <stratus/transfer/truncation.h>

#include <algorithm>
#include <cmath>

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

namespace {

/// Truncated share up to which delta-M's abrupt end does less harm than inexact moments.
constexpr double smooth_share = 1e-4;

/// That share of a backward peak, which is seen beside what is scattered forward, the least of all.
constexpr double smooth_share_backward = 1e-7;

/// True where moments beyond 32 show, and are those of a backward peak, which alternate in sign:
/// Henyey-Greenstein from g = -0.84 on. As has_narrow_peak (path_law.h).
bool has_narrow_backward_peak(const PhaseFunction& phase_function) {
    constexpr int resolved = 32;
    constexpr double least_peak = 0.2;
    const std::vector<double> first = phase_function.moments(resolved + 2);
    return std::abs(first[resolved]) * (2 * resolved + 1) >= least_peak &&
           first[resolved] * first[resolved + 1] < 0;
}

/// 1 up to x = 0, 0 from x = 1 on, smooth to the second derivative.
double smooth_end(double x) {
    const double u = std::clamp(x, 0.0, 1.0);
    return 1 - u * u * u * (10 + u * (6 * u - 15));
}

/// max(x, 0), its corner between -width and width replaced by the quartic that matches both sides
/// to the second derivative: exactly 0 at x = -width.
double rounded_off(double x, double width) {
    if (std::abs(x) >= width) return std::max(x, 0.0);
    const double u = x / width;
    return width * (u + 1) * (u + 1) * (u + 1) * (3 - u) / 16;
}

}  // namespace

Truncation truncate_peak(const PhaseFunction& phase_function, int moment_count, bool delta_m) {
    const auto L = static_cast<std::size_t>(moment_count);
    std::vector<double> moments = phase_function.moments(moment_count + 2);
    const double last = moments[L];
    const bool forward = last > 1e-15 && moments[L + 1] > 0;  // a backward peak alternates in sign
    const bool backward = std::abs(last) > smooth_share_backward && last * moments[L + 1] < 0 &&
                          has_narrow_backward_peak(phase_function);
    // A large share is chi_l somewhat below L: 0.8 to 0.9 of it do about equally well.
    const auto knee = static_cast<std::size_t>(std::lround(0.85 * moment_count));
    const double f = !delta_m && last > smooth_share ? std::max(moments[knee], last) : last;
    moments.resize(L);
    if (backward)
        for (std::size_t l = 0; l < L; ++l)
            moments[l] *= smooth_end((static_cast<double>(l) / moment_count - 0.4) / 0.6);
    if (!forward) return {0, std::move(moments), false, backward};
    for (std::size_t l = 0; l < L; ++l) {
        const double excess = (moments[l] - f) / (1 - f), blend = (f - last) / (1 - f);
        moments[l] = 2 * l < knee || f == last ? excess : rounded_off(excess, blend);
    }
    return {f, std::move(moments), f > last};
}

Truncation no_truncation(const PhaseFunction& phase_function, int moment_count) {
    return {0, phase_function.moments(moment_count)};
}

}  // namespace stratus
