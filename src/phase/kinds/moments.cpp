#include <stratus/phase/tabulated.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>

#include "phase_text.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

namespace stratus {
namespace {

constexpr std::size_t max_moments = std::size_t{1} << 16;  // of drops of some millimetres

/// The series sum_l (2 l + 1) chi_l P_l(cos x) as sum_k c_k cos(k x).
///
/// Source   P_l(cos x) = sum_m h_m h_{l-m} cos((l - 2 m) x), h_m = (1/2)_m / m!: the generating
///          function 1 / |1 - t exp(i x)|, factor by factor.
/// Cost     n^2 / 4 steps.
std::vector<double> cosine_coefficients(const std::vector<double>& chi) {
    const std::size_t n = chi.size();
    std::vector<double> h(n, 1.0), scaled(n), cosines(n, 0.0);
    for (std::size_t m = 1; m < n; ++m) h[m] = h[m - 1] * (1 - 0.5 / static_cast<double>(m));
    for (std::size_t l = 0; l < n; ++l) scaled[l] = (2 * static_cast<double>(l) + 1) * chi[l];
    for (std::size_t m = 0; 2 * m < n; ++m) {
        cosines[0] += h[m] * h[m] * scaled[2 * m];
        const double twice = 2 * h[m];  // m and l - m give the same cosine
        for (std::size_t k = 1; 2 * m + k < n; ++k)
            cosines[k] += twice * h[m + k] * scaled[2 * m + k];
    }
    return cosines;
}

/// Least and largest value of sum_k c_k cos(k x) at eight or more angles to an oscillation, by one
/// Fourier transform.
std::pair<double, double> range_of_cosines(const std::vector<double>& cosines) {
    std::size_t size = 16;
    while (size < 16 * cosines.size()) size *= 2;
    std::vector<std::complex<double>> values(size), roots(size / 2);
    for (std::size_t k = 0; k < size / 2; ++k)
        roots[k] = std::polar(1.0, 2 * pi * static_cast<double>(k) / static_cast<double>(size));
    std::copy(cosines.begin(), cosines.end(), values.begin());
    // Halving from the front: the values come out of order, which neither end of a range minds.
    for (std::size_t half = size / 2, step = 1; half > 0; half /= 2, step *= 2)
        for (std::size_t begin = 0; begin < size; begin += 2 * half)
            for (std::size_t k = 0; k < half; ++k) {
                auto &here = values[begin + k], &there = values[begin + k + half];
                const std::complex<double> sum = here + there, rest = here - there;
                const std::complex<double> root = roots[k * step];
                here = sum;
                there = {rest.real() * root.real() - rest.imag() * root.imag(),
                         rest.real() * root.imag() + rest.imag() * root.real()};
            }
    const auto [least, largest] = std::minmax_element(
        values.begin(), values.end(),
        [](const auto& one, const auto& other) { return one.real() < other.real(); });
    return {least->real(), largest->real()};
}

}  // namespace

Moments::Moments(std::vector<double> given, const RowName& row_name) : chi(std::move(given)) {
    require(!chi.empty(), kind.name, "chi", "at least one moment", 0);
    require(chi.size() <= max_moments, kind.name, "chi",
            "at most " + std::to_string(max_moments) + " moments", chi.size());
    require(std::abs(chi[0] - 1) <= 1e-6, kind.name, "chi_0" + row_name(0), "1 (to 1e-6)", chi[0]);
    for (std::size_t l = 0; l < chi.size(); ++l) {
        constexpr double rounding = 1e-6;
        const double weight = 2 * static_cast<double>(l) + 1;
        const bool may_be_weighted = std::abs(chi[l]) <= weight * (1 + rounding);
        require(std::abs(chi[l]) <= 1 + rounding, kind.name,
                "chi_" + std::to_string(l) + row_name(l),
                may_be_weighted ? "in [-1, 1], which (2 l + 1) chi_l divided by 2 l + 1 would be"
                                : "in [-1, 1]",
                chi[l]);
    }
    const double mean = chi[0];
    for (double& moment : chi) moment = std::clamp(moment / mean, -1.0, 1.0);
    const auto [smallest, largest] = range_of_cosines(cosine_coefficients(chi));
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
