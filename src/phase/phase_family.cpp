#include <stratus/phase/phase_family.h>

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

namespace stratus {
namespace {

constexpr double rounding = 1e-7;

struct AboutParameter {
    const char *name, *unit;
    AxisScale scale;    // of its ranges
    const char* owner;  // the phase functions that have it, for messages
};

/// One for each PhaseParameter, in order.
constexpr AboutParameter about_parameters[] = {
    {"mixture", "1", AxisScale::linear, "of a phase function with one mie"},
    {"g", "1", AxisScale::logarithm_of_complement,
     "of a phase function with one henyey_greenstein"},
    {"radius", "um", AxisScale::logarithmic,
     "of a phase function with one mie of distribution gamma or lognormal"},
    {"wavelength", "um", AxisScale::logarithmic, "of a phase function with one mie"},
    {"variance", "1", AxisScale::logarithmic,
     "of a phase function with one mie of distribution gamma or lognormal"},
};

const AboutParameter& about(PhaseParameter parameter) noexcept {
    return about_parameters[static_cast<int>(parameter)];
}

/// Whether a term has the parameter.
bool has(const PhaseFunction::Term& term, PhaseParameter parameter) noexcept {
    if (parameter == PhaseParameter::mixture) return false;
    if (parameter == PhaseParameter::g) return std::holds_alternative<HenyeyGreenstein>(term);
    const Mie* const mie = std::get_if<Mie>(&term);
    return mie != nullptr &&
           (parameter == PhaseParameter::wavelength || mie->droplets.has_effective_parameters());
}

PhaseFunction::Term with_parameter(const PhaseFunction::Term& term, PhaseParameter parameter,
                                   double value) {
    if (parameter == PhaseParameter::g) return HenyeyGreenstein(value);
    Droplets droplets = std::get<Mie>(term).droplets;
    (parameter == PhaseParameter::radius       ? droplets.effective_radius
     : parameter == PhaseParameter::wavelength ? droplets.wavelength
                                               : droplets.effective_variance) = value;
    return Mie(droplets);
}

bool is_near(double value, double sample) noexcept {
    return std::abs(value - sample) <= rounding * std::abs(sample);
}

/// Samples along one axis; for discrete values weight 1 of one, or not-a-number.
Stencil stencil_along(const FamilyAxis& axis, double value) noexcept {
    constexpr float none = std::numeric_limits<float>::quiet_NaN();
    if (std::isnan(value)) return {0, {none, 0, 0, 0}};
    if (!axis.is_discrete) return axis.axis.view().stencil(value);
    const auto& values = axis.axis.values;
    const auto found = std::find_if(values.begin(), values.end(),
                                    [&](double sample) { return is_near(value, sample); });
    if (found == values.end()) return {0, {none, 0, 0, 0}};
    return {static_cast<int>(found - values.begin()), {1, 0, 0, 0}};
}

}  // namespace

const char* parameter_name(PhaseParameter parameter) noexcept { return about(parameter).name; }

const char* parameter_unit(PhaseParameter parameter) noexcept { return about(parameter).unit; }

AxisScale parameter_scale(PhaseParameter parameter) noexcept { return about(parameter).scale; }

std::optional<PhaseParameter> parameter_named(const std::string& name) noexcept {
    for (const PhaseParameter parameter : all_parameters)
        if (name == parameter_name(parameter)) return parameter;
    return {};
}

std::vector<std::string> parameter_names() {
    std::vector<std::string> names;
    for (const AboutParameter& parameter : about_parameters) names.emplace_back(parameter.name);
    return names;
}

PhaseFunction with_parameter(const PhaseFunction& phase_function, PhaseParameter parameter,
                             double value) {
    const auto& terms = phase_function.terms();
    const auto is_meant = [&](const auto& term) { return has(term.second, parameter); };
    const auto count = std::count_if(terms.begin(), terms.end(), is_meant);
    require(count == 1, "family", parameter_name(parameter), about(parameter).owner,
            phase_function.text().substr(0, 80));
    std::vector<std::pair<double, PhaseFunction>> parts;
    for (const auto& term : terms)
        parts.emplace_back(
            term.first, PhaseFunction(is_meant(term) ? with_parameter(term.second, parameter, value)
                                                     : term.second));
    return PhaseFunction::sum(parts);
}

std::size_t member_count(const FamilyAxes& axes) noexcept {
    std::size_t count = 1;
    for (const FamilyAxis& axis : axes) count *= axis.axis.values.size();
    return count;
}

FamilyPoint member_at(const FamilyAxes& axes, std::size_t member) {
    std::vector<double> values(axes.size());
    for (std::size_t k = axes.size(); k-- > 0;) {
        const std::vector<double>& samples = axes[k].axis.values;
        values[k] = samples[member % samples.size()];
        member /= samples.size();
    }
    return FamilyPoint(values);
}

std::vector<FamilyPoint> family_corners(FamilyAxes axes) {
    for (FamilyAxis& axis : axes) {
        std::vector<double>& values = axis.axis.values;
        values = {values.front(), values.back()};
    }
    std::vector<FamilyPoint> corners;
    for (std::size_t m = 0; m < member_count(axes); ++m) corners.push_back(member_at(axes, m));
    return corners;
}

bool mixes_two(const FamilyAxes& axes) noexcept {
    return std::any_of(axes.begin(), axes.end(), [](const FamilyAxis& axis) {
        return axis.parameter == PhaseParameter::mixture;
    });
}

FamilyStencil family_stencil(const FamilyAxes& axes, const FamilyPoint& at) noexcept {
    FamilyStencil all;
    for (std::size_t k = 0; k < axes.size(); ++k) {
        const FamilyStencil before = all;
        const Stencil along = stencil_along(axes[k], at[k]);
        const auto samples = static_cast<int>(axes[k].axis.values.size());
        const int count = axes[k].is_discrete ? 1 : std::min(samples, stencil_size);
        all.count = before.count * count;
        for (int n = 0; n < before.count; ++n)
            for (int s = 0; s < count; ++s) {
                all.member[n * count + s] = before.member[n] * samples + along.first + s;
                all.weight[n * count + s] = before.weight[n] * along.weight[s];
            }
    }
    return all;
}

bool holds(const FamilyAxis& axis, double value) noexcept {
    const std::vector<double>& values = axis.axis.values;
    if (axis.is_discrete)
        return std::any_of(values.begin(), values.end(),
                           [&](double sample) { return is_near(value, sample); });
    const auto slack = [](double end) { return rounding * std::abs(end); };
    return value >= values.front() - slack(values.front()) &&
           value <= values.back() + slack(values.back());
}

std::string allowed_text(const FamilyAxis& axis) {
    const std::string unit = parameter_unit(axis.parameter);
    const std::string of_table = (unit == "1" ? "" : " " + unit) + " of the table";
    std::vector<std::string> values;
    for (const double value : axis.axis.values) values.push_back(shortest_text(value));
    if (axis.is_discrete) return "one of " + joined(values) + of_table;
    return "in [" + values.front() + ", " + values.back() + "]" + of_table;
}

void check_family(const PhaseFunction& first, const FamilyAxes& axes, const char* caller) {
    require(axes.size() <= max_family_axes, caller, "family", "of one or two axes", axes.size());
    for (const FamilyAxis& axis : axes) {
        const std::vector<double>& values = axis.axis.values;
        require(values.size() >= 2, caller, axis.name(), "of two samples at least", values.size());
        if (axis.is_discrete) {
            for (std::size_t n = 0; n < values.size(); ++n)
                require(std::isfinite(values[n]) && (n == 0 || values[n] > values[n - 1]), caller,
                        axis.name(), "finite and ascending", values[n]);
        } else {
            require(axis.axis.scale == parameter_scale(axis.parameter), caller,
                    std::string("scale of axis ") + axis.name(),
                    axis_scale_name(parameter_scale(axis.parameter)),
                    axis_scale_name(axis.axis.scale));
            check_axis(axis.axis, axis.name());
        }
        for (const double value : {values.front(), values.back()}) {
            if (axis.parameter == PhaseParameter::mixture)
                require(value >= 0 && value <= 1, caller, axis.name(), "within [0, 1]", value);
            else
                with_parameter(first, axis.parameter, value);
        }
    }
    require(axes.size() < 2 || axes[0].parameter != axes[1].parameter, caller, "family",
            "of axes that differ", axes.empty() ? "" : axes[0].name());
}

}  // namespace stratus
