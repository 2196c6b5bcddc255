#include <stratus/transfer/reference/solvers.h>

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/transfer/quadrature.h>

#include "../layer.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <boost/math/special_functions/expint.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace stratus {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// H behaves as mu log(mu) near 0, and 1/(mu + mu') varies there over a distance mu. The
// double-exponential rule, mu = 1 / (1 + exp(-pi sinh t)), is uniform in log(mu) at that end: the
// nearest singularity, mu' = -mu, stays pi / (pi cosh t) off the real axis, and a step of 1/64
// leaves an error exp(-2 pi 64 / cosh t), below rounding for all mu above exp(-30).
constexpr double H_step = 1.0 / 64;
constexpr int H_steps = 192;  // to t = 3: mu = 2e-14, weighted by mu'

// Averaging log H with its image at least halves every error: the linearised map has its
// eigenvalues in [-1, 0].
constexpr int H_iterations = 70;

}  // namespace

HFunction::HFunction(double albedo) : albedo_(albedo) {
    require_in("[0, 1]", "HFunction", "albedo", albedo);
    for (int i = -H_steps; i <= H_steps; ++i) {
        const double t = i * H_step, e = std::exp(-pi * std::sinh(t));
        mu_.push_back(1 / (1 + e));
        weight_.push_back(H_step * pi * std::cosh(t) * e / ((1 + e) * (1 + e)));
    }
    H_.assign(mu_.size(), 1);
    for (int n = 0; n < H_iterations; ++n) {
        std::vector<double> next;
        for (std::size_t i = 0; i < mu_.size(); ++i)
            next.push_back(std::sqrt(H_[i] * (*this)(mu_[i])));
        H_ = next;
    }
}

double HFunction::operator()(double mu) const {
    double sum = 0;
    for (std::size_t i = 0; i < mu_.size(); ++i) sum += weight_[i] * mu_[i] * H_[i] / (mu + mu_[i]);
    return 1 / (std::sqrt(1 - albedo_) + albedo_ / 2 * sum);
}

double HFunction::moment(int order) const {
    double sum = 0;
    for (std::size_t i = 0; i < mu_.size(); ++i)
        sum += weight_[i] * std::pow(mu_[i], order) * H_[i];
    return sum;
}

namespace {

constexpr int stages = 12;
using Stages = Eigen::Matrix<double, stages, 1>;
using StageMatrix = Eigen::Matrix<double, stages, stages>;

/// Radau IIA: h A f integrates the values f at `point` (fractions of a panel, the last one 1).
///
/// It is L-stable, and its last stage is the end of the panel.
struct Radau {
    Stages point;
    StageMatrix A, inverse;

    Radau() {
        // Zeros of P_s - P_{s-1}: eigenvalues of the Legendre recurrence with its last diagonal
        // entry changed so that 1 is one of them. [G73]
        StageMatrix recurrence = StageMatrix::Zero();
        for (int k = 1; k < stages; ++k)
            recurrence(k, k - 1) = recurrence(k - 1, k) = k / std::sqrt(4.0 * k * k - 1);
        recurrence(stages - 1, stages - 1) = stages / (2.0 * stages - 1);
        const Stages z = Eigen::SelfAdjointEigenSolver<StageMatrix>(recurrence).eigenvalues();
        point = (1 + z.array()) / 2;
        StageMatrix value, integral;  // of P_j at the points, and from 0 to them
        for (int k = 0; k < stages; ++k) {
            double before = 1, P = z(k);  // P_{j-1}, P_j
            value(k, 0) = 1;
            integral(k, 0) = point(k);
            for (int j = 1; j < stages; ++j) {
                const double next = ((2 * j + 1) * z(k) * P - j * before) / (j + 1);
                value(k, j) = P;
                integral(k, j) = (next - before) / (2 * (2 * j + 1));
                before = P;
                P = next;
            }
        }
        A = integral * value.inverse();
        inverse = A.inverse();
    }
};

/// Ends of the panels from 0 to `optical_depth`: doubling up to 1, then at most 1 apart. b has a
/// logarithm at 0, and light at grazing angles decays within a depth mu.
std::vector<double> panel_ends(double optical_depth) {
    std::vector<double> ends;
    for (int k = -50; k <= 0 && std::ldexp(1.0, k) < optical_depth; ++k)
        ends.push_back(std::ldexp(1.0, k));
    const double start = ends.empty() ? 0 : ends.back();
    const int rest = std::max(1, static_cast<int>(std::ceil(optical_depth - start)));
    for (int k = 1; k <= rest; ++k) ends.push_back(start + k * (optical_depth - start) / rest);
    return ends;
}

/// Integrates X and Y from depth 0 down, panel by panel, and R, T and the fluxes along with them.
///
/// Scattered light is kept apart from the beam, x = X - 1 and y = Y - exp(-tau/mu), so that the
/// logarithm in b is exact and thin layers keep their relative accuracy.
class Descent {
  public:
    Descent(double albedo, const Directions& directions)
        : albedo_(albedo),
          directions_(directions),
          asked_(directions.size() - directions.nodes),
          x_(VectorXd::Zero(directions.size())),
          y_(x_),
          plane_albedo_(x_),
          diffuse_(x_),
          multiple_transmission_(MatrixXd::Zero(asked_, asked_)) {}

    void pass(double start, double end) {
        const Panel panel = solve_panel(start, end);
        carry(panel);
        depth_ = end;
        x_ = panel.x.row(stages - 1);
        y_ = panel.y.row(stages - 1);
    }

    /// R in closed form, scattered light and beam apart to avoid cancellation.
    IsotropicSolution solution() const {
        const Index N = directions_.nodes;
        IsotropicSolution solution;
        solution.mu = directions_.mu.tail(asked_);
        solution.X = 1 + x_.tail(asked_).array();
        solution.Y = y_.tail(asked_) + beam_along(solution.mu, depth_);
        solution.reflection.resize(asked_, asked_);
        solution.transmission = multiple_transmission_;
        for (Index i = 0; i < asked_; ++i)
            for (Index j = 0; j < asked_; ++j) {
                const double mu = solution.mu(i), mu0 = solution.mu(j);
                const double x = x_(N + i), x0 = x_(N + j), y = y_(N + i);
                // X X0 - Y Y0 less the term of the beams, 1 - exp(-tau/mu) exp(-tau/mu0)
                const double multiple = x + x0 + x * x0 - y * solution.Y(j) -
                                        y_(N + j) * direct_transmittance(depth_, mu);
                solution.reflection(i, j) = single_reflection(1, albedo_, depth_, mu, mu0) +
                                            albedo_ / 4 * multiple / (mu + mu0);
                solution.transmission(i, j) += single_transmission(1, albedo_, depth_, mu, mu0);
            }
        solution.plane_albedo = plane_albedo_.tail(asked_);
        solution.diffuse_transmittance = diffuse_.tail(asked_);
        solution.spherical_albedo = spherical_albedo_;
        solution.total_transmittance =
            2 * (directions_.weight.cwiseProduct(directions_.mu).dot(diffuse_) +
                 boost::math::expint(3, depth_));
        return solution;
    }

  private:
    struct Panel {
        double width;
        Stages depth, b, mean_Y;  // mean_Y = int_0^1 Y dmu
        MatrixXd x, y, beam;      // stages x directions
    };

    /// (A^-1 + h/mu) f = A^-1 1 f(start) + h source, for df/dtau = source - f/mu.
    StageMatrix decay(double width, double mu) const {
        return radau_.inverse + width / mu * StageMatrix::Identity();
    }
    double advance(const Eigen::PartialPivLU<StageMatrix>& decay, double width, double value,
                   const Stages& source) const {
        const Stages from = value * radau_.inverse.rowwise().sum();
        return decay.solve(from + width * source)(stages - 1);
    }
    double integrate(double width, const Stages& source) const {
        return width * radau_.A.row(stages - 1).dot(source);
    }

    /// Newton's method for b at the stages: given b, the equations of each direction are linear and
    /// independent of the others.
    Panel solve_panel(double start, double end) const {
        constexpr int max_steps = 20;  // at most 3 were observed
        // b to rounding, except where absorption has reduced it to almost nothing
        constexpr double relative = 1e-14, smallest = 1e-290;
        const Index n = directions_.size();
        const double h = end - start, half = albedo_ / 2;
        const MatrixXd blank(stages, n);
        Panel panel{h, start + h * radau_.point.array(), {}, {}, blank, blank, blank};
        Stages beam_b;  // b of the beam alone
        for (int k = 0; k < stages; ++k) {
            const double tau = panel.depth(k);
            panel.beam.row(k) = beam_along(directions_.mu, tau);
            beam_b(k) = half * boost::math::expint(1, tau);
        }
        const VectorXd share = directions_.weight.cwiseQuotient(directions_.mu);
        panel.b = beam_b.array() + half * share.dot(y_);
        const Stages enter = radau_.inverse.rowwise().sum();
        for (int step = 0;; ++step) {
            if (step == max_steps)
                throw std::runtime_error("solve_isotropic: no solution at optical depth " +
                                         std::to_string(end));
            const StageMatrix bA = h * panel.b.asDiagonal() * radau_.A;
            Stages residual = panel.b - beam_b;
            StageMatrix jacobian = StageMatrix::Identity();
            for (Index i = 0; i < n; ++i) {
                // x = x(start) + h A (b Y),  A^-1 (y - y(start)) = h (b X - y/mu)
                const Eigen::PartialPivLU<StageMatrix> matrix(decay(h, directions_.mu(i)) -
                                                              h * bA * panel.b.asDiagonal());
                const Stages beam = panel.beam.col(i);
                const Stages from =
                    y_(i) * enter + h * (panel.b * (1 + x_(i)) + bA * panel.b.cwiseProduct(beam));
                const Stages y = matrix.solve(from);
                const Stages Y = y + beam;
                const Stages x = x_(i) + (h * radau_.A * panel.b.cwiseProduct(Y)).array();
                panel.x.col(i) = x;
                panel.y.col(i) = y;
                if (directions_.weight(i) == 0) continue;
                StageMatrix change = bA * Y.asDiagonal();
                change.diagonal().array() += 1 + x.array();
                residual -= half * share(i) * y;
                jacobian -= half * share(i) * h * matrix.solve(change);
            }
            if (residual.cwiseAbs().maxCoeff() <= relative * panel.b.maxCoeff() + smallest) break;
            panel.b -= jacobian.partialPivLu().solve(residual);
        }
        for (int k = 0; k < stages; ++k)
            panel.mean_Y(k) =
                boost::math::expint(2, panel.depth(k)) + directions_.weight.dot(panel.y.row(k));
        return panel;
    }

    /// R' = (w/4) Y Y0/(mu mu0) and T' = (w/4) Y X0/(mu mu0) - T/mu0, integrated over mu for the
    /// fluxes.
    void carry(const Panel& panel) {
        const Index first = directions_.nodes;
        for (Index i = 0; i < directions_.size(); ++i) {
            const double mu = directions_.mu(i);
            const Eigen::PartialPivLU<StageMatrix> out(decay(panel.width, mu));
            const Stages Y = panel.y.col(i) + panel.beam.col(i), X = 1 + panel.x.col(i).array();
            const Stages rate = albedo_ / 2 / mu * panel.mean_Y;
            plane_albedo_(i) += integrate(panel.width, rate.cwiseProduct(Y));
            diffuse_(i) = advance(out, panel.width, diffuse_(i), rate.cwiseProduct(X));
            for (Index j = first; i >= first && j < directions_.size(); ++j) {
                // each pair once, with the more grazing of the two as exit
                if (directions_.mu(j) < mu || (directions_.mu(j) == mu && j < i)) continue;
                const Stages source = albedo_ / 4 / mu / directions_.mu(j) *
                                      (panel.y.col(j).cwiseProduct(X) +
                                       panel.beam.col(j).cwiseProduct(panel.x.col(i)));
                double& T = multiple_transmission_(i - first, j - first);
                multiple_transmission_(j - first, i - first) = T =
                    advance(out, panel.width, T, source);
            }
        }
        spherical_albedo_ += integrate(panel.width, albedo_ * panel.mean_Y.array().square());
    }

    const double albedo_;
    const Directions& directions_;
    const Index asked_;
    const Radau radau_;
    double depth_ = 0;
    VectorXd x_, y_, plane_albedo_, diffuse_;
    double spherical_albedo_ = 0;
    MatrixXd multiple_transmission_;  // orders n >= 2
};

IsotropicSolution solve_semi_infinite(double albedo, const VectorXd& mu) {
    const HFunction H(albedo);
    const Index count = mu.size();
    IsotropicSolution solution;
    solution.mu = mu;
    solution.X = mu.unaryExpr(H);
    solution.Y = VectorXd::Zero(count);
    solution.reflection.resize(count, count);
    for (Index i = 0; i < count; ++i)
        for (Index j = 0; j < count; ++j)
            solution.reflection(i, j) =
                albedo / 4 * solution.X(i) * solution.X(j) / (mu(i) + mu(j));
    solution.transmission = MatrixXd::Zero(count, count);
    solution.plane_albedo = 1 - std::sqrt(1 - albedo) * solution.X.array();
    solution.diffuse_transmittance = VectorXd::Zero(count);
    solution.spherical_albedo = 1 - 2 * std::sqrt(1 - albedo) * H.moment(1);
    solution.total_transmittance = 0;
    return solution;
}

}  // namespace

IsotropicSolution solve_isotropic(double albedo, double optical_depth,
                                  const std::vector<double>& mu, int nodes) {
    require_in("[0, 1]", "solve_isotropic", "albedo", albedo);
    // Cost and, at w = 1, rounding grow with the depth.
    require_in("[0, 1024] or inf", "solve_isotropic", "optical_depth", optical_depth);
    require_in("[1, 512]", "solve_isotropic", "nodes", nodes);
    for (const double cosine : mu) require_in("[1e-12, 1]", "solve_isotropic", "mu", cosine);
    if (std::isinf(optical_depth))
        return solve_semi_infinite(albedo, VectorXd::Map(mu.data(), std::ssize(mu)));
    const Directions directions = gauss_directions(nodes, NodeMap::grazing, mu);
    Descent descent(albedo, directions);
    double start = 0;
    if (optical_depth > 0)
        for (const double end : panel_ends(optical_depth)) {
            descent.pass(start, end);
            start = end;
        }
    return descent.solution();
}

}  // namespace stratus
