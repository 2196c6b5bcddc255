#include <stratus/layer/opposition.h>

#include "kernels/opposition_values.h"
#include "shadow_overlap.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace stratus {
namespace {

using View = OppositionTableView;

/// sin and cos of half the angle where a sample lies.
PhaseAngle<float> sampled_angle(const View& table, int sample) {
    if (sample == 0) return {0.0f, 1.0f};
    const auto at = [](double half_angle) {
        return PhaseAngle<float>(static_cast<float>(std::sin(half_angle)),
                                 static_cast<float>(std::cos(half_angle)));
    };
    const double place = static_cast<double>(sample) / (View::angles - 1);
    // From narrow angles up, by halving their logarithm.
    double low = std::log(1e-20), high = std::log(std::acos(0.0) * (1 - 1e-5));
    for (int halving = 0; halving < 60; ++halving) {
        const double middle = (low + high) / 2;
        const bool below = double{angle_place(table, at(std::exp(middle)))} < place;
        (below ? low : high) = middle;
    }
    return at(std::exp(low));
}

/// v of a sample along depth.
double sampled_depth(int sample) {
    const double root = static_cast<double>(sample) / (View::depths - 1);
    return 4 * std::atanh(root * root);
}

/// S over depth at one angle and eta.
void sample_depths(const View& table, const PhaseAngle<float>& angle, double eta, float* sample) {
    const ShadowOverlap overlap(double{table.radius}, double{angle.sine}, double{angle.cosine});
    double sum = 0, before = 0;
    for (int j = 0; j < View::depths; ++j) {
        // S has a limit at depth 0, reached here to 1e-4 of it.
        const double depth = j == 0 ? 1e-4 : sampled_depth(j);
        sum += overlap.brightening(eta, before, depth);
        before = depth;
        const float limits = opposition_limits(table, angle, static_cast<float>(eta),
                                               static_cast<float>(std::tanh(depth / 2)));
        const double bump = sum / -std::expm1(-2 * depth);
        sample[j * View::etas] = limits > 0 ? static_cast<float>(bump / double{limits}) : 0;
    }
}

}  // namespace

OppositionTable::OppositionTable(const Opposition& opposition) : opposition_(opposition) {
    check_opposition(opposition, 0, "OppositionTable");
    if (opposition.law != Opposition::Law::blinn) return;
    samples_.resize(std::size_t{View::angles} * View::depths * View::etas);
    const View table = view();
    for (int i = 0; i < View::angles; ++i) {
        const PhaseAngle<float> angle = sampled_angle(table, i);
        for (int k = 0; k < View::etas; ++k) {
            const double root = std::max(static_cast<double>(k) / (View::etas - 1), 1e-3);
            sample_depths(table, angle, root * root,
                          &samples_[static_cast<std::size_t>(i * View::depths * View::etas + k)]);
        }
    }
}

double OppositionTable::factor(double cos_scattering_angle, double optical_depth, double mu_in,
                               double mu_out) const noexcept {
    if (samples_.empty())
        return opposition_factor(opposition_, cos_scattering_angle, optical_depth, mu_in, mu_out);
    const auto root = [](double x) {
        return static_cast<float>(std::sqrt(std::clamp(x / 2, 0.0, 1.0)));
    };
    const PhaseAngle<float> angle(root(1 + cos_scattering_angle), root(1 - cos_scattering_angle));
    const double sum = mu_in + mu_out, quarter = optical_depth * (1 / mu_in + 1 / mu_out) / 4;
    const float eta = static_cast<float>(std::min(1.0, 4 * (mu_in / sum) * (mu_out / sum)));
    const Attenuation<float> at{static_cast<float>(std::exp(-quarter)),
                                static_cast<float>(-std::expm1(-quarter))};
    return 1 + double{opposition_bump(view(), angle, eta, at)};
}

OppositionTableView OppositionTable::view() const noexcept {
    View table;
    table.sample = samples_.data();
    // Narrower peaks than any angle in single precision look the same.
    const double radius = std::max(opposition_.width, 1e-12);
    table.radius = static_cast<float>(radius);
    table.angle_scale =
        static_cast<float>(double{overlap_scale} * radius / (1 + 2 * radius * radius));
    return table;
}

}  // namespace stratus
