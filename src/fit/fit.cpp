#include <stratus/fit/fit.h>

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>

#include "least_squares.h"

#include <Eigen/Eigenvalues>

#include <cmath>

namespace stratus {
namespace {

const char* light_name(Light light) {
    switch (light) {
        case Light::reflected: return "reflected light";
        case Light::transmitted: return "transmitted light";
        case Light::beam: return "a beam";
    }
    return "";
}

void check(const Observation& at, const LayerModel& model, const std::vector<FamilyAxis>& family) {
    const auto is_cosine = [](double mu) { return mu > 0 && mu <= 1; };
    require(is_cosine(at.geometry.mu_out), fit_caller, "mu_out", "in (0, 1]", at.geometry.mu_out);
    if (at.light != Light::beam) {
        require(is_cosine(at.geometry.mu_in), fit_caller, "mu_in", "in (0, 1]", at.geometry.mu_in);
        require(std::isfinite(at.geometry.azimuth), fit_caller, "azimuth", "finite",
                at.geometry.azimuth);
    }
    require(std::isfinite(at.brightness), fit_caller, "brightness", "finite", at.brightness);
    require(at.sigma > 0 && std::isfinite(at.sigma), fit_caller, "sigma", "in (0, inf)", at.sigma);
    // Whose squares, and sums of them, are numbers.
    constexpr double largest = 1e100;
    require(at.sigma >= 1 / largest && at.sigma <= largest, fit_caller, "sigma",
            "in [1e-100, 1e100], so that its square is a number", at.sigma);
    require(std::abs(at.brightness / at.sigma) <= largest, fit_caller, "brightness / sigma",
            "in [-1e100, 1e100], so that its square is a number", at.brightness / at.sigma);
    require(model.has(at.light), fit_caller, "observed light", "such as the model knows",
            light_name(at.light));
    require(at.known.size() <= family.size(), fit_caller, "values known of an observation",
            "as many as the table's family has axes, " + std::to_string(family.size()),
            at.known.size());
    for (std::size_t k = 0; k < at.known.size(); ++k)
        require(std::isnan(at.known[k]) || holds(family[k], at.known[k]), fit_caller,
                family[k].name(), allowed_text(family[k]), at.known[k]);
}

void check(const LayerModel& model, const std::vector<Observation>& observations,
           const FitOptions& options) {
    Effects known;
    known.density = options.density;
    known.opposition = options.opposition;
    check_effects(known);
    require(options.opposition.law == Opposition::Law::none || !model.has_lower_boundary(),
            fit_caller, "opposition", "none over a lower boundary", "a law");
    const std::vector<FamilyAxis> family = model.family();
    for (const Observation& at : observations) check(at, model, family);
}

/// Local minima near these, the best first.
std::vector<Minimum> descend_from(std::vector<Minimum> minima, const Problem& problem) {
    for (Minimum& minimum : minima) minimum = descend(problem, minimum.at);
    std::ranges::sort(minima, {}, &Minimum::chi_square);
    return minima;
}

/// In the terms of ParameterSpace::derivatives: the inverse of the curvature in the cube, mapped. A
/// direction in which the residuals do not change is bounded by the cube's edge alone.
Eigen::MatrixXd compute_covariance(const Problem& problem, const Problem::Point& at) {
    constexpr double min_curvature = 1;
    if (at.size() == 0) return Eigen::MatrixXd::Zero(fit_parameters, fit_parameters);
    const Eigen::MatrixXd derivatives = problem.derivatives(at);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> curvature(derivatives.transpose() *
                                                                   derivatives);
    const Eigen::MatrixXd in_cube =
        curvature.eigenvectors() *
        curvature.eigenvalues().cwiseMax(min_curvature).cwiseInverse().asDiagonal() *
        curvature.eigenvectors().transpose();
    const Eigen::MatrixXd jacobian = problem.space().derivatives(at);
    return jacobian * in_cube * jacobian.transpose();
}

/// The best fit near these starts; where the model's error is too large there, from its minima by
/// a finer one.
Fit fit_near(const std::vector<Minimum>& starts, const LayerModel& model,
             const ParameterSpace& space, const std::vector<Observation>& observations,
             const FitOptions& options) {
    const Problem problem(model, space, observations, options);
    const std::vector<Minimum> minima = descend_from(starts, problem);
    const Minimum& best = minima.front();
    const Eigen::MatrixXd covariance = compute_covariance(problem, best.at);

    const LayerParameters layer = space.layer(best.at);
    constexpr double tolerated = 0.1;  // standard deviations
    const double error = model.error(layer, observations);
    if (error > tolerated)
        if (const auto finer = model.refined(layer, observations, tolerated))
            return fit_near(minima, *finer, space, observations, options);

    Fit fit;
    const auto scale = [&](std::size_t p) {  // from the variance of a logarithm
        return space.is_logarithm(static_cast<FitParameter>(p)) ? layer.*layer_fields[p] : 1;
    };
    for (std::size_t p = 0; p < fit_parameters; ++p) {
        for (std::size_t q = 0; q < fit_parameters; ++q)
            fit.covariance[p][q] =
                scale(p) * scale(q) *
                covariance(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(q));
        fit.estimate[p] = {layer.*layer_fields[p], std::sqrt(fit.covariance[p][p])};
    }
    const Eigen::VectorXd misses = problem.residuals(best.at);
    for (std::size_t i = 0; i < observations.size(); ++i)
        fit.brightness.push_back(observations[i].brightness +
                                 observations[i].sigma * misses(static_cast<Eigen::Index>(i)));
    fit.chi_square = best.chi_square;
    fit.degrees_of_freedom = static_cast<int>(observations.size()) - space.size();
    if (fit.degrees_of_freedom > 0)
        fit.probability = chi_square_probability(fit.chi_square, fit.degrees_of_freedom);
    add_remarks(problem, model, minima, covariance, fit);
    if (error > tolerated)
        fit.remarks.push_back("the solver's error reaches " + short_number(error, 2) +
                              " standard deviations of an observation");
    return fit;
}

}  // namespace

std::array<const char*, fit_parameters> fit_parameter_names(const LayerModel& model) {
    if (model.kinds() < 2)
        return {"optical_depth", "w", "w2", "g", "g2", "radius", "wavelength", "variance"};
    return {"optical_depth", "w1", "w2", "g1", "g2", "radius", "wavelength", "variance"};
}

std::vector<FitParameter> model_parameters(const LayerModel& model) {
    if (model.kinds() == 0) return {fit_optical_depth};
    std::vector<FitParameter> parameters{fit_w1, fit_optical_depth, fit_g1};
    if (model.kinds() == 2) parameters = {fit_w1, fit_w2, fit_optical_depth, fit_g1, fit_g2};
    for (const FamilyAxis& axis : model.family())
        if (const auto of = to_fit_parameter(axis.parameter); of && *of != fit_g1)
            parameters.push_back(*of);
    return parameters;
}

std::array<bool, fit_parameters> free_parameters(const LayerModel& model,
                                                 const std::vector<Observation>& observations,
                                                 const FitOptions& options) {
    const ParameterSpace space(model, observations, options);
    std::array<bool, fit_parameters> free{};
    const Eigen::MatrixXd derivatives = space.derivatives(space.start());
    for (std::size_t p = 0; p < fit_parameters; ++p)
        free[p] = !derivatives.row(static_cast<Eigen::Index>(p)).isZero(0);
    return free;
}

std::size_t free_parameter_count(const LayerModel& model,
                                 const std::vector<Observation>& observations,
                                 const FitOptions& options) {
    return size(ParameterSpace(model, observations, options).size());
}

Fit fit_layer(const LayerModel& model, const std::vector<Observation>& observations,
              const FitOptions& options) {
    check(model, observations, options);
    const ParameterSpace space(model, observations, options);
    const auto needed = size(std::max(space.size(), 1));
    require(observations.size() >= needed, fit_caller, "observations",
            "at least " + std::to_string(needed) + ", one for each free parameter",
            observations.size());
    const Problem problem(model, space, observations, options);
    return fit_near(scan_minima(problem), model, space, observations, options);
}

Fit fit_layer(const TableView& table, const std::vector<Observation>& observations,
              const FitOptions& options) {
    return fit_layer(*table_model(table), observations, options);
}

}  // namespace stratus
