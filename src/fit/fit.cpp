#include <stratus/fit/fit.h>

#include <stratus/runtime/argument.h>
#include <stratus/runtime/lookup.h>
#include <stratus/runtime/number_text.h>

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace stratus {
namespace {

constexpr const char* caller = "fit_layer";

/// log2 of the optical depth, albedo and mixture, each from 0 to 1 over the table's range.
using Place = Eigen::Vector3d;
enum Axis3 { depth_axis, albedo_axis, mixture_axis };

/// Chi-square by which a parameter is two standard deviations off.
constexpr double two_sigma = 4;

struct Layer {
    double optical_depth, albedo, mixture;
    double w1() const { return albedo * mixture; }
    double w2() const { return albedo * (1 - mixture); }
};

double between(double low, double high, double share) { return low + share * (high - low); }

class Problem {
  public:
    Problem(const TableView& table, const std::vector<Observation>& observations)
        : table_(table),
          observations_(observations),
          log_depth_{std::log2(table.optical_depth.lowest),
                     std::log2(table.optical_depth.highest)} {}

    Layer layer(const Place& at) const {
        return {std::exp2(between(log_depth_[0], log_depth_[1], at[depth_axis])),
                between(table_.albedo.lowest, table_.albedo.highest, at[albedo_axis]),
                between(table_.mixture.lowest, table_.mixture.highest, at[mixture_axis])};
    }

    double octaves() const { return log_depth_[1] - log_depth_[0]; }

    /// (model - observed) / sigma of all observations.
    Eigen::VectorXd residuals(const Place& at) const {
        const Layer layer = this->layer(at);
        const TableView mixed = table_.at_mixture(layer.mixture);
        Eigen::VectorXd residuals(static_cast<Eigen::Index>(observations_.size()));
        for (Eigen::Index i = 0; i < residuals.size(); ++i) {
            const Observation& observed = observations_[static_cast<std::size_t>(i)];
            residuals[i] = (brightness(mixed, layer.albedo, layer.optical_depth, observed) -
                            observed.brightness) /
                           observed.sigma;
        }
        return residuals;
    }

    /// Central differences of the interpolation, within the table; 0 by what is held.
    Eigen::MatrixX3d derivatives(const Place& at, std::optional<int> held = {}) const {
        constexpr double step = 1e-3;
        Eigen::MatrixX3d derivatives =
            Eigen::MatrixX3d::Zero(static_cast<Eigen::Index>(observations_.size()), 3);
        for (int p = 0; p < 3; ++p) {
            if (held == p) continue;
            Place above = at, below = at;
            above[p] = std::min(1.0, at[p] + step);
            below[p] = std::max(0.0, at[p] - step);
            derivatives.col(p) = (residuals(above) - residuals(below)) / (above[p] - below[p]);
        }
        return derivatives;
    }

    /// Derivatives of (ln depth, w1, w2) by the place.
    Eigen::Matrix3d parameters(const Place& at) const {
        const Layer layer = this->layer(at);
        const double albedo = table_.albedo.highest - table_.albedo.lowest;
        const double mixture = table_.mixture.highest - table_.mixture.lowest;
        Eigen::Matrix3d by_place;
        by_place << std::numbers::ln2 * octaves(), 0, 0,        //
            0, layer.mixture * albedo, layer.albedo * mixture,  //
            0, (1 - layer.mixture) * albedo, -layer.albedo * mixture;
        return by_place;
    }

  private:
    const TableView& table_;
    const std::vector<Observation>& observations_;
    std::array<double, 2> log_depth_;
};

struct Minimum {
    Place at;
    double chi_square;
};

/// Levenberg-Marquardt within the unit cube: a parameter at an edge stays there while downhill is
/// beyond it. `held` is one that is not varied. It ends with a step that gains less than `enough`
/// of chi-square and crosses less than its root of the cube.
Minimum descend(const Problem& problem, Place at, std::optional<int> held = {},
                double enough = 1e-8) {
    constexpr int max_steps = 60;
    constexpr double min_damping = 1e-9, max_damping = 1e9;
    Eigen::VectorXd residuals = problem.residuals(at);
    double chi_square = residuals.squaredNorm(), damping = 1e-3;
    for (int step = 0; step < max_steps; ++step) {
        const Eigen::MatrixX3d derivatives = problem.derivatives(at, held);
        const Eigen::Matrix3d curvature = derivatives.transpose() * derivatives;
        const Place slope = derivatives.transpose() * residuals;
        bool gained = false, small = true;
        for (; !gained && damping < max_damping; damping *= gained ? 0.1 : 10) {
            Eigen::Matrix3d damped = curvature;
            Place right = -slope;
            damped.diagonal() *= 1 + damping;
            damped.diagonal().array() += 1e-12 * curvature.trace() + min_damping;
            for (int p = 0; p < 3; ++p) {
                const bool outward = (at[p] <= 0 && slope[p] > 0) || (at[p] >= 1 && slope[p] < 0);
                if (!outward && held != p) continue;
                damped.row(p).setZero();
                damped.col(p).setZero();
                damped(p, p) = 1;
                right[p] = 0;
            }
            const Place next = (at + damped.ldlt().solve(right)).cwiseMax(0).cwiseMin(1);
            const Eigen::VectorXd there = problem.residuals(next);
            if (!(there.squaredNorm() < chi_square)) continue;
            gained = true;
            small = chi_square - there.squaredNorm() < enough * (1 + chi_square) &&
                    (next - at).cwiseAbs().maxCoeff() < std::sqrt(enough);
            at = next;
            residuals = there;
            chi_square = there.squaredNorm();
        }
        if (!gained || small) break;
        damping = std::max(damping, min_damping);
    }
    return {at, chi_square};
}

/// The depths that fit better than those beside them, whatever the albedos: one after another over
/// all the table, each from what fitted the one before.
std::vector<Place> starts(const Problem& problem) {
    constexpr int count = 24;
    constexpr double roughly = 1e-3;
    std::vector<Minimum> profile;
    Place at(0, 0.5, 0.5);
    for (int n = 0; n < count; ++n) {
        at[depth_axis] = n / (count - 1.0);
        profile.push_back(descend(problem, at, depth_axis, roughly));
        at = profile.back().at;
    }
    std::vector<Place> places;
    for (std::size_t n = 0; n < profile.size(); ++n) {
        const auto beats = [&](std::size_t other) {
            return other >= profile.size() || profile[n].chi_square <= profile[other].chi_square;
        };
        if (beats(n - 1) && beats(n + 1)) places.push_back(profile[n].at);
    }
    return places;
}

/// The least or the greatest depth, by bisection between the best and an edge, that fits within two
/// standard deviations whatever the albedos; nothing when even the edge does.
std::optional<double> limit_of_depth(const Problem& problem, const Minimum& best, double edge) {
    const auto excess = [&](double depth) {
        Place at = best.at;
        at[depth_axis] = depth;
        return descend(problem, at, depth_axis).chi_square - best.chi_square;
    };
    if (excess(edge) <= two_sigma) return {};
    double within = best.at[depth_axis], beyond = edge;
    for (int halving = 0; halving < 12; ++halving) {
        const double middle = (within + beyond) / 2;
        (excess(middle) <= two_sigma ? within : beyond) = middle;
    }
    Place at = best.at;
    at[depth_axis] = within;
    return problem.layer(at).optical_depth;
}

/// The depth is not determined when two standard deviations reach the table's edge, and then only
/// from one side if from any.
void remark_on_depth(const Problem& problem, const Minimum& best, double log_sigma, Fit& fit) {
    constexpr double well_known = 0.1;  // of ln depth; far from any edge but that which it is at
    if (log_sigma < well_known) return;
    const std::optional<double> least = limit_of_depth(problem, best, 0);
    const std::optional<double> greatest = limit_of_depth(problem, best, 1);
    if (least && greatest) return;
    std::string range = "anywhere in the table";
    if (least) range = "above " + short_number(*least, 3);
    if (greatest) range = "below " + short_number(*greatest, 3);
    fit.remarks.push_back("optical_depth not determined by these geometries (" + range + ")");
}

/// Directions of the covariance along which it reaches too far, by the parameters that they
/// change.
void remark_on_albedos(const Eigen::Matrix3d& covariance, Fit& fit) {
    constexpr double undetermined =
        0.25;  // standard deviation: two of them are half of all albedos
    constexpr const char* names[] = {"optical_depth", "w1", "w2"};
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance);
    std::string list;
    for (int p = 1; p < 3; ++p) {
        double furthest = 0;
        for (int k = 0; k < 3; ++k)
            furthest = std::max(furthest, std::sqrt(std::max(0.0, axes.eigenvalues()[k])) *
                                              std::abs(axes.eigenvectors()(p, k)));
        if (furthest > undetermined) list += (list.empty() ? "" : " and ") + std::string(names[p]);
    }
    if (!list.empty()) fit.remarks.push_back(list + " not determined by these geometries");
}

void remark_on_edges(const Problem& problem, const Minimum& best, Fit& fit) {
    const Layer layer = problem.layer(best.at);
    const double values[] = {layer.optical_depth, layer.albedo, layer.mixture};
    constexpr const char* names[] = {"optical_depth", "w1 + w2", "w1 / (w1 + w2)"};
    for (int p = 0; p < 3; ++p)
        if (best.at[p] <= 0 || best.at[p] >= 1)
            fit.remarks.push_back(std::string(names[p]) + " at the edge of the table (" +
                                  short_number(values[p], 3) + ")");
}

/// Other minima that two standard deviations do not tell from the best.
void remark_on_others(const Problem& problem, const std::vector<Minimum>& minima, Fit& fit) {
    constexpr double apart = 0.05;  // of the table's range
    const Minimum& best = minima.front();
    for (const Minimum& other : minima) {
        if (other.chi_square > best.chi_square + two_sigma) continue;
        if ((other.at - best.at).cwiseAbs().maxCoeff() < apart) continue;
        const Layer layer = problem.layer(other.at);
        fit.remarks.push_back(
            "w1 = " + short_number(layer.w1(), 3) + " w2 = " + short_number(layer.w2(), 3) +
            " optical_depth = " + short_number(layer.optical_depth, 3) +
            " with chi_square = " + short_number(other.chi_square, 3) + " fits as well");
        return;
    }
}

void check(const TableView& table, const std::vector<Observation>& observations) {
    require(table.has_mixture(), caller, "table", "one with a mixture axis", "one without");
    require(table.optical_depth.count >= 2 && table.albedo.count >= 2, caller, "table",
            "one of several optical depths and albedos", "one");
    require(observations.size() >= 3, caller, "observations", "three at least",
            observations.size());
    for (const Observation& at : observations) {
        const auto is_cosine = [](double mu) { return mu > 0 && mu <= 1; };
        require(is_cosine(at.geometry.mu_in), caller, "mu_in", "in (0, 1]", at.geometry.mu_in);
        require(is_cosine(at.geometry.mu_out), caller, "mu_out", "in (0, 1]", at.geometry.mu_out);
        require(std::isfinite(at.geometry.azimuth), caller, "azimuth", "finite",
                at.geometry.azimuth);
        require(std::isfinite(at.brightness), caller, "brightness", "finite", at.brightness);
        require(at.sigma > 0 && std::isfinite(at.sigma), caller, "sigma", "in (0, inf)", at.sigma);
        require(at.transmitted ? table.has_transmission() : table.has_reflection(), caller,
                "observed side", "one that the table holds",
                at.transmitted ? "transmission" : "reflection");
    }
}

}  // namespace

double brightness(const TableView& table, double albedo, double optical_depth,
                  const Observation& observation) noexcept {
    const auto look_up = observation.transmitted ? transmission : reflection;
    return observation.geometry.mu_in *
           look_up(table, albedo, optical_depth, observation.geometry).total();
}

Fit fit_layer(const TableView& table, const std::vector<Observation>& observations) {
    check(table, observations);
    const Problem problem(table, observations);
    std::vector<Minimum> minima;
    for (const Place& start : starts(problem)) minima.push_back(descend(problem, start));
    std::ranges::sort(minima, {}, &Minimum::chi_square);
    const Minimum& best = minima.front();

    // The covariance of the place, then of (ln depth, w1, w2). What is known of a direction that
    // changes nothing is that it ends with the table.
    constexpr double min_curvature = 1;
    const Eigen::MatrixX3d derivatives = problem.derivatives(best.at);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> curvature(derivatives.transpose() *
                                                                   derivatives);
    const Eigen::Matrix3d place_covariance =
        curvature.eigenvectors() *
        curvature.eigenvalues().cwiseMax(min_curvature).cwiseInverse().asDiagonal() *
        curvature.eigenvectors().transpose();
    const Eigen::Matrix3d by_place = problem.parameters(best.at);
    const Eigen::Matrix3d covariance = by_place * place_covariance * by_place.transpose();
    const auto sigma = [&](int p) { return std::sqrt(covariance(p, p)); };

    const Layer layer = problem.layer(best.at);
    Fit fit{{layer.w1(), sigma(1)},
            {layer.w2(), sigma(2)},
            {layer.optical_depth, layer.optical_depth * sigma(0)},
            best.chi_square,
            static_cast<int>(observations.size()) - 3,
            {}};
    remark_on_depth(problem, best, sigma(0), fit);
    remark_on_albedos(covariance, fit);
    if (fit.remarks.empty()) remark_on_others(problem, minima, fit);
    remark_on_edges(problem, best, fit);
    return fit;
}

}  // namespace stratus
