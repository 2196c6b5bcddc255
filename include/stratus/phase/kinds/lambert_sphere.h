#pragma once

#include <stratus/base/constants.h>
#include <stratus/phase/kinds/phase_kind.h>

#include <algorithm>
#include <cmath>

namespace stratus {

/// A sphere whose surface obeys Lambert's law: (8 / 3 pi) (sin a + (pi - a) cos a). [Blinn82] 3.3
struct LambertSphere {
    static constexpr PhaseKind kind{"lambert_sphere",
                                    {},
                                    false,
                                    "lambert_sphere",
                                    "a large sphere whose surface obeys Lambert's law"};

    double operator()(double c) const noexcept {
        // with the scattering angle T = pi - a: sin a + (pi - a) cos a = sin T - T cos T
        const double s = std::sqrt(std::max(0.0, (1 - c) * (1 + c)));
        return 8 / (3 * pi) * (s - std::atan2(s, c) * c);
    }

    std::vector<double> moments(std::size_t count) const {
        // Twice by parts: phi'' = (8 / 3 pi) / sqrt(1 - c^2), whose even integrals against P_l are
        // (8/3) a_l, a_l = ((l-1)!! / l!!)^2. This leaves 4 a_{l-2} / (l (l+2))^2 for even l >= 2.
        std::vector<double> chi = isotropic_moments(count);
        if (count > 1) chi[1] = -4.0 / 9;
        double a = 1;
        for (std::size_t l = 2; l < count; l += 2) {
            const double order = static_cast<double>(l);
            chi[l] = 4 * a / (order * order * (order + 2) * (order + 2));
            a *= (order - 1) * (order - 1) / (order * order);
        }
        return chi;
    }

    bool is_isotropic() const noexcept { return false; }
    std::string caption() const { return "Lambert sphere"; }
    std::optional<PhaseClosedForm> closed_form() const { return {}; }
};

}  // namespace stratus
