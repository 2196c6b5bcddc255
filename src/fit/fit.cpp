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

/// A point of the unit cube: log2 of the optical depth, albedo and mixture, each from 0 to 1 over
/// the table's range.
using CubePoint = Eigen::Vector3d;
enum Axis3 { depth_axis, albedo_axis, mixture_axis };

/// The rise of chi-square two standard deviations away from the best fit.
constexpr double two_sigma = 4;

struct LayerParameters {
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

    LayerParameters layer(const CubePoint& at) const {
        return {std::exp2(between(log_depth_[0], log_depth_[1], at[depth_axis])),
                between(table_.albedo.lowest, table_.albedo.highest, at[albedo_axis]),
                between(table_.mixture.lowest, table_.mixture.highest, at[mixture_axis])};
    }

    double octaves() const { return log_depth_[1] - log_depth_[0]; }

    /// (model - observed) / sigma of all observations.
    Eigen::VectorXd residuals(const CubePoint& at) const {
        const LayerParameters layer = this->layer(at);
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

    /// Central differences of the residuals, within the table; 0 for the parameter that is held.
    Eigen::MatrixX3d derivatives(const CubePoint& at, std::optional<int> held = {}) const {
        constexpr double step = 1e-3;
        Eigen::MatrixX3d derivatives =
            Eigen::MatrixX3d::Zero(static_cast<Eigen::Index>(observations_.size()), 3);
        for (int p = 0; p < 3; ++p) {
            if (held == p) continue;
            CubePoint upper = at, lower = at;
            upper[p] = std::min(1.0, at[p] + step);
            lower[p] = std::max(0.0, at[p] - step);
            derivatives.col(p) = (residuals(upper) - residuals(lower)) / (upper[p] - lower[p]);
        }
        return derivatives;
    }

    /// Derivatives of (ln depth, w1, w2) with respect to the point.
    Eigen::Matrix3d parameter_derivatives(const CubePoint& at) const {
        const LayerParameters layer = this->layer(at);
        const double albedo = table_.albedo.highest - table_.albedo.lowest;
        const double mixture = table_.mixture.highest - table_.mixture.lowest;
        Eigen::Matrix3d derivatives;
        derivatives << std::numbers::ln2 * octaves(), 0, 0,     //
            0, layer.mixture * albedo, layer.albedo * mixture,  //
            0, (1 - layer.mixture) * albedo, -layer.albedo * mixture;
        return derivatives;
    }

  private:
    const TableView& table_;
    const std::vector<Observation>& observations_;
    std::array<double, 2> log_depth_;
};

struct Minimum {
    CubePoint at;
    double chi_square;
};

/// Levenberg-Marquardt within the unit cube: a parameter at an edge stays there while chi-square
/// falls outwards. `held` is one that is not varied. Ends with a step that lowers chi-square by
/// less than the share `tolerance` and is shorter than the root of it.
Minimum descend(const Problem& problem, CubePoint at, std::optional<int> held = {},
                double tolerance = 1e-8) {
    constexpr int max_steps = 60;
    constexpr double min_damping = 1e-9, max_damping = 1e9;
    Eigen::VectorXd residuals = problem.residuals(at);
    double chi_square = residuals.squaredNorm(), damping = 1e-3;
    for (int step = 0; step < max_steps; ++step) {
        const Eigen::MatrixX3d derivatives = problem.derivatives(at, held);
        const Eigen::Matrix3d curvature = derivatives.transpose() * derivatives;
        const CubePoint slope = derivatives.transpose() * residuals;
        bool improved = false, converged = true;
        for (; !improved && damping < max_damping; damping *= improved ? 0.1 : 10) {
            Eigen::Matrix3d damped = curvature;
            CubePoint right_side = -slope;
            damped.diagonal() *= 1 + damping;
            damped.diagonal().array() += 1e-12 * curvature.trace() + min_damping;
            for (int p = 0; p < 3; ++p) {
                const bool outward = (at[p] <= 0 && slope[p] > 0) || (at[p] >= 1 && slope[p] < 0);
                if (!outward && held != p) continue;
                damped.row(p).setZero();
                damped.col(p).setZero();
                damped(p, p) = 1;
                right_side[p] = 0;
            }
            const CubePoint next = (at + damped.ldlt().solve(right_side)).cwiseMax(0).cwiseMin(1);
            const Eigen::VectorXd next_residuals = problem.residuals(next);
            if (!(next_residuals.squaredNorm() < chi_square)) continue;
            improved = true;
            converged = chi_square - next_residuals.squaredNorm() < tolerance * (1 + chi_square) &&
                        (next - at).cwiseAbs().maxCoeff() < std::sqrt(tolerance);
            at = next;
            residuals = next_residuals;
            chi_square = next_residuals.squaredNorm();
        }
        if (!improved || converged) break;
        damping = std::max(damping, min_damping);
    }
    return {at, chi_square};
}

/// Local minima over the optical depth, the albedos fitted at each: a scan of the table's depths,
/// each fit starting from the one before.
std::vector<CubePoint> starts(const Problem& problem) {
    constexpr int count = 24;
    constexpr double rough_tolerance = 1e-3;
    std::vector<Minimum> profile;
    CubePoint at(0, 0.5, 0.5);
    for (int n = 0; n < count; ++n) {
        at[depth_axis] = n / (count - 1.0);
        profile.push_back(descend(problem, at, depth_axis, rough_tolerance));
        at = profile.back().at;
    }
    std::vector<CubePoint> minima;
    for (std::size_t n = 0; n < profile.size(); ++n) {
        const auto is_below = [&](std::size_t other) {
            return other >= profile.size() || profile[n].chi_square <= profile[other].chi_square;
        };
        if (is_below(n - 1) && is_below(n + 1)) minima.push_back(profile[n].at);
    }
    return minima;
}

/// The limit, between the best depth and an edge, of the depths that fit within two standard
/// deviations with the best albedos for each; none when the edge fits too. By bisection.
std::optional<double> limit_of_depth(const Problem& problem, const Minimum& best, double edge) {
    const auto excess = [&](double depth) {
        CubePoint at = best.at;
        at[depth_axis] = depth;
        return descend(problem, at, depth_axis).chi_square - best.chi_square;
    };
    if (excess(edge) <= two_sigma) return {};
    double inside = best.at[depth_axis], outside = edge;
    for (int halving = 0; halving < 12; ++halving) {
        const double middle = (inside + outside) / 2;
        (excess(middle) <= two_sigma ? inside : outside) = middle;
    }
    CubePoint at = best.at;
    at[depth_axis] = inside;
    return problem.layer(at).optical_depth;
}

/// The depth is not determined when two standard deviations reach an edge of the table; it may
/// still be limited from the other side.
void remark_on_depth(const Problem& problem, const Minimum& best, double log_sigma, Fit& fit) {
    constexpr double well_known = 0.1;  // of ln depth: no other edge is within reach
    if (log_sigma < well_known) return;
    const std::optional<double> min_depth = limit_of_depth(problem, best, 0);
    const std::optional<double> max_depth = limit_of_depth(problem, best, 1);
    if (min_depth && max_depth) return;
    std::string range = "anywhere in the table";
    if (min_depth) range = "above " + short_number(*min_depth, 3);
    if (max_depth) range = "below " + short_number(*max_depth, 3);
    fit.remarks.push_back("optical_depth not determined by these geometries (" + range + ")");
}

/// Names the albedos that change along an axis of the covariance that is too long.
void remark_on_albedos(const Eigen::Matrix3d& covariance, Fit& fit) {
    constexpr double undetermined = 0.25;  // two such standard deviations span half of all albedos
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
    const LayerParameters layer = problem.layer(best.at);
    const double values[] = {layer.optical_depth, layer.albedo, layer.mixture};
    constexpr const char* names[] = {"optical_depth", "w1 + w2", "w1 / (w1 + w2)"};
    for (int p = 0; p < 3; ++p)
        if (best.at[p] <= 0 || best.at[p] >= 1)
            fit.remarks.push_back(std::string(names[p]) + " at the edge of the table (" +
                                  short_number(values[p], 3) + ")");
}

/// Another minimum within two standard deviations of the best.
void remark_on_other_minima(const Problem& problem, const std::vector<Minimum>& minima, Fit& fit) {
    constexpr double min_distance = 0.05;  // of the table's range
    const Minimum& best = minima.front();
    for (const Minimum& other : minima) {
        if (other.chi_square > best.chi_square + two_sigma) continue;
        if ((other.at - best.at).cwiseAbs().maxCoeff() < min_distance) continue;
        const LayerParameters layer = problem.layer(other.at);
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
    require(observations.size() >= 3, caller, "observations", "at least three",
            observations.size());
    for (const Observation& at : observations) {
        const auto is_cosine = [](double mu) { return mu > 0 && mu <= 1; };
        require(is_cosine(at.geometry.mu_in), caller, "mu_in", "in (0, 1]", at.geometry.mu_in);
        require(is_cosine(at.geometry.mu_out), caller, "mu_out", "in (0, 1]", at.geometry.mu_out);
        require(std::isfinite(at.geometry.azimuth), caller, "azimuth", "finite",
                at.geometry.azimuth);
        require(std::isfinite(at.brightness), caller, "brightness", "finite", at.brightness);
        require(at.sigma > 0 && std::isfinite(at.sigma), caller, "sigma", "in (0, inf)", at.sigma);
        const bool transmitted = at.side == Side::transmission;
        require(transmitted ? table.has_transmission() : table.has_reflection(), caller,
                "observed side", "one that the table holds",
                transmitted ? "transmission" : "reflection");
    }
}

}  // namespace

double brightness(const TableView& table, double albedo, double optical_depth,
                  const Observation& observation) noexcept {
    const auto look_up = observation.side == Side::transmission ? transmission : reflection;
    return observation.geometry.mu_in *
           look_up(table, albedo, optical_depth, observation.geometry).total();
}

Fit fit_layer(const TableView& table, const std::vector<Observation>& observations) {
    check(table, observations);
    const Problem problem(table, observations);
    std::vector<Minimum> minima;
    for (const CubePoint& start : starts(problem)) minima.push_back(descend(problem, start));
    std::ranges::sort(minima, {}, &Minimum::chi_square);
    const Minimum& best = minima.front();

    // The covariance in the cube, then of (ln depth, w1, w2). A direction in which the residuals do
    // not change is bounded by the cube's edge alone.
    constexpr double min_curvature = 1;
    const Eigen::MatrixX3d derivatives = problem.derivatives(best.at);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> curvature(derivatives.transpose() *
                                                                   derivatives);
    const Eigen::Matrix3d cube_covariance =
        curvature.eigenvectors() *
        curvature.eigenvalues().cwiseMax(min_curvature).cwiseInverse().asDiagonal() *
        curvature.eigenvectors().transpose();
    const Eigen::Matrix3d jacobian = problem.parameter_derivatives(best.at);
    const Eigen::Matrix3d covariance = jacobian * cube_covariance * jacobian.transpose();
    const auto sigma = [&](int p) { return std::sqrt(covariance(p, p)); };

    const LayerParameters layer = problem.layer(best.at);
    Fit fit{{layer.w1(), sigma(1)},
            {layer.w2(), sigma(2)},
            {layer.optical_depth, layer.optical_depth * sigma(0)},
            best.chi_square,
            static_cast<int>(observations.size()) - 3,
            {}};
    remark_on_depth(problem, best, sigma(0), fit);
    remark_on_albedos(covariance, fit);
    if (fit.remarks.empty()) remark_on_other_minima(problem, minima, fit);
    remark_on_edges(problem, best, fit);
    return fit;
}

}  // namespace stratus
