#include "reflection_field.h"

#include <stratus/bake/parallel.h>
#include <stratus/base/constants.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>

namespace stratus {
namespace {

constexpr int points = 6;

/// Lagrange's polynomial through the six samples around a place among evenly spaced ones.
struct Stencil {
    int first;
    std::array<double, points> weight;
};

Stencil stencil_at(double place, int lowest, int highest) {
    Stencil stencil{std::clamp(static_cast<int>(std::floor(place)) - (points / 2 - 1), lowest,
                               highest - points + 1),
                    {}};
    const double t = place - stencil.first;
    for (int i = 0; i < points; ++i) {
        double weight = 1;
        for (int j = 0; j < points; ++j)
            if (j != i) weight *= (t - j) / (i - j);
        stencil.weight[static_cast<std::size_t>(i)] = weight;
    }
    return stencil;
}

double spread(double mu) { return std::pow(2 / pi * std::asin(std::min(1.0, mu)), 2.0 / 3); }

}  // namespace

double single_reflection(const Stack& stack, const Geometry& geometry) {
    const double cosine = cos_scattering_angle_reflected(geometry);
    double sum = 0, above = 0;
    for (const StackLayer& layer : stack.layers) {
        sum += direct_transmittance(above, geometry.mu_in) *
               direct_transmittance(above, geometry.mu_out) *
               single_reflection(layer.phase_function(cosine), layer.albedo, layer.optical_depth,
                                 geometry.mu_in, geometry.mu_out);
        above += layer.optical_depth;
    }
    return sum + single_reflection_of_boundary(stack.lower_boundary, above, geometry);
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
    std::vector<double> azimuths;
    for (int a = 0; a <= azimuth_intervals; ++a) azimuths.push_back(a * pi / azimuth_intervals);
    const std::size_t count = mu.size(), row = azimuths.size();
    rest_.resize(count * count * row);
    parallel_for(static_cast<int>(count), threads, [&](int out) {
        for (int in = out; in < static_cast<int>(count); ++in) {
            const std::vector<SolvedValue> values = solved.reflection(in, out, azimuths);
            const auto i = static_cast<std::size_t>(in), o = static_cast<std::size_t>(out);
            for (std::size_t a = 0; a < row; ++a)
                rest_[(o * count + i) * row + a] = rest_[(i * count + o) * row + a] =
                    values[a].multiple;
        }
    });
}

double ReflectionField::operator()(double mu_in, int out, double azimuth) const {
    const int last = static_cast<int>(mu_.size()) - 1;
    const double mu = std::max(mu_in, grazing);
    const Stencil over_mu = stencil_at(spread(mu) * last, 0, last);
    // even in azimuth about 0 and pi: samples beyond are those within
    const Stencil over_azimuth =
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
            sum += over_azimuth.weight[static_cast<std::size_t>(a)] * samples[at];
        }
        rest += over_mu.weight[static_cast<std::size_t>(i)] * sum;
    }
    // Polynomials swing below 0 beside the peaks of grazing directions.
    return std::max(0.0, rest) +
           single_reflection(stack_, {mu, mu_[static_cast<std::size_t>(out)], azimuth});
}

}  // namespace stratus
