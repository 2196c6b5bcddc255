// SCATFUN tables: cosine series in azimuth between all pairs of cosines, read by cubic splines.
//
// mu_o is that of the outgoing direction, mu_i that of the propagation of the incident light, so
// that mu_o mu_i < 0 is reflection; azimuth 0 is forward. A series is of f |mu_i|.
#include <stratus/bake/parallel.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>

#include "solved_stack.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace stratus {
namespace {

constexpr int fourier_cosines = 64;        // above 0
constexpr double series_tolerance = 1e-4;  // relative, of every value
constexpr double largest_mean = 8;         // of f |mu_i| over azimuth: samplers need it below 16

/// Ascending in (0, 1]: dense near the horizon, where splines meet 1 / (mu + mu0), and near the
/// normal, where they meet the sines of series. The first is below 1e-3, because splines reach
/// across 0 from there.
std::vector<double> cosines_above_zero() {
    std::vector<double> mu;
    for (int k = 1; k <= fourier_cosines; ++k) {
        const double x = static_cast<double>(k) / fourier_cosines;
        mu.push_back(std::cos(pi / 2 * std::pow(1 - x * x, 1.5)));
    }
    return mu;
}

/// -1 .. -0, +0 .. 1.
std::vector<float> signed_cosines(const std::vector<double>& positive) {
    std::vector<float> mu;
    for (auto at = positive.rbegin(); at != positive.rend(); ++at)
        mu.push_back(static_cast<float>(-*at));
    mu.insert(mu.end(), {-0.0f, 0.0f});
    for (const double value : positive) mu.push_back(static_cast<float>(value));
    return mu;
}

/// Luminance, red and blue: the channels of a coloured table; one colour as it is. Readers find green as
/// 1.39829 Y - 0.100913 B - 0.297375 R, and a dark one as a small difference: so this is its exact inverse.
Functions to_channels(Functions colours) {
    if (colours.size() == 1) return colours;
    std::vector<double> luminance(colours[0].size());
    for (std::size_t j = 0; j < luminance.size(); ++j)
        luminance[j] =
            (colours[1][j] + 0.100913 * colours[2][j] + 0.297375 * colours[0][j]) / 1.39829;
    return {std::move(luminance), std::move(colours[0]), std::move(colours[2])};
}

/// The series of one side between all pairs of cosines, over (in, out).
using SideSeries = std::vector<std::vector<Functions>>;

/// `symmetric`: half of the pairs are worked out.
SideSeries make_series(const SolvedColours& colours, LitSide side, int count, bool symmetric,
                       int threads) {
    SideSeries all(size(count), std::vector<Functions>(size(count)));
    parallel_for(count, threads, [&](int in) {
        for (int out = symmetric ? in : 0; out < count; ++out) {
            const auto bsdf = [&](const std::vector<double>& azimuths) {
                Functions of_colours;
                for (const SolvedStack& colour : colours) {
                    std::vector<double>& totals = of_colours.emplace_back();
                    for (const SolvedValue& value : colour.values(side, in, out, azimuths))
                        totals.push_back(value.total / pi);
                }
                return to_channels(std::move(of_colours));
            };
            const auto i = size(in), o = size(out);
            all[i][o] = cosine_series(bsdf, series_tolerance);
            if (symmetric) all[o][i] = all[i][o];
        }
    });
    return all;
}

/// The integral of the spline through f up to every node.
std::vector<float> spline_integrals(const std::vector<float>& x, const std::vector<double>& f) {
    const std::size_t last = x.size() - 1;
    const auto slope = [&](std::size_t k) {
        const std::size_t before = k == 0 ? 0 : k - 1, after = std::min(k + 1, last);
        return (f[after] - f[before]) / static_cast<double>(x[after] - x[before]);
    };
    std::vector<float> sums{0};
    double sum = 0;
    for (std::size_t k = 0; k < last; ++k) {
        const double width = static_cast<double>(x[k + 1] - x[k]);
        if (width > 0)
            sum += width * ((f[k] + f[k + 1]) / 2 + width * (slope(k) - slope(k + 1)) / 12);
        sums.push_back(static_cast<float>(sum));
    }
    return sums;
}

/// Places among the cosines above 0 that splines are tried after, midway to the next: from 0.15 on.
constexpr std::array tried_after{20, 26, 32, 38, 44, 50, 56, 61};

double midway(const std::vector<double>& mu, int place) {
    const auto k = size(place);
    return (mu[k] + mu[k + 1]) / 2;
}

/// The share of a spline's value midway between two nodes that each of the four around it has.
std::array<double, 4> midway_shares(const std::vector<double>& mu, int place) {
    const double* const at = mu.data() + place;
    const double left = (at[1] - at[0]) / (8 * (at[1] - at[-1])),
                 right = (at[1] - at[0]) / (8 * (at[2] - at[0]));
    return {-left, 0.5 + right, 0.5 + left, -right};
}

/// The largest relative error of splines through f |mu_i| at azimuths between pairs of nodes: `mu` has
/// 0 and the nodes above it, a colour is solved there and then midway after each of `tried_after`.
double spline_error(const SolvedStack& colour, LitSide side, const std::vector<double>& mu,
                    int threads) {
    constexpr int tried = int_size(tried_after), steps = 32;
    std::vector<double> azimuths;  // dense forward and back, where droplets have peaks
    for (int k = 0; k <= steps; ++k) {
        const double share = static_cast<double>(k) / steps;
        azimuths.insert(azimuths.end(), {pi * share * share, pi * (1 - share * share)});
    }
    std::array<double, tried> worst{};
    const int first_tried = int_size(mu);
    parallel_for(tried, threads, [&](int i) {
        const auto row = size(i);
        const int in = tried_after[row];
        const std::array<double, 4> in_shares = midway_shares(mu, in);
        for (int o = 0; o < tried; ++o) {
            const int out = tried_after[size(o)];
            const std::array<double, 4> out_shares = midway_shares(mu, out);
            std::vector<double> spline(azimuths.size());
            for (int a = 0; a < 4; ++a)
                for (int b = 0; b < 4; ++b) {
                    const auto from = size(a), to = size(b);
                    const double share = in_shares[from] * out_shares[to] * mu[size(in - 1 + a)];
                    const auto samples = colour.values(side, in - 1 + a, out - 1 + b, azimuths);
                    for (std::size_t k = 0; k < samples.size(); ++k)
                        spline[k] += share * samples[k].total;
                }
            const auto exact = colour.values(side, first_tried + i, first_tried + o, azimuths);
            for (std::size_t k = 0; k < exact.size(); ++k)
                if (exact[k].total > 0)
                    worst[row] = std::max(
                        worst[row], std::abs(spline[k] / (midway(mu, in) * exact[k].total) - 1));
        }
    });
    return std::ranges::max(worst);
}

class FourierTable {
  public:
    FourierTable(const Material& material, const MaterialOptions& options)
        : positive_(cosines_above_zero()), mu_(signed_cosines(positive_)) {
        std::vector<double> nodes{grazing};
        nodes.insert(nodes.end(), positive_.begin(), positive_.end());
        std::vector<double> solved = nodes;
        for (const int place : tried_after) solved.push_back(midway(nodes, place));
        const SolvedColours colours = solve_colours(material, solved, options);
        channels_ = int_size(colours);
        const bool symmetric = std::ranges::all_of(colours, &SolvedStack::is_symmetric);
        const auto all_series = [&](LitSide side, bool symmetric_side, double& error) {
            for (const SolvedStack& colour : colours)
                error = std::max(error, spline_error(colour, side, nodes, options.threads));
            return make_series(colours, side, int_size(nodes), symmetric_side, options.threads);
        };
        const SideSeries above = all_series(LitSide::reflection, true, reflection_error_);
        const bool same = symmetric && std::ranges::all_of(colours, &SolvedStack::is_transparent);
        const SideSeries below =
            same ? above : all_series(LitSide::reflection_below, true, reflection_error_);
        const SideSeries through =
            all_series(LitSide::transmission, symmetric, transmission_error_);
        for (std::size_t o = 0; o < mu_.size(); ++o) {
            std::vector<double> means;
            for (std::size_t i = 0; i < mu_.size(); ++i) {
                const std::size_t from = place(i), to = place(o);
                const bool up = is_up(o);
                const Functions& series = up != is_up(i) ? (up ? above : below)[from][to]
                                          : up           ? through[to][from]
                                                         : through[from][to];
                means.push_back(put(series, i, o));
            }
            const std::vector<float> sums = spline_integrals(mu_, means);
            cdf_.insert(cdf_.end(), sums.begin(), sums.end());
        }
    }

    /// Returns how far readers' splines are off midway between cosines from 0.15 on, as text; empty
    /// within `tolerance`.
    std::string error_beyond(double tolerance) const {
        std::string text;
        for (const auto& [name, error] :
             {std::pair("R", reflection_error_), std::pair("T", transmission_error_)})
            if (error > tolerance)
                text += (text.empty() ? "" : ", ") + short_number(100 * error, 2) + " % of " + name;
        return text;
    }

    std::vector<char> encode(const std::string& text) const {
        Encoder file;
        file.put(std::string_view("SCATFUN\x01"));
        const auto count = [](std::size_t n) { return static_cast<std::uint32_t>(n); };
        for (const std::uint32_t number :
             {1u, count(mu_.size()), count(coefficients_.size()), count(longest_),
              static_cast<std::uint32_t>(channels_), 1u, count(text.size()), 0u, 0u})
            file.put(number);
        for (const float number : {1.0f, 0.0f, 0.0f, 0.0f, 0.0f}) file.put(number);
        file.put(mu_);
        file.put(cdf_);
        file.put(places_);
        file.put(coefficients_);
        file.put(std::string_view(text));
        return file.finish();
    }

  private:
    bool is_up(std::size_t k) const { return k > positive_.size(); }

    /// Returns the place of a node among the cosines solved.
    std::size_t place(std::size_t k) const {
        return is_up(k) ? k - positive_.size() - 1 : positive_.size() - k;
    }

    double cosine(std::size_t k) const { return place(k) == 0 ? 0 : positive_[place(k) - 1]; }

    /// Appends the series of a pair; returns its mean.
    double put(const Functions& series, std::size_t i, std::size_t o) {
        const double mu_i = cosine(i), mean = series.empty() ? 0 : series[0][0] * mu_i;
        if (!(mean <= largest_mean))
            throw std::invalid_argument(
                "export: f cos of fourier must have a mean over azimuth of at most 8, got " +
                short_number(mean, 3) + " at cosines " + short_number(mu_i, 3) + " and " +
                short_number(cosine(o), 3) +
                ": the peak of the phase function is too narrow for this depth");
        const bool empty = !(static_cast<float>(mean) > 0);
        const std::size_t length = empty ? 0 : series[0].size();
        places_.push_back(static_cast<std::int32_t>(coefficients_.size()));
        places_.push_back(static_cast<std::int32_t>(length));
        longest_ = std::max(longest_, length);
        if (empty) return 0;
        for (const std::vector<double>& channel : series)
            for (const double term : channel)
                coefficients_.push_back(static_cast<float>(term * mu_i));
        return mean;
    }

    std::vector<double> positive_;
    std::vector<float> mu_;
    int channels_ = 1;
    std::size_t longest_ = 0;
    std::vector<float> cdf_, coefficients_;
    std::vector<std::int32_t> places_;
    double reflection_error_ = 0, transmission_error_ = 0;
};

}  // namespace

MaterialFile make_fourier(const Material& material, const MaterialOptions& options) {
    MaterialFile file;
    const FourierTable table(material, options);
    const std::string error = table.error_beyond(options.tolerance);
    if (!error.empty())
        file.notes.push_back(
            "between the file's cosines readers are off by up to " + error +
            ", most of it straight on or back, where the phase function or the ground peaks");
    file.write = writing(
        table.encode(describe(material) + ". Without the beam straight through, exp(-tau/mu)."));
    return file;
}

}  // namespace stratus
