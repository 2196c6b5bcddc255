#include "least_squares.h"

#include <stratus/base/size.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stratus {
namespace {

using Point = Problem::Point;

/// The step that the damped normal equations ask for; none along coordinates that must not move.
Point damped_step(const Eigen::MatrixXd& curvature, const Point& slope, const Point& at,
                  double damping, std::optional<int> held) {
    constexpr double min_curvature = 1e-9;
    Eigen::MatrixXd damped = curvature;
    Point right_side = -slope;
    damped.diagonal() *= 1 + damping;
    damped.diagonal().array() += 1e-12 * curvature.trace() + min_curvature;
    for (int p = 0; p < at.size(); ++p) {
        const bool outward = (at[p] <= 0 && slope[p] > 0) || (at[p] >= 1 && slope[p] < 0);
        if (!outward && held != p) continue;
        damped.row(p).setZero();
        damped.col(p).setZero();
        damped(p, p) = 1;
        right_side[p] = 0;
    }
    return damped.ldlt().solve(right_side);
}

/// `start` with every combination of starts of the parameters of phase functions that are free.
std::vector<Point> starting_points(const ParameterSpace& space) {
    std::vector<Point> points{space.start()};
    for (const Coordinate parameter : of_phase_functions) {
        const int place = space.place(parameter);
        if (place < 0) continue;
        const std::vector<Point> before = points;
        for (const double at : {0.2, 0.8})
            for (Point point : before) {
                point[place] = at;
                points.push_back(point);
            }
    }
    return points;
}

/// The minima of one scan, each fit starting from the one before; where a phase function is free, from
/// `start`: one fit in which its particles have vanished would lose it for all that follow.
void scan(const Problem& problem, const Point& start, int depth, std::vector<Minimum>& minima) {
    constexpr double rough_tolerance = 1e-3;
    const int count = problem.model().scanned_depths();
    const bool afresh = std::ranges::any_of(of_phase_functions, [&](Coordinate parameter) {
        return problem.space().place(parameter) >= 0;
    });
    std::vector<Minimum> profile;
    for (int n = 0; n < count; ++n) {
        Point at = afresh || n == 0 ? start : profile.back().at;
        at[depth] = n / (count - 1.0);
        profile.push_back(descend(problem, at, depth, rough_tolerance));
    }
    for (std::size_t n = 0; n < profile.size(); ++n) {
        const auto is_below = [&](std::size_t other) {
            return other >= profile.size() || profile[n].chi_square <= profile[other].chi_square;
        };
        if (is_below(n - 1) && is_below(n + 1)) minima.push_back(profile[n]);
    }
}

/// Without those that lie next to a better one.
std::vector<Minimum> distinct(const std::vector<Minimum>& sorted) {
    constexpr double next_to = 0.01;
    std::vector<Minimum> kept;
    for (const Minimum& minimum : sorted) {
        const auto is_near = [&](const Minimum& other) {
            return (minimum.at - other.at).isZero(0) ||
                   (minimum.at - other.at).cwiseAbs().maxCoeff() < next_to;
        };
        if (std::ranges::none_of(kept, is_near)) kept.push_back(minimum);
    }
    return kept;
}

}  // namespace

Eigen::VectorXd Problem::residuals(const Point& at) const {
    const std::vector<double> brightness =
        model_.brightness(space_.layer(at), observations_, options_.density, options_.opposition);
    Eigen::VectorXd residuals(static_cast<Eigen::Index>(observations_.size()));
    for (Eigen::Index i = 0; i < residuals.size(); ++i) {
        const Observation& observed = observations_[size(i)];
        residuals[i] = (brightness[size(i)] - observed.brightness) / observed.sigma;
    }
    return residuals;
}

Eigen::MatrixXd Problem::derivatives(const Point& at, std::optional<int> held) const {
    constexpr double step = 1e-3;
    Eigen::MatrixXd derivatives =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(observations_.size()), at.size());
    for (int p = 0; p < at.size(); ++p) {
        if (held == p) continue;
        Point upper = at, lower = at;
        upper[p] = std::min(1.0, at[p] + step);
        lower[p] = std::max(0.0, at[p] - step);
        derivatives.col(p) = (residuals(upper) - residuals(lower)) / (upper[p] - lower[p]);
    }
    return derivatives;
}

Minimum descend(const Problem& problem, Point at, std::optional<int> held, double tolerance) {
    constexpr int max_steps = 60;
    constexpr double min_damping = 1e-9, max_damping = 1e9;
    Eigen::VectorXd residuals = problem.residuals(at);
    double chi_square = residuals.squaredNorm(), damping = 1e-3;
    for (int step = 0; step < max_steps && at.size() > 0; ++step) {
        const Eigen::MatrixXd derivatives = problem.derivatives(at, held);
        const Eigen::MatrixXd curvature = derivatives.transpose() * derivatives;
        const Point slope = derivatives.transpose() * residuals;
        bool improved = false, converged = true;
        for (; !improved && damping < max_damping; damping *= improved ? 0.1 : 10) {
            const Point next =
                (at + damped_step(curvature, slope, at, damping, held)).cwiseMax(0).cwiseMin(1);
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

std::vector<Minimum> scan_minima(const Problem& problem) {
    std::vector<Minimum> minima;
    const int depth = problem.space().place(Coordinate::depth);
    for (const Point& start : starting_points(problem.space())) {
        if (depth < 0)
            minima.push_back(descend(problem, start));
        else
            scan(problem, start, depth, minima);
    }
    std::ranges::sort(minima, {}, &Minimum::chi_square);
    return distinct(minima);
}

// Q(a + 1, x) = Q(a, x) + x^a e^-x / Gamma(a + 1), from Q(1/2, x) = erfc(sqrt x) or Q(1, x) = e^-x.
double chi_square_probability(double chi_square, int degrees_of_freedom) noexcept {
    const double x = chi_square / 2;
    if (x == 0) return 1;
    if (std::isinf(x)) return 0;
    const bool odd = degrees_of_freedom % 2 == 1;
    double a = odd ? 0.5 : 1;
    double probability = odd ? std::erfc(std::sqrt(x)) : std::exp(-x);
    const double log_gamma = odd ? std::log(std::numbers::pi) / 2 - std::numbers::ln2 : 0;
    double log_term = a * std::log(x) - x - log_gamma;  // x^a e^-x / Gamma(a + 1)
    for (; a < degrees_of_freedom / 2.0; a += 1) {
        probability += std::exp(log_term);
        log_term += std::log(x / (a + 1));
    }
    return std::fmin(probability, 1);
}

}  // namespace stratus
