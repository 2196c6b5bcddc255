#include "solved_stack.h"

#include <stratus/bake/parallel.h>
#include <stratus/base/constants.h>
#include <stratus/base/size.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

namespace stratus {

bool is_transparent(const Stack& stack) {
    return !stack.lower_boundary.is_present() && !std::isinf(stack.optical_depth());
}

const char* lit_side_name(LitSide side) {
    constexpr const char* names[] = {"reflection", "transmission", "reflection_below"};
    return names[static_cast<int>(side)];
}

SolvedStack::SolvedStack(const Stack& stack, const std::vector<double>& mu, int nodes)
    : transparent_(stratus::is_transparent(stack)) {
    SolverOptions options;
    options.nodes = nodes;
    above_ = solve_stack(stack.layers, stack.lower_boundary, mu, options);
    if (stack.layers.size() == 1 || !transparent_) return;
    StackLayers upside_down = stack.layers;
    std::ranges::reverse(upside_down);
    below_ = solve_stack(upside_down, {}, mu, options);
}

std::vector<SolvedValue> SolvedStack::values(LitSide side, int in, int out,
                                             const std::vector<double>& azimuths) const {
    if (side == LitSide::reflection) return above_.values(Side::reflection, in, out, azimuths);
    if (!transparent_) return std::vector<SolvedValue>(azimuths.size());
    if (side == LitSide::transmission) return above_.values(Side::transmission, in, out, azimuths);
    return (below_ ? *below_ : above_).values(Side::reflection, in, out, azimuths);
}

std::vector<double> SolvedStack::plane_albedo() const {
    return {above_.plane_albedo.begin(), above_.plane_albedo.end()};
}

std::vector<double> SolvedStack::diffuse_transmittance() const {
    const auto& shares = above_.diffuse_transmittance;
    if (!transparent_) return std::vector<double>(size(shares.size()));
    return {shares.begin(), shares.end()};
}

std::vector<double> even_cosines(int count) {
    std::vector<double> mu;
    for (int k = 0; k < count; ++k) {
        const double root = std::sin(pi / 2 * k / (count - 1));
        mu.push_back(k == 0 ? grazing : std::min(1.0, root * root));
    }
    return mu;
}

std::vector<double> even_azimuths(int count) {
    std::vector<double> azimuths;
    for (int k = 0; k < count; ++k) azimuths.push_back(k * pi / (count - 1));
    return azimuths;
}

std::vector<LitSide> lit_sides(const Material& material, const SolvedColours& colours) {
    if (material.is_opaque()) return {LitSide::reflection};
    std::vector<LitSide> sides{LitSide::reflection, LitSide::transmission};
    if (!std::ranges::all_of(colours, &SolvedStack::is_symmetric))
        sides.push_back(LitSide::reflection_below);
    return sides;
}

std::vector<double> beam_depths(const Material& material) {
    std::vector<double> depths;
    for (const Stack& stack : material.colours)
        depths.push_back(is_transparent(stack) ? stack.optical_depth() : infinity);
    return depths;
}

namespace {

constexpr int fewest_intervals = 32, most_intervals = 8192;

/// A function at azimuths j pi / intervals, and its series as far as it was worked out.
class Series {
  public:
    explicit Series(std::vector<double> values) : values_(std::move(values)), rest_(values_) {}

    /// Adds the next term.
    void extend(const std::vector<double>& cosine) {
        const std::size_t intervals = values_.size() - 1, k = terms_.size();
        const auto cosine_at = [&](std::size_t j) { return cosine[k * j % (2 * intervals)]; };
        double sum = (values_.front() + values_.back() * cosine_at(intervals)) / 2;
        for (std::size_t j = 1; j < intervals; ++j) sum += values_[j] * cosine_at(j);
        const double term = sum * (k == 0 ? 1 : 2) / static_cast<double>(intervals);
        for (std::size_t j = 0; j <= intervals; ++j) rest_[j] -= term * cosine_at(j);
        terms_.push_back(term);
    }

    bool is_within(double tolerance) const {
        const double floor = 1e-3 * std::abs(terms_[0]);
        for (std::size_t j = 0; j < values_.size(); ++j)
            if (std::abs(rest_[j]) > tolerance * std::max(values_[j], floor)) return false;
        return true;
    }

    const std::vector<double>& terms() const { return terms_; }

  private:
    std::vector<double> values_, rest_, terms_;
};

/// All series within the tolerance, of as many terms as half the intervals at most; empty where
/// more are needed.
Functions try_series(const AzimuthValues& values, int intervals, double tolerance) {
    std::vector<double> cosine;
    for (int j = 0; j < 2 * intervals; ++j) cosine.push_back(std::cos(j * pi / intervals));
    std::vector<Series> all;
    for (std::vector<double>& function : values(even_azimuths(intervals + 1)))
        all.emplace_back(std::move(function));
    for (int count = 1; count <= intervals / 2; ++count) {
        bool within = true;
        for (Series& series : all) {
            series.extend(cosine);
            within = within && series.is_within(tolerance);
        }
        if (!within) continue;
        Functions terms;
        for (const Series& series : all) terms.push_back(series.terms());
        return terms;
    }
    return {};
}

}  // namespace

Functions cosine_series(const AzimuthValues& values, double tolerance) {
    for (int intervals = fewest_intervals; intervals <= most_intervals; intervals *= 2) {
        Functions found = try_series(values, intervals, tolerance);
        if (found.empty()) continue;
        const bool dark =
            std::ranges::all_of(found, [](const auto& terms) { return !(terms[0] > 0); });
        return dark ? Functions() : found;
    }
    throw std::runtime_error(
        "export: cosine series of 4096 terms do not hold the light between some pair of cosines: "
        "the phase function or the ground's hot spot is too narrow, or layers above are too dark");
}

namespace {

constexpr int points = 6;

/// Lagrange's polynomial through the six samples around a place among evenly spaced ones.
struct LagrangeStencil {
    int first;
    std::array<double, points> weight;
};

LagrangeStencil stencil_at(double place, int lowest, int highest) {
    LagrangeStencil stencil{std::clamp(static_cast<int>(std::floor(place)) - (points / 2 - 1),
                                       lowest, highest - points + 1),
                            {}};
    const double t = place - stencil.first;
    for (int i = 0; i < points; ++i) {
        double weight = 1;
        for (int j = 0; j < points; ++j)
            if (j != i) weight *= (t - j) / (i - j);
        stencil.weight[size(i)] = weight;
    }
    return stencil;
}

double spread(double mu) { return std::pow(2 / pi * std::asin(std::min(1.0, mu)), 2.0 / 3); }

}  // namespace

double single_reflection(const Stack& stack, const Geometry& geometry) {
    return stack_single_scattering(Side::reflection, stack.layers, geometry) +
           single_reflection_of_boundary(stack.lower_boundary, stack.optical_depth(), geometry);
}

std::vector<double> ReflectionField::cosines(int count) {
    std::vector<double> mu{grazing};
    for (int k = 1; k < count; ++k)
        mu.push_back(std::min(1.0, std::sin(pi / 2 * std::pow(k / (count - 1.0), 1.5))));
    return mu;
}

ReflectionField::ReflectionField(const Stack& stack, const SolvedStack& solved,
                                 const std::vector<double>& mu, int threads)
    : stack_(stack), mu_(mu) {
    const std::vector<double> azimuths = even_azimuths(azimuth_intervals + 1);
    const std::size_t count = mu.size(), row = azimuths.size();
    rest_.resize(count * count * row);
    parallel_for(int_size(mu), threads, [&](int out) {
        for (int in = out; in < int_size(mu); ++in) {
            const std::vector<SolvedValue> values =
                solved.values(LitSide::reflection, in, out, azimuths);
            const auto i = size(in), o = size(out);
            for (std::size_t a = 0; a < row; ++a)
                rest_[(o * count + i) * row + a] = rest_[(i * count + o) * row + a] =
                    values[a].multiple;
        }
    });
}

double ReflectionField::operator()(double mu_in, int out, double azimuth) const {
    const int last = int_size(mu_) - 1;
    const double mu = std::max(mu_in, grazing);
    const LagrangeStencil over_mu = stencil_at(spread(mu) * last, 0, last);
    // even in azimuth about 0 and pi: samples beyond are those within
    const LagrangeStencil over_azimuth =
        stencil_at(azimuth / pi * azimuth_intervals, -points, azimuth_intervals + points);
    double rest = 0;
    for (int i = 0; i < points; ++i) {
        const double* const samples =
            rest_.data() + (static_cast<std::ptrdiff_t>(out) * (last + 1) + over_mu.first + i) *
                               (azimuth_intervals + 1);
        double sum = 0;
        for (int a = 0; a < points; ++a) {
            const int folded = std::abs(over_azimuth.first + a);
            const int at = folded > azimuth_intervals ? 2 * azimuth_intervals - folded : folded;
            sum += over_azimuth.weight[size(a)] * samples[at];
        }
        rest += over_mu.weight[size(i)] * sum;
    }
    // Polynomials swing below 0 beside the peaks of grazing directions.
    return std::max(0.0, rest) + single_reflection(stack_, {mu, mu_[size(out)], azimuth});
}

}  // namespace stratus
