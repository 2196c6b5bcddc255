// Kinds of phase function: what each provides, and those of a closed form. Others are in tabulated.h
// and mie.h. Each kind provides:
//
//     static constexpr PhaseKind kind                       how users write it
//     static Kind read(PhaseText&, const std::string& first)
//                                                           if it has parameters: the value of `first`, the
//                                                           first one in a text, and any that follow
//     std::string parameter_text() const                    what `read` turns into it again
//     double operator()(double cos_theta) const noexcept    its value, mean 1, |cos_theta| <= 1
//     std::vector<double> moments(std::size_t count) const  chi_0 .. chi_{count-1}, count >= 1
//     std::string caption() const                           what pictures call it
//     bool is_isotropic() const noexcept                    true when it is 1 everywhere
//     std::optional<PhaseClosedForm> closed_form() const    none: fast lookups sample it
//
// The last two are those of SampledPhase unless a kind has its own. A kind of several parameters goes on
// to those after the first with PhaseText::parameter (mie.h).
//
// A new kind is such a struct, its place in `PhaseFunction::Term` and its tests.
#pragma once

#include <stratus/base/constants.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace stratus {

struct PhaseText;  // src/phase/kinds/phase_text.h

/// A kind of phase function as users write it: `name`, `name:parameter=...`, or several
/// `parameter=...` with commas between.
struct PhaseKind {
    const char* name;
    const char* parameters[9];  // their names; null where there are no more
    bool may_be_a_file;         // `name:file=...` is allowed too
    const char* example;
    const char* help;  // what the example is, in a few words

    constexpr bool has_parameter() const { return parameters[0] != nullptr; }
    std::vector<std::string> parameter_names() const {
        std::vector<std::string> names;
        for (const char* parameter : parameters)
            if (parameter != nullptr) names.emplace_back(parameter);
        return names;
    }
};

/// A polynomial in y = 1 - cos Theta and a Henyey-Greenstein lobe, if any: what a fast lookup
/// evaluates without samples.
struct PhaseClosedForm {
    double polynomial[3] = {0, 0, 0};
    std::optional<double> lobe_g = {};
};

/// Common to most kinds.
struct SampledPhase {
    bool is_isotropic() const noexcept { return false; }
    std::optional<PhaseClosedForm> closed_form() const { return {}; }
};

/// Tells where the row of an index stands, for messages: " (moon.csv, line 3)".
using RowName = std::function<std::string(std::size_t)>;

/// " (row 3)" of index 2.
inline std::string row_number(std::size_t row) { return " (row " + std::to_string(row + 1) + ")"; }

/// `count` moments, 0 beyond the first ones.
inline std::vector<double> continued_moments(std::vector<double> first, std::size_t count) {
    first.resize(count, 0.0);
    return first;
}

struct Isotropic {
    static constexpr PhaseKind kind{
        "isotropic", {}, false, "isotropic", "the same in all directions"};

    double operator()(double) const noexcept { return 1; }
    std::vector<double> moments(std::size_t count) const { return continued_moments({1}, count); }
    bool is_isotropic() const noexcept { return true; }
    std::string caption() const { return "isotropic"; }
    std::optional<PhaseClosedForm> closed_form() const { return PhaseClosedForm{{1, 0, 0}}; }
};

/// 3/4 (1 + cos^2 Theta). [Blinn82] 3.4
struct Rayleigh : SampledPhase {
    static constexpr PhaseKind kind{"rayleigh", {}, false, "rayleigh", "3/4 (1 + cos^2 Theta)"};

    double operator()(double c) const noexcept { return 0.75 * (1 + c * c); }

    std::vector<double> moments(std::size_t count) const {
        return continued_moments({1, 0, 0.1}, count);
    }

    std::string caption() const { return "Rayleigh"; }

    std::optional<PhaseClosedForm> closed_form() const {
        return PhaseClosedForm{{1.5, -1.5, 0.75}};  // 3/4 (1 + (1 - y)^2)
    }
};

/// 1 + x cos a = 1 - x cos Theta, |x| <= 1. [Blinn82] 3.2
struct Anisotropic {
    static constexpr PhaseKind kind{
        "anisotropic", {"x"}, false, "anisotropic:x=0.5", "1 - x cos Theta, x in [-1, 1]"};

    double x;

    explicit Anisotropic(double x);
    static Anisotropic read(PhaseText& text, const std::string& first);
    std::string parameter_text() const;

    double operator()(double c) const noexcept { return 1 - x * c; }

    std::vector<double> moments(std::size_t count) const {
        return continued_moments({1, -x / 3}, count);
    }

    bool is_isotropic() const noexcept { return x == 0; }
    std::string caption() const;
    std::optional<PhaseClosedForm> closed_form() const { return PhaseClosedForm{{1 - x, x, 0}}; }
};

/// A sphere whose surface obeys Lambert's law: (8 / 3 pi) (sin a + (pi - a) cos a). [Blinn82] 3.3
struct LambertSphere : SampledPhase {
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
        std::vector<double> chi = continued_moments({1, -4.0 / 9}, count);
        double a = 1;
        for (std::size_t l = 2; l < count; l += 2) {
            const double order = static_cast<double>(l);
            chi[l] = 4 * a / (order * order * (order + 2) * (order + 2));
            a *= (order - 1) * (order - 1) / (order * order);
        }
        return chi;
    }

    std::string caption() const { return "Lambert sphere"; }
};

/// (1 - g^2) / (1 + g^2 - 2 g cos Theta)^(3/2), |g| < 1. [Blinn82] 3.5
struct HenyeyGreenstein {
    static constexpr PhaseKind kind{"henyey_greenstein",
                                    {"g"},
                                    false,
                                    "henyey_greenstein:g=0.75",
                                    "a lobe of mean cosine g in (-1, 1)"};

    double g;

    explicit HenyeyGreenstein(double g);
    static HenyeyGreenstein read(PhaseText& text, const std::string& first);
    std::string parameter_text() const;

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
    std::string caption() const;
    std::optional<PhaseClosedForm> closed_form() const { return PhaseClosedForm{{0, 0, 0}, g}; }
};

}  // namespace stratus
