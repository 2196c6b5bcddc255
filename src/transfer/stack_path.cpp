#include "stack_path.h"

#include "options.h"

#include <boost/math/quadrature/gauss.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// (e^(from + rise) - e^from) / rise with at_from = e^from: the mean of an exponential along its rise.
/// Most moments of a peak have a small rise, whose series takes a fifth of the time.
double mean_exponential(double from, double at_from, double rise) {
    if (std::abs(rise) > 0.01) return (std::exp(from + rise) - at_from) / rise;
    return at_from * (1 + rise * (1. / 2 + rise * (1. / 6 + rise * (1. / 24 + rise / 120))));
}

/// How many moments of a peak change light that they scatter twice or more by 1e-15.
std::size_t second_order_length(const std::vector<double>& chi) {
    std::size_t length = chi.size();
    while (length > 0 &&
           static_cast<double>(2 * length - 1) * chi[length - 1] * chi[length - 1] < 1e-15)
        --length;
    return length;
}

/// Six Gauss points in each panel from 0 to `end`, the panels as wide as what lies before them:
/// at(place, weight).
template <class At>
void for_each_node(double end, double first_panel, const At& at) {
    using Gauss = boost::math::quadrature::gauss<double, 6>;
    double begin = 0;
    while (begin < end) {
        const double next = std::min(end, 2 * begin + first_panel);
        const double middle = (begin + next) / 2, half = (next - begin) / 2;
        for (std::size_t k = 0; k < Gauss::abscissa().size(); ++k)
            for (const double side : {-1.0, 1.0})
                at(middle + side * half * Gauss::abscissa()[k], half * Gauss::weights()[k]);
        begin = next;
    }
}

}  // namespace

StackTruncation::StackTruncation(const std::vector<StackLayer>& stack, const SolverOptions& options,
                                 bool has_line_law) {
    for (const StackLayer& layer : stack) {
        layers.push_back(choose_truncation(layer.phase_function, options, false));
        follows_paths |= stratus::follows_paths(layer.phase_function, layers.back(), options);
    }
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const bool stays = layers[k].backward ? has_line_law : follows_paths;
        if (!stays) layers[k] = choose_truncation(stack[k].phase_function, options, true);
    }
}

StackPath::StackPath(const std::vector<StackLayer>& layers,
                     const std::vector<Truncation>& truncations)
    : depth_(static_cast<Index>(layers.size())), truncated_(depth_.size()) {
    std::vector<std::vector<double>> chi;
    std::size_t moments = 0, kept = 0;
    for (std::size_t k = 0; k < layers.size(); ++k) {
        chi.push_back(path_moments(layers[k].phase_function));
        kept = std::max(kept, truncations[k].moments.size());
        moments = std::max({moments, kept, second_order_length(chi.back())});
    }
    peak_.setZero(static_cast<Index>(moments), depth_.size());
    kept_.setZero(static_cast<Index>(kept), depth_.size());
    double most_kept_to_path = 0.5;
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const double w = layers[k].albedo, f = truncations[k].fraction;
        const std::vector<double>& truncated = truncations[k].moments;
        const Index column = static_cast<Index>(k);
        depth_(column) = layers[k].optical_depth;
        truncated_(column) = w * f;
        for (std::size_t l = 0; l < truncated.size(); ++l)
            kept_(static_cast<Index>(l), column) = w * (1 - f) * truncated[l];
        for (std::size_t l = 0; l < std::min(moments, chi[k].size()); ++l)
            peak_(static_cast<Index>(l), column) = w * chi[k][l];
        most_kept_to_path = std::max(most_kept_to_path, w * chi[k][1]);
    }
    peak_.topRows(kept_.rows()) -= kept_;
    constexpr double rounding = 1e-14;
    while (alike_ < kept_.rows() &&
           (peak_.row(alike_).transpose() - truncated_).cwiseAbs().maxCoeff() <= rounding)
        ++alike_;
    deepest_ = 24 / (1 - most_kept_to_path);
}

std::vector<StackPath::Turn> StackPath::turns(Side side, std::size_t above, double mu_in,
                                              double mu_out) const {
    const bool upward = side == Side::reflection;
    const Index level = static_cast<Index>(above), layers = depth_.size();
    const Index first = upward ? level : 0, end_layer = upward ? layers : level;
    std::vector<Turn> all;
    double top = depth_.head(first).sum();  // optical depth above layer j
    for (Index j = first; j < end_layer && top / mu_in < deepest_; ++j) {
        // Slant depth from the top of the layer on, or where T has more of it there, from below.
        const double rate = upward ? 1 / mu_in + 1 / mu_out : 1 / mu_in - 1 / mu_out;
        const double slope = std::abs(rate), end = std::min(depth_(j), deepest_ / slope);
        for_each_node(end, 1 / slope, [&](double place, double weight) {
            const double t = rate > 0 ? place : depth_(j) - place;
            VectorXd slant = VectorXd::Zero(layers);
            slant.head(j) = depth_.head(j) / mu_in;
            slant(j) = t / mu_in;
            if (upward) {
                slant.segment(level, j - level) += depth_.segment(level, j - level) / mu_out;
                slant(j) += t / mu_out;
            } else {
                slant(j) += (depth_(j) - t) / mu_out;
                slant.segment(j + 1, level - j - 1) = depth_.segment(j + 1, level - j - 1) / mu_out;
            }
            all.push_back({j, weight / (4 * mu_in * mu_out), std::move(slant)});
        });
        top += depth_(j);
    }
    return all;
}

std::vector<double> StackPath::legendre(Side side, std::size_t above, double mu_in,
                                        double mu_out) const {
    VectorXd sum = VectorXd::Zero(peak_.rows());
    for (const Turn& turn : turns(side, above, mu_in, mu_out)) {
        const double S = turn.slant.sum(), F = truncated_.dot(turn.slant);
        const double unscattered = std::exp(-S), passing = std::exp(F - S);
        // Where all peaks are f, the truncated problem's widening is the path's own.
        sum.head(alike_) +=
            turn.weight * ((mean_exponential(-S, unscattered, F) - unscattered) *
                               peak_.col(turn.layer).head(alike_) +
                           (passing - unscattered) * kept_.col(turn.layer).head(alike_));
        const VectorXd peak = peak_ * turn.slant, kept = kept_ * turn.slant;
        for (Index l = alike_; l < sum.size(); ++l) {
            const double P = peak(l), p = peak_(l, turn.layer);
            double added = p * (mean_exponential(-S, unscattered, P) - unscattered);
            if (l < kept.size() && kept_(l, turn.layer) != 0) {
                const double C = kept(l), c = kept_(l, turn.layer);
                added += c * (mean_exponential(P - S, std::exp(P - S), C) -
                              mean_exponential(F - S, passing, C) + passing - unscattered);
            }
            sum(l) += turn.weight * added;
        }
    }
    std::vector<double> coefficients;
    for (Index l = 0; l < sum.size(); ++l)
        coefficients.push_back(static_cast<double>(2 * l + 1) * sum(l));
    return coefficients;
}

}  // namespace stratus
