#include <stratus/phase/phase_curve.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

namespace stratus {
namespace {

constexpr int min_intervals = 256, max_intervals = 1 << 15;
constexpr double sampling_accuracy = 1e-6;  // of a value, half-way between samples

/// cos Theta at x in [0, 1] along the samples: sin(Theta/2 - pi/4) = sqrt(2) (x - 1/2).
double cos_theta_at(double x) {
    const double sine = std::clamp(std::sqrt(2.0) * (x - 0.5), -std::sqrt(0.5), std::sqrt(0.5));
    return -2 * sine * std::sqrt(1 - sine * sine);  // cos(2 asin(sine) + pi/2)
}

}  // namespace

PhaseCurve PhaseCurve::sampled(int width, const std::function<void(double, double*)>& value,
                               PhaseForm form) {
    const auto stride = static_cast<std::size_t>(width);
    std::vector<double> samples((min_intervals + 1) * stride);
    for (std::size_t i = 0; i <= min_intervals; ++i)
        value(cos_theta_at(static_cast<double>(i) / min_intervals), &samples[i * stride]);
    // Halving the intervals shows the error of straight lines.
    std::size_t intervals = min_intervals;
    for (bool straight = false; !straight && intervals < max_intervals; intervals *= 2) {
        straight = true;
        std::vector<double> finer((2 * intervals + 1) * stride);
        for (std::size_t i = 0; i <= intervals; ++i) {
            const double* const left = &samples[i * stride];
            std::copy(left, left + stride, &finer[2 * i * stride]);
            if (i == intervals) break;
            double* const middle = &finer[(2 * i + 1) * stride];
            value(cos_theta_at((static_cast<double>(i) + 0.5) / static_cast<double>(intervals)),
                  middle);
            for (std::size_t k = 0; k < stride; ++k)
                if (std::abs((left[k] + left[k + stride]) / 2 - middle[k]) >
                    4 * sampling_accuracy * std::abs(middle[k]))
                    straight = false;
        }
        samples = std::move(finer);
    }
    PhaseCurve curve;
    curve.form_ = form;
    curve.width_ = width;
    curve.samples_.assign(samples.begin(), samples.end());
    return curve;
}

PhaseCurve PhaseCurve::sampled(const PhaseFunction& phase_function) {
    return kept(phase_function.text(), [&] {
        return sampled(1, [&](double c, double* value) { *value = phase_function(c); });
    });
}

PhaseCurve PhaseCurve::kept(const std::string& text, const std::function<PhaseCurve()>& make) {
    constexpr std::size_t most_kept = 8;
    static std::mutex mutex;
    static std::deque<std::pair<std::string, PhaseCurve>> curves;  // by their text
    {
        const std::lock_guard<std::mutex> lock(mutex);
        for (const auto& [known, curve] : curves)
            if (known == text) return curve;
    }
    const PhaseCurve curve = make();
    const std::lock_guard<std::mutex> lock(mutex);
    curves.emplace_front(text, curve);
    if (curves.size() > most_kept) curves.pop_back();
    return curve;
}

PhaseCurve PhaseCurve::of_samples(std::vector<float> samples, int width) {
    PhaseCurve curve;
    curve.form_ = width == 1 ? PhaseForm::sampled : PhaseForm::with_boundary;
    curve.width_ = width;
    curve.samples_ = std::move(samples);
    return curve;
}

PhaseCurve::PhaseCurve(const PhaseFunction& phase_function) {
    double polynomial[3] = {0, 0, 0};
    int lobes = 0;
    bool closed = true;
    for (const auto& [weight, term] : phase_function.terms()) {
        const std::optional<PhaseClosedForm> form =
            std::visit([](const auto& kind) { return kind.closed_form(); }, term);
        closed = form && !(form->lobe_g && lobes == 2);
        if (!closed) break;
        for (int i = 0; i < 3; ++i) polynomial[i] += weight * form->polynomial[i];
        if (!form->lobe_g) continue;
        const double g = *form->lobe_g, size = std::abs(g);
        closed_.lobe[lobes++] = {static_cast<float>(weight * (1 - size) * (1 + size)),
                                 static_cast<float>((1 - size) * (1 - size)),
                                 static_cast<float>(std::max(0.0, 2 * g)),
                                 static_cast<float>(std::max(0.0, -2 * g))};
    }
    if (!closed) {
        *this = sampled(phase_function);
        return;
    }
    for (int i = 0; i < 3; ++i) closed_.polynomial[i] = static_cast<float>(polynomial[i]);
    const bool constant = polynomial[1] == 0 && polynomial[2] == 0;
    const PhaseForm forms[] = {constant ? PhaseForm::constant : PhaseForm::polynomial,
                               PhaseForm::one_lobe, PhaseForm::two_lobes};
    form_ = forms[lobes];
}

PhaseCurveView PhaseCurve::view() const noexcept {
    PhaseCurveView view = closed_;
    if (samples_.empty()) return view;
    view.sample = samples_.data();
    view.last = static_cast<int>(samples_.size()) / width_ - 1;
    return view;
}

}  // namespace stratus
