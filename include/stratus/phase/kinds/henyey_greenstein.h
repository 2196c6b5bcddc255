#pragma once

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/phase/kinds/phase_kind.h>
#include <stratus/phase/kinds/phase_text.h>

#include <cmath>

namespace stratus {

/// (1 - g^2) / (1 + g^2 - 2 g cos Theta)^(3/2), |g| < 1. [Blinn82] 3.5
struct HenyeyGreenstein {
    static constexpr PhaseKind kind{"henyey_greenstein",
                                    {"g"},
                                    false,
                                    "henyey_greenstein:g=0.75",
                                    "a lobe of mean cosine g in (-1, 1)"};

    double g;

    explicit HenyeyGreenstein(double g_) : g(g_) {
        require(std::abs(g) < 1, kind.name, "g", "in (-1, 1)", g);
    }

    static HenyeyGreenstein read(PhaseText& text) {
        return HenyeyGreenstein(text.number("henyey_greenstein: g"));
    }
    std::string parameter_text() const { return shortest_text(g); }

    double operator()(double c) const noexcept {
        // 1 + g^2 - 2 g c = (1 - |g|)^2 + 2 |g| (1 -+ c) keeps its precision near |g| = 1
        const double size = std::abs(g);
        const double towards_peak = g < 0 ? -c : c;
        const double base = (1 - size) * (1 - size) + 2 * size * (1 - towards_peak);
        return (1 - size) * (1 + size) / (base * std::sqrt(base));
    }

    std::vector<double> moments(std::size_t count) const {
        std::vector<double> chi(count, 1.0);
        for (std::size_t l = 1; l < count; ++l) chi[l] = chi[l - 1] * g;
        return chi;
    }

    bool is_isotropic() const noexcept { return g == 0; }
    std::string caption() const { return "Henyey-Greenstein g = " + short_number(g, 3); }
    std::optional<PhaseClosedForm> closed_form() const { return PhaseClosedForm{{0, 0, 0}, g}; }
};

}  // namespace stratus
