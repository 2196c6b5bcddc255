#pragma once

#include <stratus/phase/kinds/phase_kind.h>
#include <stratus/phase/kinds/phase_text.h>

#include <functional>

namespace stratus {

/// A phase function given by its Legendre moments alone.
struct Moments {
    static constexpr PhaseKind kind{
        "moments", {"chi"}, true, "moments:file=haze.csv", "Legendre moments: columns l, chi"};

    std::vector<double> chi;  // chi[0] = 1

    /// Where the moment of an order stands, for messages: " (haze.csv, line 3)".
    using RowName = std::function<std::string(std::size_t)>;

    /// At most 65,536 moments, chi_0 = 1 (1e-6; all are divided by it), |chi_l| <= 1, and the sum
    /// not below -1e-3 of its largest value anywhere: a truncated series may dip that far, and its
    /// values are returned as they are.
    Moments(std::vector<double> chi, const RowName& row_name);
    explicit Moments(std::vector<double> chi);

    static Moments read(PhaseText& text);
    std::string parameter_text() const;

    double operator()(double c) const noexcept;
    std::vector<double> moments(std::size_t count) const;
    bool is_isotropic() const noexcept;
    std::string caption() const { return std::to_string(chi.size()) + " Legendre moments"; }
    std::optional<PhaseClosedForm> closed_form() const { return {}; }
};

}  // namespace stratus
