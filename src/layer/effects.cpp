#include <stratus/base/constants.h>
#include <stratus/base/gauss_legendre.h>
#include <stratus/base/number_text.h>
#include <stratus/layer/effects.h>

#include "kernels/closed_form.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace stratus {
namespace {

/// G(q) / pi.
double shared_volume(double q) noexcept {
    if (q >= 1) return 4 / (3 * pi);
    if (q < 1e-3) return q * (1 - q * (2 - q * q / 6) / pi);  // Taylor
    const double w = std::sqrt((1 - q) * (1 + q));
    return (2 * q * std::acos(q) - 2 * w + (4 + 2 * w * w * w) / 3) / pi;
}

/// n O of particles of one radius at one phase angle, and its integral over depth.
class ShadowOverlap {
  public:
    /// Range    radius over mean free path (0, inf); sine and cosine of half the phase angle,
    ///          [0, 1].
    ShadowOverlap(double radius, double sine, double cosine) noexcept
        : far_(radius / (sine * cosine)), near_(radius * sine / cosine) {}

    /// Range    u = 2 t / (mu0 + mu), [0, inf).
    double operator()(double u) const noexcept {
        const auto grown = [u](double scale) { return scale * shared_volume(u / scale); };
        if (std::isinf(near_)) return 0;  // a = pi
        const double all = std::isinf(far_) ? u : grown(far_);
        return near_ == 0 ? all : std::max(0.0, all - grown(near_));
    }

    /// 2 int exp(-2 v) (exp(n O(eta v)) - 1) dv, v = t (1/mu0 + 1/mu) / 2 from begin to end.
    ///
    /// Range    eta = 4 mu mu0 / (mu + mu0)^2, (0, 1]; 0 <= begin <= end <= inf.
    /// Accuracy 1e-8.
    double brightening(double eta, double begin, double end) const noexcept {
        constexpr double longest_panel = 1;
        constexpr double deepest = 40;  // n O <= v: exp(-40) is left out
        const double last = std::min(end, deepest);
        double sum = 0;
        // The overlap has two kinks, and is constant behind the second.
        const double kinks[] = {begin, std::clamp(near_ / eta, begin, std::max(begin, last)),
                                std::clamp(far_ / eta, begin, std::max(begin, last))};
        for (int part = 0; part < 2; ++part) {
            const double length = kinks[part + 1] - kinks[part];
            const int panels = static_cast<int>(std::ceil(length / longest_panel));
            const double half = length / panels / 2;
            for (int panel = 0; panel < panels; ++panel) {
                const double middle = kinks[part] + (2 * panel + 1) * half;
                for (int k = 0; k < 4; ++k)
                    for (const double side : {-1.0, 1.0}) {
                        const double v = middle + side * half * gauss_8_node[k];
                        sum += half * gauss_8_weight[k] * 2 * std::exp(-2 * v) *
                               std::expm1((*this)(eta * v));
                    }
            }
        }
        const double constant_from = kinks[2];
        if (constant_from < last)
            sum += std::expm1((*this)(eta * last)) *
                   (std::exp(-2 * constant_from) - std::exp(-2 * end));
        return sum;
    }

  private:
    double far_, near_;  // b1, inf at phase angle 0; b2
};

/// Sine or cosine of half the phase angle a = pi - Theta, from 1 + cos Theta or 1 - cos Theta.
double half_angle(double turn) noexcept { return std::sqrt(std::clamp(turn / 2, 0.0, 1.0)); }

double eta_along(double mu_in, double mu_out) noexcept {
    const double sum = mu_in + mu_out;
    return std::min(1.0, 4 * (mu_in / sum) * (mu_out / sum));
}

double hapke_bump(double width, double sine, double cosine) noexcept {
    return width * cosine / (width * cosine + sine);
}

double blinn_bump(double radius, double sine, double cosine, double optical_depth, double mu_in,
                  double mu_out) noexcept {
    const double depth = optical_depth * (1 / mu_in + 1 / mu_out) / 2;
    if (depth == 0) return 0;
    const ShadowOverlap overlap(radius, sine, cosine);
    return overlap.brightening(eta_along(mu_in, mu_out), 0, depth) / -std::expm1(-2 * depth);
}

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

Opposition Opposition::blinn(double density) {
    return {Law::blinn, radius_in_free_paths(density), 1};
}

Opposition Opposition::hapke(double amplitude, double width) {
    require_in("(0, inf)", "Opposition", "width", width);
    Opposition opposition = hapke(amplitude);
    opposition.width = width;
    return opposition;
}

Opposition Opposition::hapke(double amplitude) {
    require_in("[0, 1]", "Opposition", "amplitude", amplitude);
    return {Law::hapke, 0, amplitude};
}

double Opposition::radius_in_free_paths(double density) {
    require_in("(0, 1)", "Opposition", "density", density);
    return 0.75 * density;
}

double Opposition::width_of_density(double density) {
    require_in("(0, 1)", "Opposition", "density", density);
    return -0.375 * std::log1p(-density);
}

Opposition seen_opposition(const Opposition& opposition, double density) {
    Opposition seen = opposition;
    if (!seen.is_present()) return seen;
    const bool of_blinn = seen.law == Opposition::Law::blinn;
    if (seen.width == 0)
        seen.width = of_blinn ? Opposition::radius_in_free_paths(density)
                              : Opposition::width_of_density(density);
    if (of_blinn) seen.width /= 1 - density;
    return seen;
}

void check_opposition(const Opposition& opposition, double density, const char* caller) {
    if (!opposition.is_present()) return;
    require(opposition.width >= 0 && opposition.width < INFINITY &&
                (opposition.width > 0 || density > 0),
            caller, "opposition.width", "in (0, inf), or 0 with a density above 0",
            opposition.width);
    require_in("[0, 1]", caller, "opposition.amplitude", opposition.amplitude);
}

double opposition_factor(const Opposition& opposition, double cos_scattering_angle,
                         double optical_depth, double mu_in, double mu_out) noexcept {
    const double sine = half_angle(1 + cos_scattering_angle);
    const double cosine = half_angle(1 - cos_scattering_angle);
    switch (opposition.law) {
        case Opposition::Law::none: return 1;
        case Opposition::Law::blinn:
            return 1 + blinn_bump(opposition.width, sine, cosine, optical_depth, mu_in, mu_out);
        case Opposition::Law::hapke:
            return 1 + opposition.amplitude * hapke_bump(opposition.width, sine, cosine);
    }
    return 1;
}

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
    const PhaseAngle<float> angle(static_cast<float>(half_angle(1 + cos_scattering_angle)),
                                  static_cast<float>(half_angle(1 - cos_scattering_angle)));
    const double quarter = optical_depth * (1 / mu_in + 1 / mu_out) / 4;
    const float eta = static_cast<float>(eta_along(mu_in, mu_out));
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

double volume_fraction(double number_density, double radius) {
    constexpr const char* caller = "volume_fraction";
    require_in("[0, inf)", caller, "number_density", number_density);
    require_in("(0, inf)", caller, "radius", radius);
    const double density = number_density * (4 * pi / 3) * radius * radius * radius;
    require(density < 1, caller, "number_density * (4/3) pi radius^3", "in [0, 1)", density);
    return density;
}

double effective_optical_depth(double optical_depth, double density) noexcept {
    return optical_depth / (1 - density);
}

void check_effects(const Effects& effects) {
    require_in("[0, 1)", "Effects", "density", effects.density);
    if (!effects.opposition.is_present()) return;
    check_opposition(effects.opposition, effects.density, "Effects");
    require(effects.single, "Effects", "opposition", "none without single scattering", "a law");
}

}  // namespace stratus
