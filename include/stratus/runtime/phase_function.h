// Phase functions: value, Legendre moments and text form of every one that Stratus knows, and their
// weighted sums.
//
// Normalised to spherical mean 1 (isotropic = 1), as in [Blinn82] and [HT74]; a renderer's value
// per steradian is phi / (4 pi). The argument is the cosine of the *scattering* angle Theta, +1
// straight on; the phase angle of [Blinn82] is a = pi - Theta. g is the mean of cos Theta, positive
// for forward scattering: the opposite of [Blinn82].
//
//     phi(cos Theta) = sum over l of (2 l + 1) chi_l P_l(cos Theta),   chi_0 = 1,  chi_1 = g
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace stratus {

struct Isotropic {};

/// 3/4 (1 + cos^2 Theta). [Blinn82] 3.4
struct Rayleigh {};

/// 1 + x cos a = 1 - x cos Theta, |x| <= 1. [Blinn82] 3.2
struct Anisotropic {
    double x;
};

/// A sphere whose surface obeys Lambert's law: (8 / 3 pi) (sin a + (pi - a) cos a). [Blinn82] 3.3
struct LambertSphere {};

/// (1 - g^2) / (1 + g^2 - 2 g cos Theta)^(3/2), |g| < 1. [Blinn82] 3.5
struct HenyeyGreenstein {
    double g;
};

/// Measured values at phase angles (degrees), joined by monotone cubics in the phase angle (Fritsch
/// and Carlson 1980: no overshoot, so never negative) and scaled to mean 1.
struct Tabulated {
    std::vector<double> phase_angle_deg;  // as given, ascending from 0 to 180
    std::vector<double> value;            // as given
    std::vector<double> slope;            // d(value)/d(angle) at the knots, per radian
    double normalisation;                 // value * normalisation has spherical mean 1
};

/// A phase function given by its Legendre moments alone.
struct Moments {
    std::vector<double> chi;  // chi[0] = 1
};

/// Any phase function: a weighted sum of terms, weights summing to 1.
class PhaseFunction {
  public:
    using Term = std::variant<Isotropic, Rayleigh, Anisotropic, LambertSphere, HenyeyGreenstein,
                              Tabulated, Moments>;

    /// Isotropic.
    PhaseFunction();

    // One named maker each; std::invalid_argument naming the allowed range otherwise.
    static PhaseFunction isotropic();
    static PhaseFunction rayleigh();
    static PhaseFunction anisotropic(double x);
    static PhaseFunction lambert_sphere();
    static PhaseFunction henyey_greenstein(double g);
    /// At least 3 rows, angles strictly ascending from 0 to 180, values finite, >= 0 and not all 0.
    static PhaseFunction tabulated(std::vector<double> phase_angle_deg, std::vector<double> value);
    /// chi_0 = 1 (1e-6; all are divided by it), |chi_l| <= 1, and the sum not below -1e-3 of its
    /// largest value anywhere: a series cut short may dip that far, and its values are returned as
    /// they are.
    static PhaseFunction from_moments(std::vector<double> chi);
    /// Weights >= 0 with a positive sum; they are divided by it. Sums of sums are flattened,
    /// weights of 0 left out.
    static PhaseFunction sum(const std::vector<std::pair<double, PhaseFunction>>& parts);
    /// f * first + (1 - f) * second, f = share_of_first in [0, 1].
    static PhaseFunction mixture(double share_of_first, const PhaseFunction& first,
                                 const PhaseFunction& second);

    /// phi at a scattering angle, mean 1 over the sphere.
    ///
    /// Range    cos_scattering_angle in [-1, 1]; rounding beyond is accepted.
    /// Threads  safe; allocates nothing, throws nothing.
    double operator()(double cos_scattering_angle) const noexcept;

    /// The first `count` Legendre moments chi_0 .. chi_{count-1}.
    ///
    /// Accuracy 1e-13 absolute: closed forms, piecewise Gauss quadrature for tabulated values.
    /// Errors   std::invalid_argument for a count below 1.
    std::vector<double> moments(int count) const;

    /// Mean cosine of the scattering angle, chi_1.
    double asymmetry() const;

    /// True when phi is 1 everywhere, so that nothing depends on azimuth.
    bool is_isotropic() const noexcept;

    /// The text that `parse_phase_function` turns into this same function, bit for bit, with no
    /// file at hand: the grammar below, numbers with as many digits as it takes to read them back,
    /// and `tabulated:points=0 3.5/10 2.25/...` or `moments:chi=1 0.75 ...` in place of file names.
    std::string text() const;

    const std::vector<std::pair<double, Term>>& terms() const noexcept { return terms_; }

  private:
    explicit PhaseFunction(Term term);

    std::vector<std::pair<double, Term>> terms_;
};

/// Reads a phase function from text: `isotropic`, `rayleigh`, `anisotropic:x=0.5`,
/// `lambert_sphere`, `henyey_greenstein:g=0.75`, `tabulated:file=phobos.csv` (columns
/// phase_angle_deg, value), `moments:file=haze.csv` (columns l, chi), the two forms of `text()`,
/// and sums `0.596*NAME + 0.404*NAME`.
///
/// Spaces are free; `A + 0.5*B` gives A the weight 1. Files are looked for below `directory` when
/// their path is relative; a '+' within a file's name is part of it unless it stands between spaces
/// or a phase function follows. What a user should be told (weights that did not sum to 1, values
/// that had to be scaled) is appended to `notes` when given.
///
/// Errors   std::invalid_argument naming the part that is wrong and what is allowed;
///          std::runtime_error for a file that cannot be opened.
PhaseFunction parse_phase_function(const std::string& text, const std::string& directory = "",
                                   std::vector<std::string>* notes = nullptr);

}  // namespace stratus
