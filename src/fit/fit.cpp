#include <stratus/fit/fit.h>

#include <stratus/base/number_text.h>

#include "least_squares.h"

#include <Eigen/Eigenvalues>

#include <cmath>

namespace stratus {
namespace {

using Eigen::MatrixXd;

constexpr const char* light_names[] = {"reflected light", "transmitted light", "a beam"};

void check(const Observation& at, const LayerModel& model, const FamilyAxes& family) {
    const auto& [geometry, light, brightness, sigma, known] = at;
    require_in("(0, 1]", fit_caller, "mu_out", geometry.mu_out);
    if (light != Light::beam) {
        require_in("(0, 1]", fit_caller, "mu_in", geometry.mu_in);
        require(std::isfinite(geometry.azimuth), fit_caller, "azimuth", "finite", geometry.azimuth);
    }
    require(std::isfinite(brightness), fit_caller, "brightness", "finite", brightness);
    require_in("(0, inf)", fit_caller, "sigma", sigma);
    require_in("[1e-100, 1e100], so that its square is a number", fit_caller, "sigma", sigma);
    require_in("[-1e100, 1e100], so that its square is a number", fit_caller, "brightness / sigma",
               brightness / sigma);
    require(model.has(light), fit_caller, "observed light", "such as the model knows",
            light_names[static_cast<std::size_t>(light)]);
    model.check_directions(fit_caller, at);
    require(known.size() <= family.size(), fit_caller, "values known of an observation",
            "as many as the table's family has axes, " + std::to_string(family.size()),
            known.size());
    for (std::size_t k = 0; k < known.size(); ++k)
        require(std::isnan(known[k]) || holds(family[k], known[k]), fit_caller, family[k].name(),
                allowed_text(family[k]), known[k]);
}

void check(const LayerModel& model, const Observations& observations, const FitOptions& options) {
    Effects known;
    known.density = options.density;
    known.opposition = options.opposition;
    check_effects(known);
    require(!options.opposition.is_present() || !model.has_lower_boundary(), fit_caller,
            "opposition", "none over a lower boundary", "a law");
    const FamilyAxes family = model.family();
    for (const Observation& at : observations) check(at, model, family);
}

/// In the terms of ParameterSpace::derivatives: the inverse of the curvature in the cube, mapped. A
/// direction in which the residuals do not change is bounded by the cube's edge alone.
MatrixXd compute_covariance(const Problem& problem, const Problem::Point& at) {
    constexpr double min_curvature = 1;
    if (at.size() == 0) return MatrixXd::Zero(fit_parameters, fit_parameters);
    const MatrixXd derivatives = problem.derivatives(at);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> curvature(derivatives.transpose() * derivatives);
    const MatrixXd in_cube =
        curvature.eigenvectors() *
        curvature.eigenvalues().cwiseMax(min_curvature).cwiseInverse().asDiagonal() *
        curvature.eigenvectors().transpose();
    const MatrixXd jacobian = problem.space.derivatives(at);
    return jacobian * in_cube * jacobian.transpose();
}

/// The rise of chi-square two standard deviations away from the best fit.
constexpr double two_sigma = 4;

/// The limit, between the best depth and an edge, of the depths that fit within two standard
/// deviations with the best of all others for each; none when the edge fits too. By bisection.
std::optional<Problem::Point> limit_of_depth(const Problem& problem, const Minimum& best, int depth,
                                             double edge) {
    const auto at_depth = [&](double place) {
        Problem::Point at = best.at;
        at[depth] = place;
        return descend(problem, at, depth);
    };
    const auto fits = [&](const Minimum& other) {
        return other.chi_square - best.chi_square <= two_sigma;
    };
    if (fits(at_depth(edge))) return {};
    Problem::Point limit = best.at;
    double outside = edge;
    for (int halving = 0; halving < 12; ++halving) {
        const Minimum middle = at_depth((limit[depth] + outside) / 2);
        if (fits(middle))
            limit = middle.at;
        else
            outside = middle.at[depth];
    }
    return limit;
}

/// The depth is not determined when two standard deviations reach an edge of its range; it may
/// still be limited from the other side. Returns its limits where it is known to less than a tenth.
std::vector<Problem::Point> remark_on_depth(const Problem& problem, const Minimum& best,
                                            double log_sigma, Fit& fit) {
    constexpr double well_known = 0.1;  // of ln depth: no other edge is within reach
    const int depth = problem.space.place(fit_optical_depth);
    if (depth < 0 || log_sigma < well_known) return {};
    const auto lowest = limit_of_depth(problem, best, depth, 0),
               highest = limit_of_depth(problem, best, depth, 1);
    std::vector<Problem::Point> limits;
    for (const auto& limit : {lowest, highest})
        if (limit) limits.push_back(*limit);
    if (limits.size() == 2) return limits;
    std::string range = "anywhere in its range";
    const auto text = [&](const Problem::Point& limit) {
        return short_number(problem.space.value(depth, limit[depth]), 3);
    };
    if (lowest) range = "above " + text(*lowest);
    if (highest) range = "below " + text(*highest);
    fit.remarks.push_back("optical_depth not determined by these geometries (" + range + ")");
    return limits;
}

/// Names the albedos and parameters of phase functions that change along an axis of the covariance
/// that is too long, or from the best fit to a limit of the depth: two such standard deviations span
/// half of all values. Of a thin layer, whose albedo times depth alone is known, the covariance ends
/// short of albedos that fit as well.
void remark_on_particles(const Problem& problem, const Minimum& best, const MatrixXd& covariance,
                         const std::vector<Problem::Point>& depth_limits, Fit& fit) {
    const auto names = fit_parameter_names(problem.model);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(covariance);
    const LayerParameters layer = problem.space.layer(best.at);
    std::vector<std::string> list;
    for (std::size_t p = fit_w1; p < fit_parameters; ++p) {
        double furthest = 0;
        for (int k = 0; k < fit_parameters; ++k)
            furthest = std::max(furthest, std::sqrt(std::max(0.0, axes.eigenvalues()[k])) *
                                              std::abs(axes.eigenvectors()(index(p), k)));
        const double extent = p <= fit_w2 ? 1 : problem.space.extent(p);
        for (const Problem::Point& limit : depth_limits) {  // two standard deviations away
            const double there = problem.space.layer(limit).*layer_fields[p],
                         here = layer.*layer_fields[p];
            furthest = std::max(
                furthest,
                std::abs(problem.space.is_logarithm(p) ? std::log(there / here) : there - here) /
                    2);
        }
        if (extent > 0 && furthest > extent / 4) list.push_back(names[p]);
    }
    if (!list.empty())
        fit.remarks.push_back(joined(list, " and ") + " not determined by these geometries");
}

void remark_on_edges(const ParameterSpace& space, const Minimum& best, Fit& fit) {
    for (int p = 0; p < space.size(); ++p)
        if (best.at[p] <= 0 || best.at[p] >= 1)
            fit.remarks.push_back(space.name(p) + " at the edge of its range (" +
                                  short_number(space.value(p, best.at[p]), 3) + ")");
}

/// Another minimum within two standard deviations of the best.
void remark_on_other_minima(const Problem& problem, const std::vector<Minimum>& minima, Fit& fit) {
    constexpr double min_distance = 0.05;  // of a range
    const Minimum& best = minima.front();
    for (const Minimum& other : minima) {
        if (other.chi_square > best.chi_square + two_sigma) continue;
        if (best.at.size() == 0 || (other.at - best.at).cwiseAbs().maxCoeff() < min_distance)
            continue;
        const LayerParameters layer = problem.space.layer(other.at);
        const auto names = fit_parameter_names(problem.model);
        std::string text;
        const auto say = [&](FitParameter p) {
            text += std::string(names[p]) + " = " + short_number(layer.*layer_fields[p], 3) + " ";
        };
        say(fit_w1);
        if (problem.model.kinds() == 2) say(fit_w2);
        say(fit_optical_depth);
        for (const FitParameter of : of_phase_functions)
            if (problem.space.place(of) >= 0) say(of);
        fit.remarks.push_back(text + "with chi_square = " + short_number(other.chi_square, 3) +
                              " fits as well");
        return;
    }
}

void remark_on_chi_square(Fit& fit) {
    if (fit.probability >= refusing_probability) return;
    const int degrees = fit.degrees_of_freedom;
    fit.remarks.push_back(
        "refused: chi_square " + short_number(fit.chi_square, 3) + " for " +
        std::to_string(degrees) + " degree" + (degrees == 1 ? "" : "s") +
        " of freedom (probability " +
        (fit.probability > 0 ? short_number(fit.probability, 2) : std::string("below 1e-300")) +
        ")");
}

/// Adds the remarks of a fit whose estimates, covariance and chi-square are known. `covariance` is
/// in the terms of ParameterSpace::derivatives; `minima` are sorted, the best first.
void add_remarks(const Problem& problem, const std::vector<Minimum>& minima,
                 const MatrixXd& covariance, Fit& fit) {
    const Minimum& best = minima.front();
    const std::vector<Problem::Point> depth_limits = remark_on_depth(
        problem, best, std::sqrt(covariance(fit_optical_depth, fit_optical_depth)), fit);
    remark_on_particles(problem, best, covariance, depth_limits, fit);
    if (fit.remarks.empty()) remark_on_other_minima(problem, minima, fit);
    remark_on_edges(problem.space, best, fit);
    if (!best.is_reached)
        fit.remarks.push_back("not at a minimum: chi_square was still falling after " +
                              std::to_string(most_steps) + " steps");
    remark_on_chi_square(fit);
}

/// The best fit near these starts; where the model's error is too large there, from its minima by
/// a finer one.
Fit fit_near(std::vector<Minimum> minima, const Problem& problem) {
    const auto& [model, space, observations, options] = problem;
    for (Minimum& minimum : minima) minimum = descend(problem, minimum.at);
    std::ranges::sort(minima, {}, &Minimum::chi_square);
    const Minimum& best = minima.front();
    const MatrixXd covariance = compute_covariance(problem, best.at);

    const LayerParameters layer = space.layer(best.at);
    constexpr double tolerated = 0.1;  // standard deviations
    LayerParameters met = layer;
    met.optical_depth = effective_optical_depth(layer.optical_depth, options.density);
    const double error = model.error(met, observations);
    if (error > tolerated)
        if (const auto finer = model.refined(met, observations, tolerated))
            return fit_near(minima, {*finer, space, observations, options});

    Fit fit;
    const auto scale = [&](std::size_t p) {  // from the variance of a logarithm
        return problem.space.is_logarithm(p) ? layer.*layer_fields[p] : 1;
    };
    for (std::size_t p = 0; p < fit_parameters; ++p) {
        for (std::size_t q = 0; q < fit_parameters; ++q)
            fit.covariance[p][q] = scale(p) * scale(q) * covariance(index(p), index(q));
        fit.estimate[p] = {layer.*layer_fields[p], std::sqrt(fit.covariance[p][p])};
    }
    const Eigen::VectorXd misses = problem.residuals(best.at);
    for (std::size_t i = 0; i < observations.size(); ++i)
        fit.brightness.push_back(observations[i].brightness +
                                 observations[i].sigma * misses(index(i)));
    fit.chi_square = best.chi_square;
    fit.degrees_of_freedom = int_size(observations) - space.size();
    const auto at_edges = static_cast<int>((best.at.array() <= 0 || best.at.array() >= 1).count());
    // Chi-square is 0 with as many parameters as observations, unless some change no light there.
    const int degrees = fit.degrees_of_freedom > 0 ? fit.degrees_of_freedom : std::max(at_edges, 1);
    fit.probability = chi_square_probability(fit.chi_square, degrees);
    add_remarks(problem, minima, covariance, fit);
    if (error > tolerated)
        fit.remarks.push_back(std::string(model.error_name()) + " reaches " +
                              short_number(error, 2) + " standard deviations of an observation");
    return fit;
}

}  // namespace

std::array<const char*, fit_parameters> fit_parameter_names(const LayerModel& model) {
    const bool one = model.kinds() < 2;
    return {"optical_depth", one ? "w" : "w1", "w2",      one ? "g" : "g1", "g2",
            "radius",        "wavelength",     "variance"};
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
                                                 const Observations& observations,
                                                 const FitOptions& options) {
    const ParameterSpace space(model, observations, options);
    std::array<bool, fit_parameters> free{};
    const MatrixXd derivatives = space.derivatives(space.start());
    for (std::size_t p = 0; p < fit_parameters; ++p) free[p] = !derivatives.row(index(p)).isZero(0);
    return free;
}

std::size_t free_parameter_count(const LayerModel& model, const Observations& observations,
                                 const FitOptions& options) {
    return size(ParameterSpace(model, observations, options).size());
}

Fit fit_layer(const LayerModel& model, const Observations& observations,
              const FitOptions& options) {
    check(model, observations, options);
    const ParameterSpace space(model, observations, options);
    const auto needed = size(std::max(space.size(), 1));
    require(observations.size() >= needed, fit_caller, "observations",
            "at least " + std::to_string(needed) + ", one for each free parameter",
            observations.size());
    const Problem problem{model, space, observations, options};
    return fit_near(scan_minima(problem), problem);
}

Fit fit_layer(const TableView& table, const Observations& observations, const FitOptions& options) {
    return fit_layer(*table_model(table), observations, options);
}

}  // namespace stratus
