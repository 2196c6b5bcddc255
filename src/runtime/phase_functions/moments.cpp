#include <stratus/runtime/phase_functions/moments.h>

#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>
#include <stratus/runtime/number_text.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {

Moments::Moments(std::vector<double> given, const RowName& row_name) : chi(std::move(given)) {
    require(!chi.empty(), kind.name, "chi", "at least one moment", 0);
    require(std::abs(chi[0] - 1) <= 1e-6, kind.name, "chi_0" + row_name(0), "1 (to 1e-6)", chi[0]);
    for (std::size_t l = 0; l < chi.size(); ++l)
        require(std::abs(chi[l]) <= 1 + 1e-6, kind.name, "chi_" + std::to_string(l) + row_name(l),
                "in [-1, 1]", chi[l]);
    const double mean = chi[0];
    for (double& moment : chi) moment = std::clamp(moment / mean, -1.0, 1.0);
    double smallest = 1, largest = 1;
    const int angles = 8 * static_cast<int>(chi.size());  // eight to an oscillation of P_l
    for (int i = 0; i <= angles; ++i) {
        const double value = (*this)(std::cos(pi * i / angles));
        smallest = std::min(smallest, value);
        largest = std::max(largest, value);
    }
    require(smallest >= -1e-3 * largest, kind.name, "sum of (2 l + 1) chi_l P_l",
            "no lower than -1e-3 of its largest value", smallest);
}

Moments::Moments(std::vector<double> given)
    : Moments(std::move(given), [](std::size_t) { return std::string(); }) {}

Moments Moments::read(PhaseText& text) {
    std::vector<double> chi = {text.number("moments: chi")};
    while (!text.at_end() && !text.next_is('+')) chi.push_back(text.number("moments: chi"));
    return Moments(std::move(chi));
}

std::string Moments::parameter_text() const {
    std::string list;
    for (const double moment : chi) list += (list.empty() ? "" : " ") + shortest_text(moment);
    return list;
}

double Moments::operator()(double c) const noexcept {
    double next = 0, after_next = 0;  // Clenshaw, (l + 1) P_{l+1} = (2 l + 1) c P_l - l P_{l-1}
    for (std::size_t l = chi.size(); l-- > 0;) {
        const double order = static_cast<double>(l);
        const double here = (2 * order + 1) * (chi[l] + c / (order + 1) * next) -
                            (order + 1) / (order + 2) * after_next;
        after_next = next;
        next = here;
    }
    return next;
}

std::vector<double> Moments::moments(std::size_t count) const {
    std::vector<double> first = chi;
    first.resize(count, 0.0);
    return first;
}

bool Moments::is_isotropic() const noexcept {
    return std::all_of(chi.begin() + 1, chi.end(), [](double moment) { return moment == 0; });
}

}  // namespace stratus
