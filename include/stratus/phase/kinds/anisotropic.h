#pragma once

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/phase/kinds/phase_kind.h>
#include <stratus/phase/kinds/phase_text.h>

#include <cmath>

namespace stratus {

/// 1 + x cos a = 1 - x cos Theta, |x| <= 1. [Blinn82] 3.2
struct Anisotropic {
    static constexpr PhaseKind kind{
        "anisotropic", {"x"}, false, "anisotropic:x=0.5", "1 - x cos Theta, x in [-1, 1]"};

    double x;

    explicit Anisotropic(double x_) : x(x_) {
        require(std::abs(x) <= 1, kind.name, "x", "in [-1, 1]", x);
    }

    static Anisotropic read(PhaseText& text) { return Anisotropic(text.number("anisotropic: x")); }
    std::string parameter_text() const { return shortest_text(x); }

    double operator()(double c) const noexcept { return 1 - x * c; }

    std::vector<double> moments(std::size_t count) const {
        std::vector<double> chi = isotropic_moments(count);
        if (count > 1) chi[1] = -x / 3;
        return chi;
    }

    bool is_isotropic() const noexcept { return x == 0; }
    std::string caption() const { return "anisotropic x = " + short_number(x, 3); }
    std::optional<PhaseClosedForm> closed_form() const { return PhaseClosedForm{{1 - x, x, 0}}; }
};

}  // namespace stratus
