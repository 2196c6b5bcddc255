#include "photon_path.h"

#include <stratus/base/constants.h>

#include <algorithm>
#include <cmath>
#include <variant>

namespace stratus {

namespace {

constexpr std::size_t intervals_per_moment = 32, min_intervals = 4096;

/// cos Theta at x: sin(Theta/2 - pi/4) = sqrt(2) (x - 1/2), beyond [0, 1] too, where Theta turns
/// back.
double cos_theta_at(double x) {
    const double sine = std::sqrt(2.0) * (x - 0.5);
    return -2 * sine * std::sqrt((1 - sine) * (1 + sine));
}

}  // namespace

PhaseValues::PhaseValues(const PhaseFunction& phase_function) : closed_(phase_function) {
    std::vector<std::pair<double, PhaseFunction>> closed, series;
    std::size_t moments = 0;
    for (const auto& [weight, term] : phase_function.terms()) {
        const auto* const chi = std::get_if<Moments>(&term);
        (chi != nullptr ? series : closed).emplace_back(weight, PhaseFunction(term));
        if (chi != nullptr) moments = std::max(moments, chi->chi.size());
    }
    if (series.empty()) return;
    closed_share_ = 0;
    for (const auto& [weight, part] : closed) closed_share_ += weight;
    closed_ = closed.empty() ? PhaseFunction() : PhaseFunction::sum(closed);
    const std::size_t intervals = std::max(min_intervals, intervals_per_moment * moments);
    intervals_ = static_cast<double>(intervals);
    for (std::size_t i = 0; i <= intervals + 2; ++i) {
        const double cosine = cos_theta_at((static_cast<double>(i) - 1) / intervals_);
        double sum = 0;
        for (const auto& [weight, part] : series) sum += weight * part(cosine);
        sample_.push_back(sum);
    }
}

double PhaseValues::operator()(double cos_scattering_angle) const noexcept {
    if (sample_.empty()) return closed_(cos_scattering_angle);
    const double sum = series(cos_scattering_angle);
    return closed_share_ > 0 ? sum + closed_share_ * closed_(cos_scattering_angle) : sum;
}

double PhaseValues::series(double cos_scattering_angle) const noexcept {
    const double c = std::clamp(cos_scattering_angle, -1.0, 1.0);
    const double x = 0.5 + (std::sqrt((1 - c) / 2) - std::sqrt((1 + c) / 2)) / 2;
    const double place = x * intervals_;
    const double start = std::clamp(std::floor(place), 0.0, intervals_ - 1);
    const double* const at = &sample_[static_cast<std::size_t>(start)];
    // Lagrange's cubic through the points -1, 0, 1, 2.
    const double u = place - start, before = u + 1, next = u - 1, after = u - 2;
    return (3 * before * after * (next * at[1] - u * at[2]) +
            u * next * (before * at[3] - after * at[0])) /
           6;
}

AngleSampler::AngleSampler(const PhaseValues& phase) {
    // Steps of 2 % from 1e-5 on resolve peaks of g = 0.9999, steps of pi/1024 the rest; the
    // backward half mirrors the forward one.
    std::vector<double> angles{0};
    double angle = 1e-5;
    while (angle < pi / 2) {
        angles.push_back(angle);
        angle += std::min(0.02 * angle, pi / 1024);
    }
    for (std::size_t i = angles.size(); i-- > 0;) angles.push_back(pi - angles[i]);
    for (const double turn : angles) {
        v_.push_back(std::pow(std::sin(turn / 2), 2));
        height_.push_back(std::max(min_height, std::abs(phase(std::cos(turn)))));
        if (v_.size() == 1) continue;
        const std::size_t i = v_.size() - 2;
        cumulative_.push_back((cumulative_.empty() ? 0 : cumulative_.back()) +
                              (v_[i + 1] - v_[i]) * (height_[i] + height_[i + 1]) / 2);
    }
    const double mean = cumulative_.back();
    for (double& height : height_) height /= mean;
    for (double& integral : cumulative_) integral /= mean;
    first_.resize(cumulative_.size());
    for (std::size_t i = 0, bin = 0; i < first_.size(); ++i) {
        while (cumulative_[bin] <= static_cast<double>(i) / static_cast<double>(first_.size()))
            ++bin;
        first_[i] = bin;
    }
}

AngleSampler::Sample AngleSampler::sample(double bin_number, double place) const noexcept {
    std::size_t i =
        first_[static_cast<std::size_t>(bin_number * static_cast<double>(first_.size()))];
    while (i + 1 < cumulative_.size() && cumulative_[i] <= bin_number) ++i;
    // Within the bin the density is a + (b - a) x: invert a x + (b - a) x^2/2 = u (a + b)/2.
    const double a = height_[i], b = height_[i + 1], u = place;
    const double x = u * (a + b) / (a + std::sqrt(a * a + u * (b - a) * (b + a)));
    return {v_[i] + x * (v_[i + 1] - v_[i]), a + x * (b - a)};
}

double AngleSampler::density(double v) const noexcept {
    const auto end = std::upper_bound(v_.begin() + 1, v_.end() - 1, v);
    const auto i = static_cast<std::size_t>(end - v_.begin()) - 1;
    const double x = (v - v_[i]) / (v_[i + 1] - v_[i]);
    return height_[i] + x * (height_[i + 1] - height_[i]);
}

}  // namespace stratus
