#include "least_squares.h"

#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

namespace stratus {
namespace {

/// The rise of chi-square two standard deviations away from the best fit.
constexpr double two_sigma = 4;

/// The limit, between the best depth and an edge, of the depths that fit within two standard
/// deviations with the best of all others for each; none when the edge fits too. By bisection.
std::optional<double> limit_of_depth(const Problem& problem, const Minimum& best, int depth,
                                     double edge) {
    const auto excess = [&](double place) {
        Problem::Point at = best.at;
        at[depth] = place;
        return descend(problem, at, depth).chi_square - best.chi_square;
    };
    if (excess(edge) <= two_sigma) return {};
    double inside = best.at[depth], outside = edge;
    for (int halving = 0; halving < 12; ++halving) {
        const double middle = (inside + outside) / 2;
        (excess(middle) <= two_sigma ? inside : outside) = middle;
    }
    return problem.space().value(depth, inside);
}

/// The depth is not determined when two standard deviations reach an edge of its range; it may
/// still be limited from the other side.
void remark_on_depth(const Problem& problem, const Minimum& best, double log_sigma, Fit& fit) {
    constexpr double well_known = 0.1;  // of ln depth: no other edge is within reach
    const int depth = problem.space().place(Coordinate::depth);
    if (depth < 0 || log_sigma < well_known) return;
    const std::optional<double> min_depth = limit_of_depth(problem, best, depth, 0);
    const std::optional<double> max_depth = limit_of_depth(problem, best, depth, 1);
    if (min_depth && max_depth) return;
    std::string range = "anywhere in its range";
    if (min_depth) range = "above " + short_number(*min_depth, 3);
    if (max_depth) range = "below " + short_number(*max_depth, 3);
    fit.remarks.push_back("optical_depth not determined by these geometries (" + range + ")");
}

/// Names the albedos and parameters of phase functions that change along an axis of the covariance
/// that is too long: two such standard deviations span half of all values.
void remark_on_particles(const LayerModel& model, const ParameterSpace& space,
                         const Eigen::MatrixXd& covariance, Fit& fit) {
    const auto names = fit_parameter_names(model);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(covariance);
    std::vector<std::string> list;
    for (int p = fit_w1; p < fit_parameters; ++p) {
        double furthest = 0;
        for (int k = 0; k < fit_parameters; ++k)
            furthest = std::max(furthest, std::sqrt(std::max(0.0, axes.eigenvalues()[k])) *
                                              std::abs(axes.eigenvectors()(p, k)));
        const double extent = p <= fit_w2 ? 1 : space.extent(static_cast<FitParameter>(p));
        if (extent > 0 && furthest > extent / 4) list.push_back(names[static_cast<std::size_t>(p)]);
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
void remark_on_other_minima(const Problem& problem, const LayerModel& model,
                            const std::vector<Minimum>& minima, Fit& fit) {
    constexpr double min_distance = 0.05;  // of a range
    const Minimum& best = minima.front();
    for (const Minimum& other : minima) {
        if (other.chi_square > best.chi_square + two_sigma) continue;
        if (best.at.size() == 0 || (other.at - best.at).cwiseAbs().maxCoeff() < min_distance)
            continue;
        const LayerParameters layer = problem.space().layer(other.at);
        const auto names = fit_parameter_names(model);
        std::string text;
        const auto say = [&](FitParameter p) {
            text += std::string(names[p]) + " = " + short_number(layer.*layer_fields[p], 3) + " ";
        };
        say(fit_w1);
        if (model.kinds() == 2) say(fit_w2);
        say(fit_optical_depth);
        for (const Coordinate of : of_phase_functions)
            if (problem.space().place(of) >= 0) say(static_cast<FitParameter>(of));
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

}  // namespace

void add_remarks(const Problem& problem, const LayerModel& model,
                 const std::vector<Minimum>& minima, const Eigen::MatrixXd& covariance, Fit& fit) {
    const Minimum& best = minima.front();
    remark_on_depth(problem, best, std::sqrt(covariance(fit_optical_depth, fit_optical_depth)),
                    fit);
    remark_on_particles(model, problem.space(), covariance, fit);
    if (fit.remarks.empty()) remark_on_other_minima(problem, model, minima, fit);
    remark_on_edges(problem.space(), best, fit);
    remark_on_chi_square(fit);
}

}  // namespace stratus
