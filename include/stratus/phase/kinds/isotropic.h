#pragma once

#include <stratus/phase/kinds/phase_kind.h>

namespace stratus {

struct Isotropic {
    static constexpr PhaseKind kind{
        "isotropic", {}, false, "isotropic", "the same in all directions"};

    double operator()(double) const noexcept { return 1; }
    std::vector<double> moments(std::size_t count) const { return isotropic_moments(count); }
    bool is_isotropic() const noexcept { return true; }
    std::string caption() const { return "isotropic"; }
    std::optional<PhaseClosedForm> closed_form() const { return PhaseClosedForm{{1, 0, 0}}; }
};

}  // namespace stratus
