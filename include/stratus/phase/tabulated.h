// Phase functions given by numbers: by values at angles, or by Legendre moments.
#pragma once

#include <stratus/phase/kinds.h>

namespace stratus {

/// Continuation of rows that do not reach 0 or 180 degrees.
enum class PhaseTableTail { constant, hg };

struct PhaseTableOptions {
    PhaseTableTail tail = PhaseTableTail::constant;
    /// Brightness of a particle at phase angle 0 beside that of a white Lambert disk of the
    /// same cross-section which faces the light. That is w phi / 4 of a particle that intercepts
    /// what falls on it: w = 4 p / phi(Theta = pi), phi of mean 1. [0, phi / 4]
    std::optional<double> geometric_albedo;
};

/// Measured values at phase angles (degrees), joined by monotone cubics in the phase angle (Fritsch
/// and Carlson 1980: no overshoot, so never negative) and scaled to mean 1.
///
/// Rows that do not reach 0 or 180 degrees are continued: by the value of the outer row, or by a
/// double Henyey-Greenstein function c1 HG(g1) + c2 HG(g2), g1 >= 0 >= g2, times what makes it meet
/// the outer row. It is fitted, by least squares of relative errors, to the rows within 40 degrees
/// of an end that is continued.
struct Tabulated : SampledPhase {
    static constexpr PhaseKind kind{
        "tabulated",
        {"points"},
        true,
        "tabulated:file=moon.csv",
        "values at angles: columns phase_angle_deg or scattering_angle_deg, and value; with "
        ",tail=hg "
        "continued by a fit where they end early, else as they end; with ,geometric_albedo=0.1 "
        "also an albedo"};

    using Tail = PhaseTableTail;
    using Options = PhaseTableOptions;

    std::vector<double> phase_angle_deg;  // as given, ascending in [0, 180]
    std::vector<double> value;            // as given
    Options options;
    std::optional<double> albedo;  // of single scattering, where geometric_albedo is given

    // The knots: the rows and their continuation, from 0 to 180 degrees.
    std::vector<double> knot_angle_deg, knot_value;
    std::vector<double> slope;  // d(value)/d(angle) at the knots, per radian
    double normalisation;       // value * normalisation has spherical mean 1

    /// At least 3 rows, angles strictly ascending in [0, 180], values finite, >= 0 and not all 0.
    /// For Tail::hg at least 4 rows to fit, all above 0.
    Tabulated(std::vector<double> phase_angle_deg, std::vector<double> value,
              const Options& options = {}, const RowName& row_name = row_number);

    static Tabulated read(PhaseText& text, const std::string& first);
    std::string parameter_text() const;

    /// The names of options, in a text after commas.
    static const std::vector<std::string>& option_names();
    /// Reads `,NAME=value` as long as they follow.
    static Options read_options(PhaseText& text);

    /// How the rows are continued; empty where they reach both ends.
    std::string continuation() const;

    double operator()(double c) const noexcept;
    std::vector<double> moments(std::size_t count) const;
    std::string caption() const {
        return "tabulated at " + std::to_string(value.size()) + " angles";
    }

  private:
    void continue_by_fit(const RowName& row_name);

    double fitted_g_[2] = {0, 0};
};

/// A phase function given by its Legendre moments alone.
struct Moments : SampledPhase {
    static constexpr PhaseKind kind{
        "moments", {"chi"}, true, "moments:file=haze.csv", "Legendre moments: columns l, chi"};

    std::vector<double> chi;  // chi[0] = 1

    /// At most 65,536 moments, chi_0 = 1 (1e-6; all are divided by it), |chi_l| <= 1, and the sum
    /// not below -1e-3 of its largest value anywhere: a truncated series may dip that far, and its
    /// values are returned as they are.
    explicit Moments(
        std::vector<double> chi,
        const RowName& row_name = [](std::size_t) { return std::string(); });

    static Moments read(PhaseText& text, const std::string& first);
    std::string parameter_text() const;

    double operator()(double c) const noexcept;
    std::vector<double> moments(std::size_t count) const;
    bool is_isotropic() const noexcept;
    std::string caption() const { return std::to_string(chi.size()) + " Legendre moments"; }
};

}  // namespace stratus
