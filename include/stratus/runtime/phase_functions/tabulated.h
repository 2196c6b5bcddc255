#pragma once

#include <stratus/runtime/phase_functions/phase_kind.h>
#include <stratus/runtime/phase_functions/phase_text.h>

#include <functional>

namespace stratus {

/// Measured values at phase angles (degrees), joined by monotone cubics in the phase angle (Fritsch
/// and Carlson 1980: no overshoot, so never negative) and scaled to mean 1.
struct Tabulated {
    static constexpr PhaseKind kind{"tabulated",
                                    {"points"},
                                    true,
                                    "tabulated:file=moon.csv",
                                    "values at phase angles: columns phase_angle_deg, value"};

    std::vector<double> phase_angle_deg;  // as given, ascending from 0 to 180
    std::vector<double> value;            // as given
    std::vector<double> slope;            // d(value)/d(angle) at the knots, per radian
    double normalisation;                 // value * normalisation has spherical mean 1

    /// Where the row of an index stands, for messages: " (row 3)".
    using RowName = std::function<std::string(std::size_t)>;

    /// At least 3 rows, angles strictly ascending from 0 to 180, values finite, >= 0 and not all 0.
    Tabulated(std::vector<double> phase_angle_deg, std::vector<double> value,
              const RowName& row_name);
    Tabulated(std::vector<double> phase_angle_deg, std::vector<double> value);

    static Tabulated read(PhaseText& text);
    std::string parameter_text() const;

    double operator()(double c) const noexcept;
    std::vector<double> moments(std::size_t count) const;
    bool is_isotropic() const noexcept { return false; }
    std::string caption() const {
        return "tabulated at " + std::to_string(value.size()) + " angles";
    }
    std::optional<PhaseClosedForm> closed_form() const { return {}; }
};

}  // namespace stratus
