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

#include <stratus/phase/kinds.h>
#include <stratus/phase/mie.h>
#include <stratus/phase/tabulated.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace stratus {

/// Any phase function: a weighted sum of terms, weights summing to 1.
class PhaseFunction {
  public:
    /// Every kind that there is; kinds.h says what each provides.
    using Term = std::variant<Isotropic, Rayleigh, Anisotropic, LambertSphere, HenyeyGreenstein,
                              Tabulated, Moments, Mie>;

    /// Isotropic.
    PhaseFunction();

    /// One of the kinds alone.
    explicit PhaseFunction(Term term);

    // Defaulted, but compiled once: copies of the variant are long.
    PhaseFunction(const PhaseFunction&);
    PhaseFunction(PhaseFunction&&) noexcept;
    PhaseFunction& operator=(const PhaseFunction&);
    PhaseFunction& operator=(PhaseFunction&&) noexcept;
    ~PhaseFunction();

    // Each kind by name; std::invalid_argument names the allowed range, given with each kind.
    static PhaseFunction isotropic() { return PhaseFunction(Isotropic{}); }
    static PhaseFunction rayleigh() { return PhaseFunction(Rayleigh{}); }
    static PhaseFunction anisotropic(double x) { return PhaseFunction(Anisotropic(x)); }
    static PhaseFunction lambert_sphere() { return PhaseFunction(LambertSphere{}); }
    static PhaseFunction henyey_greenstein(double g) { return PhaseFunction(HenyeyGreenstein(g)); }
    static PhaseFunction tabulated(std::vector<double> phase_angle_deg, std::vector<double> value) {
        return PhaseFunction(Tabulated(std::move(phase_angle_deg), std::move(value)));
    }
    static PhaseFunction from_moments(std::vector<double> chi) {
        return PhaseFunction(Moments(std::move(chi)));
    }

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

    /// The text that `parse_phase_function` turns into this same function, bit for bit: the grammar
    /// below, numbers with as many digits as it takes to read them back, and
    /// `tabulated:points=0 3.5/10 2.25/...` or `moments:chi=1 0.75 ...` in place of file names.
    std::string text() const;

    /// Single-scattering albedo, where every term knows its own as droplets (mie.h) and tables with
    /// a geometric albedo (tabulated.h) do.
    std::optional<double> albedo() const;

    /// Returns its name in pictures: "0.6 Lambert sphere  +  0.4 Henyey-Greenstein g = 0.5".
    std::string caption() const;

    const std::vector<std::pair<double, Term>>& terms() const noexcept { return terms_; }

  private:
    std::vector<std::pair<double, Term>> terms_;
};

/// Columns of a file that the text of a phase function names.
struct PhaseColumns {
    std::string name;                         // of the file, for messages
    std::vector<std::vector<double>> values;  // a vector for each column that was asked for
    RowName row_name;
    std::vector<std::string> names{};  // of the columns, as the file has them
};

/// Reads a file: its name as the text has it, and the columns that are wanted, " or " between names
/// of which either will do.
using PhaseFileReader =
    std::function<PhaseColumns(const std::string& file, const std::vector<std::string>& columns)>;

/// Reads a phase function from text: the examples of `phase_function_help`, the two forms of
/// `text()`, and sums `0.596*NAME + 0.404*NAME`.
///
/// Spaces are free; `A + 0.5*B` gives A the weight 1. A '+' within a file's name is part of it
/// unless it stands between spaces or a phase function follows, a ',' unless an option of a table
/// does. What a user should be told (weights that did not sum to 1, how a table is continued) is
/// appended to `notes` when given. The runtime opens no files: `read_file` reads the columns of those
/// that the text names, and without it such a text is refused; read_phase_function
/// (io/phase_file.h) reads them.
///
/// Errors   std::invalid_argument naming the part that is wrong and what is allowed.
PhaseFunction parse_phase_function(const std::string& text,
                                   std::vector<std::string>* notes = nullptr,
                                   const PhaseFileReader& read_file = {});

/// Lists the kinds of phase function for the help of an option: a line for each kind with an
/// example, then sums.
std::string phase_function_help();

}  // namespace stratus
