#pragma once

#include <stratus/phase/kinds/phase_kind.h>

namespace stratus {

/// 3/4 (1 + cos^2 Theta). [Blinn82] 3.4
struct Rayleigh {
    static constexpr PhaseKind kind{"rayleigh", {}, false, "rayleigh", "3/4 (1 + cos^2 Theta)"};

    double operator()(double c) const noexcept { return 0.75 * (1 + c * c); }

    std::vector<double> moments(std::size_t count) const {
        std::vector<double> chi = isotropic_moments(count);
        if (count > 2) chi[2] = 0.1;
        return chi;
    }

    bool is_isotropic() const noexcept { return false; }
    std::string caption() const { return "Rayleigh"; }

    std::optional<PhaseClosedForm> closed_form() const {
        return PhaseClosedForm{{1.5, -1.5, 0.75}};  // 3/4 (1 + (1 - y)^2)
    }
};

}  // namespace stratus
