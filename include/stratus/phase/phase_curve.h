// A phase function in single precision, as fast lookups evaluate it: a polynomial and up to two
// Henyey-Greenstein lobes where it consists of no more, samples otherwise.
//
// The arguments are y = 1 - cos Theta and 1 + cos Theta, each accurate in the peak where it is
// small. Samples lie uniformly over (1 + sin(Theta/2) - cos(Theta/2)) / 2, nearly
// the angle itself, and are joined linearly.
#pragma once

#include <stratus/phase/phase_function.h>

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace stratus {

/// scale / (offset + forward (1 - cos Theta) + backward (1 + cos Theta))^(3/2).
struct PhaseLobe {
    float scale, offset, forward, backward;
};

/// The samples that a fast lookup reads; trivially copyable.
struct PhaseCurveView {
    float polynomial[3] = {0, 0, 0};  // in y
    PhaseLobe lobe[2] = {{0, 1, 0, 0}, {0, 1, 0, 0}};
    int last = 0;                   // index of the last sample
    const float* sample = nullptr;  // null: polynomial and lobes alone
};

/// How a lookup finds its phase function.
enum class PhaseForm {
    none,        // single scattering is not asked for
    constant,    // isotropic
    polynomial,  // in cos Theta
    one_lobe,    // a polynomial and a Henyey-Greenstein lobe
    two_lobes,
    sampled,
    // Reflection alone: side by side with the phase function of a layer that is the lower boundary.
    with_boundary,
    with_opposition_and_boundary,  // the same, times Blinn's opposition (effects.h)
    of_stack,                      // samples of each of its layers' own
};
constexpr int phase_forms = 9;

/// A phase function made ready for fast lookups.
class PhaseCurve {
  public:
    /// Isotropic.
    PhaseCurve() : PhaseCurve(PhaseFunction()) {}

    /// Closed form where all terms have one; samples of the whole function otherwise.
    ///
    /// Accuracy 1e-6 of the value, or what 32,768 intervals give where a peak is too narrow.
    explicit PhaseCurve(const PhaseFunction& phase_function);

    /// Samples of any function of cos Theta, of several side by side: value(cos, out) writes
    /// `width` of them.
    static PhaseCurve sampled(int width,
                              const std::function<void(double cos_theta, double* value)>& value,
                              PhaseForm form = PhaseForm::sampled);

    /// Samples of a whole phase function, even where it has a closed form.
    static PhaseCurve sampled(const PhaseFunction& phase_function);

    /// The curve that `make` samples, which `text` tells from all others. The latest ones are kept: a table, its file
    /// and every light of a picture take the same ones.
    static PhaseCurve kept(const std::string& text, const std::function<PhaseCurve()>& make);

    PhaseCurveView view() const noexcept;

    /// One that was sampled before: samples over (place, function), of one function or, with a
    /// layer as the lower boundary, two.
    ///
    /// Range    at least two places; width 1 or 2.
    static PhaseCurve of_samples(std::vector<float> samples, int width);

    PhaseForm form() const noexcept { return form_; }

    /// Functions side by side.
    int width() const noexcept { return width_; }

    std::size_t sample_count() const noexcept { return samples_.size(); }

  private:
    PhaseCurveView closed_;
    PhaseForm form_ = PhaseForm::polynomial;
    std::vector<float> samples_;
    int width_ = 1;
};

}  // namespace stratus
