#include <stratus/phase/phase_function.h>

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>

#include "kinds/phase_text.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stratus {
namespace {

struct TermText {
    template <class Kind>
    std::string operator()(const Kind& term) const {
        const std::string name = Kind::kind.name;
        if constexpr (Kind::kind.has_parameter())
            return name + ':' + term.parameter_text();
        else
            return name;
    }
};

}  // namespace

// ---- kinds of a closed form

Anisotropic::Anisotropic(double x_) : x(x_) { require_in("[-1, 1]", kind.name, "x", x); }

Anisotropic Anisotropic::read(PhaseText& text, const std::string&) {
    return Anisotropic(text.number("anisotropic: x"));
}

std::string Anisotropic::parameter_text() const { return "x=" + shortest_text(x); }

std::string Anisotropic::caption() const { return "anisotropic x = " + short_number(x, 3); }

HenyeyGreenstein::HenyeyGreenstein(double g_) : g(g_) { require_in("(-1, 1)", kind.name, "g", g); }

HenyeyGreenstein HenyeyGreenstein::read(PhaseText& text, const std::string&) {
    return HenyeyGreenstein(text.number("henyey_greenstein: g"));
}

std::string HenyeyGreenstein::parameter_text() const { return "g=" + shortest_text(g); }

std::string HenyeyGreenstein::caption() const {
    const std::string rounded = short_number(g, 3);
    const bool is_refused = rounded == "1" || rounded == "-1";  // which g never is
    return "Henyey-Greenstein g = " + (is_refused ? shortest_text(g) : rounded);
}

// ---- sums of kinds

PhaseFunction::PhaseFunction() : PhaseFunction(Isotropic{}) {}

PhaseFunction::PhaseFunction(Term term) { terms_.emplace_back(1.0, std::move(term)); }

PhaseFunction::PhaseFunction(const PhaseFunction&) = default;
PhaseFunction::PhaseFunction(PhaseFunction&&) noexcept = default;
PhaseFunction& PhaseFunction::operator=(const PhaseFunction&) = default;
PhaseFunction& PhaseFunction::operator=(PhaseFunction&&) noexcept = default;
PhaseFunction::~PhaseFunction() = default;

PhaseFunction PhaseFunction::sum(const std::vector<std::pair<double, PhaseFunction>>& parts) {
    double total = 0;
    std::size_t count = 0;
    for (const auto& [weight, part] : parts) {
        require(weight >= 0 && std::isfinite(weight), "sum", "weight", "finite and at least 0",
                weight);
        total += weight;
        count += part.terms_.size();
    }
    require(total > 0 && std::isfinite(total), "sum", "total weight", "above 0 and finite", total);
    // Weights that have been divided once sum to 1 but for rounding; dividing them again would
    // change their last bits, and text() would not come back as the same function.
    const double rounding = static_cast<double>(count) * std::numeric_limits<double>::epsilon();
    const double divisor = std::abs(total - 1) <= rounding ? 1 : total;
    PhaseFunction whole;
    whole.terms_.clear();
    for (const auto& [weight, part] : parts) {
        if (weight == 0) continue;
        for (const auto& [share, term] : part.terms_)
            whole.terms_.emplace_back(weight / divisor * share, term);
    }
    return whole;
}

PhaseFunction PhaseFunction::mixture(double share_of_first, const PhaseFunction& first,
                                     const PhaseFunction& second) {
    return sum({{share_of_first, first}, {1 - share_of_first, second}});
}

double PhaseFunction::operator()(double cos_scattering_angle) const noexcept {
    const double c = std::clamp(cos_scattering_angle, -1.0, 1.0);
    double value = 0 * c;  // not-a-number where it is
    for (const auto& [weight, term] : terms_)
        value += weight * std::visit([&](const auto& kind) { return kind(c); }, term);
    return value;
}

std::vector<double> PhaseFunction::moments(int count) const {
    require(count >= 1, "moments", "count", "at least 1", count);
    std::vector<double> chi(static_cast<std::size_t>(count));
    for (const auto& [weight, term] : terms_) {
        const std::vector<double> part =
            std::visit([&](const auto& kind) { return kind.moments(chi.size()); }, term);
        for (std::size_t l = 0; l < chi.size(); ++l) chi[l] += weight * part[l];
    }
    chi[0] = 1;
    return chi;
}

double PhaseFunction::asymmetry() const { return moments(2)[1]; }

bool PhaseFunction::is_isotropic() const noexcept {
    return std::all_of(terms_.begin(), terms_.end(), [](const auto& part) {
        return std::visit([](const auto& kind) { return kind.is_isotropic(); }, part.second);
    });
}

std::string PhaseFunction::text() const {
    if (terms_.size() == 1) return std::visit(TermText{}, terms_[0].second);
    std::string whole;
    for (const auto& [weight, term] : terms_)
        whole += (whole.empty() ? "" : " + ") + shortest_text(weight) + "*" +
                 std::visit(TermText{}, term);
    return whole;
}

std::optional<double> PhaseFunction::albedo() const {
    double extinction = 0;  // for a scattering cross-section of 1, which the weights share
    for (const auto& [weight, term] : terms_) {
        std::optional<double> albedo;
        if (const Mie* const droplets = std::get_if<Mie>(&term)) albedo = droplets->albedo();
        if (const Tabulated* const table = std::get_if<Tabulated>(&term)) albedo = table->albedo;
        if (!albedo) return {};
        extinction += weight / *albedo;
    }
    return std::min(1.0, 1 / extinction);  // but for rounding
}

std::string PhaseFunction::caption() const {
    std::string whole;
    for (const auto& [weight, term] : terms_) {
        if (!whole.empty()) whole += "  +  ";
        if (terms_.size() > 1) whole += short_number(weight, 3) + " ";
        whole += std::visit([](const auto& kind) { return kind.caption(); }, term);
    }
    return whole;
}

}  // namespace stratus
