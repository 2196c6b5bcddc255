// Fits of layers to observations.
#include <stratus/fit/fit.h>
#include <stratus/io/table_file.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "module.h"

namespace stratus::python {
namespace {

/// By a table, which must outlive it; or by phase functions, by the solver or single scattering alone; or
/// of beams alone.
std::unique_ptr<LayerModel> make_model(const AnyTable* table,
                                       const std::optional<PhaseFunction>& first,
                                       const std::optional<PhaseFunction>& second, bool single) {
    if (table != nullptr) return table_model(table->view());
    if (!first) return beam_model();
    return single ? single_scattering_model(*first, second) : solver_model(*first, second);
}

/// mu_in, mu_out, azimuth, brightness and sigma of observations.
using Observed = std::array<Doubles, 5>;

Observations make_observations(const Observed& observed, const std::vector<int>& light) {
    const auto& [mu_in, mu_out, azimuth, brightness, sigma] = observed;
    constexpr Light lights[] = {Light::reflected, Light::transmitted, Light::beam};
    Observations observations;
    for (std::size_t i = 0; i < light.size(); ++i)
        observations.push_back({{mu_in.data()[i], mu_out.data()[i], azimuth.data()[i]},
                                lights[light[i]],
                                brightness.data()[i],
                                sigma.data()[i]});
    return observations;
}

/// Sets what is known of the parameters of the model's family, by name.
void set_known(const LayerModel& model, const std::map<std::string, Doubles>& known,
               Observations& observations) {
    const FamilyAxes family = model.family();
    std::vector<std::string> names;
    for (const FamilyAxis& axis : family) names.emplace_back(axis.name());
    for (const auto& [name, values] : known)
        require(is_listed(name, names), "fit", "family",
                names.empty() ? "left out, for nothing varies" : "of " + joined(names), name);
    for (std::size_t i = 0; i < observations.size(); ++i) {
        std::vector<double> point(family.size(), std::numeric_limits<double>::quiet_NaN());
        for (std::size_t k = 0; k < family.size(); ++k)
            if (const auto found = known.find(names[k]); found != known.end())
                point[k] = found->second.data()[i];
        observations[i].known = FamilyPoint(point);
    }
}

/// The parameter of a name, as the model calls it.
std::size_t require_parameter(const LayerModel& model, const std::string& name,
                              const char* argument) {
    const auto names = fit_parameter_names(model);
    std::vector<FitParameter> parameters = model_parameters(model);
    std::sort(parameters.begin(), parameters.end());  // as answers have them
    std::vector<std::string> known;
    for (const FitParameter p : parameters) known.emplace_back(names[p]);
    const auto found = std::find(known.begin(), known.end(), name);
    require(found != known.end(), "fit", argument, "out of " + joined(known), name);
    return parameters[static_cast<std::size_t>(found - known.begin())];
}

FitOptions make_options(const LayerModel& model, const std::map<std::string, double>& fixed,
                        const std::vector<std::string>& free, double density,
                        const Opposition& opposition) {
    FitOptions options;
    options.density = density;
    options.opposition = opposition;
    for (const auto& [name, value] : fixed)
        options.*held_fields[require_parameter(model, name, "fixed")] = value;
    for (const std::string& name : free) {
        const std::size_t p = require_parameter(model, name, "free");
        require(!(options.*held_fields[p]), "fit", "free", "without what is fixed", name);
        if (p == fit_g1) options.free_g1 = true;
        if (p == fit_g2) options.free_g2 = true;
    }
    return options;
}

py::dict fit(const AnyTable* table, const std::optional<PhaseFunction>& first,
             const std::optional<PhaseFunction>& second, bool single, const Observed& observed,
             const std::vector<int>& light, const std::map<std::string, Doubles>& known,
             const std::map<std::string, double>& fixed, const std::vector<std::string>& free,
             double density, const OppositionParts& opposition) {
    const std::unique_ptr<LayerModel> by = make_model(table, first, second, single);
    const LayerModel& model = *by;
    const FitOptions options =
        make_options(model, fixed, free, density, make_opposition(opposition));
    Observations observations = make_observations(observed, light);
    set_known(model, known, observations);
    const Fit found = without_lock([&] { return fit_layer(model, observations, options); });
    const auto names = fit_parameter_names(model);
    const auto is_free = free_parameters(model, observations, options);
    py::dict value, deviation;
    std::vector<std::string> fitted;
    std::vector<double> covariance, correlation;
    for (std::size_t p = 0; p < fit_parameters; ++p) {
        if (!is_free[p]) continue;
        fitted.emplace_back(names[p]);
        value[names[p]] = found.estimate[p].value;
        deviation[names[p]] = found.estimate[p].sigma;
        for (std::size_t q = 0; q < fit_parameters; ++q)
            if (is_free[q]) {
                covariance.push_back(found.covariance[p][q]);
                correlation.push_back(found.correlation(p, q));
            }
    }
    for (const auto& [name, held] : fixed) value[name.c_str()] = held;
    using namespace py::literals;
    return py::dict("names"_a = fitted, "value"_a = value, "sigma"_a = deviation,
                    "covariance"_a = numpy_array(std::move(covariance)),
                    "correlation"_a = numpy_array(std::move(correlation)),
                    "model"_a = numpy_array(found.brightness), "chi_square"_a = found.chi_square,
                    "degrees_of_freedom"_a = found.degrees_of_freedom,
                    "probability"_a = found.probability, "remarks"_a = found.remarks);
}

}  // namespace

void add_fit(py::module_& module) { module.def("fit", fit); }

}  // namespace stratus::python
