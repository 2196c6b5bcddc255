#include "stack_path.h"

#include "options.h"

#include <boost/math/quadrature/gauss.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {

namespace {

/// (e^x - 1) / x. Most moments of a peak have a small x, whose series takes a fifth of the time.
double mean_growth(double x) {
    if (std::abs(x) > 0.01) return std::expm1(x) / x;
    return 1 + x / 2 * (1 + x / 3 * (1 + x / 4 * (1 + x / 5)));
}

/// (e^(from + rise) - e^from) / rise with at_from = e^from: the mean of an exponential along its rise.
double mean_exponential(double from, double at_from, double rise) {
    if (rise > 20) return (std::exp(from + rise) - at_from) / rise;  // at_from may be 0
    return at_from * mean_growth(rise);
}

/// Eight Gauss points in each panel from 0 to `end`, the panels as wide as what lies before them:
/// at(place, weight).
template <class At>
void for_each_node(double end, double first_panel, const At& at) {
    using Gauss = boost::math::quadrature::gauss<double, 8>;
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
        layers.push_back(truncation_of(layer.phase_function, options, false));
        follows_paths |= stratus::follows_paths(layer.phase_function, layers.back(), options);
    }
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const bool stays = layers[k].backward ? has_line_law : follows_paths;
        if (!stays) layers[k] = truncation_of(stack[k].phase_function, options, true);
    }
}

StackPath::StackPath(const std::vector<StackLayer>& layers,
                     const std::vector<Truncation>& truncations) {
    double most_kept_to_path = 0.5;
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const double w = layers[k].albedo, f = truncations[k].fraction;
        const std::vector<double>& truncated = truncations[k].moments;
        std::vector<double> chi = path_moments(layers[k].phase_function);
        chi.resize(std::max(chi.size(), truncated.size()), 0.0);
        Layer layer{layers[k].optical_depth, w * f, {}, {}};
        for (std::size_t l = 0; l < chi.size(); ++l) {
            const double kept = l < truncated.size() ? (1 - f) * truncated[l] : 0;
            layer.peak.push_back(w * (chi[l] - kept));
            layer.kept.push_back(w * kept);
        }
        most_kept_to_path = std::max(most_kept_to_path, w * chi[1]);
        moments_ = std::max(moments_, chi.size());
        layers_.push_back(std::move(layer));
    }
    for (Layer& layer : layers_) {
        layer.peak.resize(moments_, 0.0);
        layer.kept.resize(moments_, 0.0);
    }
    deepest_ = 40 / (1 - most_kept_to_path);
}

std::vector<StackPath::Turn> StackPath::turns(Side side, std::size_t above, double mu_in,
                                              double mu_out) const {
    const bool upward = side == Side::reflection;
    const std::size_t first = upward ? above : 0, end_layer = upward ? layers_.size() : above;
    std::vector<Turn> all;
    double top = 0;  // optical depth of layer j's
    for (std::size_t k = 0; k < first; ++k) top += layers_[k].optical_depth;
    for (std::size_t j = first; j < end_layer && top / mu_in < deepest_; ++j) {
        const double depth = layers_[j].optical_depth;
        // Slant depth from the top of the layer on, or where T has more of it there, from below.
        const double rate = upward ? 1 / mu_in + 1 / mu_out : 1 / mu_in - 1 / mu_out;
        const double slope = std::abs(rate), end = std::min(depth, deepest_ / slope);
        for_each_node(end, 1 / slope, [&](double place, double weight) {
            const double t = rate > 0 ? place : depth - place;
            Turn turn{j, weight / (4 * mu_in * mu_out), std::vector<double>(layers_.size(), 0.0)};
            for (std::size_t k = 0; k < layers_.size(); ++k) {
                const double whole = layers_[k].optical_depth;
                const double in = k < j ? whole : k == j ? t : 0;
                const double ahead = k > j && k < above ? whole : k == j ? whole - t : 0;
                const double out = !upward ? ahead : k >= above ? in : 0;
                turn.slant[k] = in / mu_in + (out > 0 ? out / mu_out : 0);
            }
            all.push_back(std::move(turn));
        });
        top += depth;
    }
    return all;
}

std::vector<double> StackPath::legendre(Side side, std::size_t above, double mu_in,
                                        double mu_out) const {
    std::vector<double> sum(moments_, 0.0);
    for (const Turn& turn : turns(side, above, mu_in, mu_out)) {
        double slant = 0, truncated = 0;  // S and F
        for (std::size_t k = 0; k < layers_.size(); ++k) {
            slant += turn.slant[k];
            truncated += layers_[k].truncated * turn.slant[k];
        }
        const double unscattered = std::exp(-slant), passing = std::exp(truncated - slant);
        const Layer& here = layers_[turn.layer];
        for (std::size_t l = 0; l < moments_; ++l) {
            double P = 0, C = 0;
            for (std::size_t k = 0; k < layers_.size(); ++k) {
                P += layers_[k].peak[l] * turn.slant[k];
                C += layers_[k].kept[l] * turn.slant[k];
            }
            const double p = here.peak[l], c = here.kept[l];
            double added = p * mean_exponential(-slant, unscattered, P) - (p + c) * unscattered;
            if (c != 0)
                added += c * (mean_exponential(P - slant, std::exp(P - slant), C) -
                              mean_exponential(truncated - slant, passing, C) + passing);
            sum[l] += turn.weight * added;
        }
    }
    for (std::size_t l = 0; l < moments_; ++l) sum[l] *= 2 * static_cast<double>(l) + 1;
    return sum;
}

}  // namespace stratus
