// Each kind of phase function provides, in a header of its own beside this one:
//
//     static constexpr PhaseKind kind                       how users write it
//     static Kind read(PhaseText&)                          its parameter's value, if it has one
//     std::string parameter_text() const                    what `read` turns into it again
//     double operator()(double cos_theta) const noexcept    its value, mean 1, |cos_theta| <= 1
//     std::vector<double> moments(std::size_t count) const  chi_0 .. chi_{count-1}, count >= 1
//     bool is_isotropic() const noexcept                    true when it is 1 everywhere
//     std::string caption() const                           what pictures call it
//     std::optional<PhaseClosedForm> closed_form() const    none: fast lookups sample it
//
// A kind of several parameters has `read(PhaseText&, const std::string& first)` instead, which reads
// the value of the parameter `first` and goes on to others with PhaseText::parameter, and its
// parameter_text names them all (mie.h).
//
// A new kind is such a header, its place in `PhaseFunction::Term` and its tests.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace stratus {

/// A kind of phase function as users write it: `name`, `name:parameter=...`, or several
/// `parameter=...` with commas between.
struct PhaseKind {
    const char* name;
    const char* parameters[9];  // their names; null where there are no more
    bool may_be_a_file;         // `name:file=...` is allowed too
    const char* example;
    const char* help;  // what the example is, in a few words

    constexpr bool has_parameter() const { return parameters[0] != nullptr; }
    constexpr bool has_several_parameters() const { return parameters[1] != nullptr; }
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

/// chi_0 = 1 and nothing else: what most kinds start from.
inline std::vector<double> isotropic_moments(std::size_t count) {
    std::vector<double> chi(count, 0.0);
    chi[0] = 1;
    return chi;
}

}  // namespace stratus
