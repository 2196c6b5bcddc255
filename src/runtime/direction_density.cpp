#include <stratus/runtime/direction_density.h>

#include "direction_coordinates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace stratus {
namespace {

// Samples of the density: incident cosines; outgoing ones in each quarter of the sphere; azimuths.
constexpr int rows = 25, quarter_lines = 12, azimuths = 12;
constexpr int lines = 4 * quarter_lines;

std::size_t size(int n) { return static_cast<std::size_t>(n); }

/// Place among the incident cosines of the density, 0 at the normal.
float row_place(const Cosine& in) noexcept { return (in.v - normal_v) * (rows - 1); }

/// A place in [0, last] with the density of a tent around a sample, folded back at both ends.
float around_sample(int sample, int last, float u) noexcept {
    const float w = 2 * u - 1;
    const float tent = std::copysign(1 - square_root(within(0, 1 - std::abs(w), 1)), w);
    const float place = std::abs(as_float(sample) + tent);
    return std::min(place, as_float(2 * last) - place);
}

/// One of `count` events of given cumulative probability, and the random number made uniform
/// again.
struct Event {
    int number;
    float rest;
};

template <int count>
Event event(const float* cumulative, float u) noexcept {
    int number = -1;  // the first sum is 0
    for (int i = 0; i < count; ++i) number += cumulative[i] <= u ? 1 : 0;
    const float low = cumulative[number], high = cumulative[number + 1];
    return {number, (u - low) / std::max(high - low, 1e-30f)};
}

float inside_unit(float u) noexcept { return within(0, u, 1 - 6e-8f); }

constexpr float no_peak = 100;  // wide enough for even coordinates

/// The width of a peak, from azimuths at equal cosines; sqrt((1 - g)^2 / (4 g)) for
/// Henyey-Greenstein.
float peak_width(const DirectionDensity::Light& light, Side side, float mu, bool at_same_cosine) {
    constexpr int octaves = 20;
    const bool at_azimuth_0 = (side == Side::transmission) == at_same_cosine;
    const Cosine cosine = cosine_of(inclination(mu));
    const auto share_at = [&](int n) { return n == 0 ? 0 : std::ldexp(1.0f, n - octaves); };
    DirectionPairs pairs;
    for (int n = 0; n <= octaves; ++n) {
        const float share = at_azimuth_0 ? share_at(n) : 1 - share_at(n);  // sin^2(azimuth / 2)
        pairs.add(side, cosine, {cosine, 0},
                  {1 - 2 * share, 2 * square_root(share * (1 - share)), 0});
    }
    std::vector<float> value(pairs.count());
    pairs.evaluate(light, value.data());
    constexpr float fallen = 0.353553f;  // (1 + 1)^(-3/2)
    for (int n = 1; n <= octaves; ++n)
        if (value[size(n)] < fallen * value[0]) return sine(cosine) * square_root(share_at(n));
    return no_peak;
}

DirectionDensity::Peaks peaks_of(const DirectionDensity::Light& light, Side side) {
    constexpr float slanting = 0.5f, grazing = 0.02f, slope_of_width = 4, largest_slope = 0.9f;
    const float width = peak_width(light, side, slanting, true);
    const float slope = std::min(largest_slope, slope_of_width * width);
    return {width, peak_width(light, side, grazing, false), slope, 0.5f / (1 - slope)};
}

int first_line(const SphereQuarter& quarter) noexcept { return quarter_lines * quarter.number; }

float end_half(int sample, int count) { return sample == 0 || sample == count - 1 ? 0.5f : 1.0f; }

}  // namespace

struct DirectionDensity::SamplePlace {
    std::size_t row, line, azimuth;  // samples, and the share of the way to the next
    float past_row, past_line, past_azimuth;

    SamplePlace(float at_row, int first_line, float at_line, float at_azimuth) noexcept {
        const auto split = [](float at, int count, std::size_t& whole, float& rest) {
            const float from = within(0, at, as_float(count - 1) * (1 - 1e-7f));
            const auto n = truncated(from);
            whole = static_cast<std::size_t>(n);
            rest = from - as_float(n);
        };
        split(at_row, rows, row, past_row);
        split(at_line, quarter_lines, line, past_line);
        split(at_azimuth, azimuths, azimuth, past_azimuth);
        line += static_cast<std::size_t>(first_line);
    }
};

DirectionDensity::DirectionDensity(const Light& light) {
    for (const Side side : {Side::reflection, Side::transmission})
        peaks_[static_cast<int>(side)] = peaks_of(light, side);
    std::vector<float> value(size(lines * azimuths)), stretch(value.size());
    for (int row = 0; row < rows; ++row) {
        constexpr float lowest = 0.995f;  // mu = 1e-4: thin layers are far from their limit at 0
        const Cosine in = cosine_at(std::min(as_float(row) / (rows - 1), lowest));
        DirectionPairs pairs;
        for (int line = 0; line < lines; ++line) {
            const SphereQuarter quarter(line / quarter_lines);
            const Peaks& peaks = peaks_[static_cast<int>(quarter.side())];
            const OutgoingCosine out = outgoing_cosine(
                quarter, peaks.slope, in, as_float(line % quarter_lines) / (quarter_lines - 1));
            const AzimuthScale scale = azimuth_scale(quarter.side(), peaks, in, out.cosine);
            for (int k = 0; k < azimuths; ++k) {
                const Azimuth azimuth = azimuth_at(scale, as_float(k) / (azimuths - 1));
                stretch[pairs.count()] = out.cosine.mu * out.stretch * azimuth.stretch;
                pairs.add(quarter.side(), in, out, azimuth);
            }
        }
        pairs.evaluate(light, value.data());
        std::array<double, lines> mass{};
        double all = 0;
        for (int line = 0; line < lines; ++line) {
            for (int k = 0; k < azimuths; ++k) {
                float& here = value[size(line * azimuths + k)];
                here *= stretch[size(line * azimuths + k)];
                mass[size(line)] += double{here} * end_half(k, azimuths);
            }
            all += mass[size(line)] * end_half(line % quarter_lines, quarter_lines);
        }
        const double scale = all > 0 ? (quarter_lines - 1) * (azimuths - 1) / all : 0;
        double line_sum = 0;
        for (int line = 0; line < lines; ++line) {
            double sum = 0;
            const double here = mass[size(line)];
            for (int k = 0; k < azimuths; ++k) {
                const double one = value[size(line * azimuths + k)];
                density_.push_back(static_cast<float>(one * scale));
                along_azimuth_.push_back(here > 0 ? static_cast<float>(sum / here) : 0);
                sum += one * end_half(k, azimuths);
            }
            along_azimuth_.push_back(1);
            over_lines_.push_back(all > 0 ? static_cast<float>(line_sum / all) : 0);
            line_sum += here * end_half(line % quarter_lines, quarter_lines);
        }
        over_lines_.push_back(all > 0 ? 1.0f : 0.0f);
    }
}

[[gnu::always_inline]] inline float DirectionDensity::at(const SamplePlace& place) const noexcept {
    const float* const here =
        density_.data() + (place.row * lines + place.line) * azimuths + place.azimuth;
    const auto along = [&](const float* from) {
        return from[0] + place.past_azimuth * (from[1] - from[0]);
    };
    const auto across = [&](const float* from) {
        const float a = along(from), b = along(from + azimuths);
        return a + place.past_line * (b - a);
    };
    const float a = across(here), b = across(here + lines * azimuths);
    return a + place.past_row * (b - a);
}

float DirectionDensity::pdf(Side side, const Inclination& from, const Inclination& to,
                            const HalfAzimuth& half) const noexcept {
    const auto [in, out] = Cosines(from, to);
    const Peaks& peaks = peaks_[static_cast<int>(side)];
    const SphereQuarter quarter(side, out.v > in.v);
    const AzimuthScale scale = azimuth_scale(side, peaks, in, out);
    const float x = scale.a * half.cosine, y = scale.b * half.sine;
    const float one_over = 1 / (x + y);
    const float reach = std::abs(quarter.reach(in));
    const float distance = within(0, std::abs(out.v - in.v) / reach, 1);
    // distance = slope s + (1 - slope) s^2, solved for s
    const float slope_here =
        square_root(peaks.slope * peaks.slope + 4 * (1 - peaks.slope) * distance);
    const float s = (slope_here - peaks.slope) * peaks.half_over_bend;
    const float density = at(SamplePlace(row_place(in), first_line(quarter),
                                         s * (quarter_lines - 1), y * one_over * (azimuths - 1)));
    // d mu / d s times d azimuth / d q, and one of two signs of the azimuth
    return density * (scale.a * scale.b) * half.square * (one_over * one_over) /
           (reach * slope_here * (16 * out.v * out.root_mu));
}

struct DirectionDensity::DrawnLine {
    Cosine in;
    float at_row;
    std::size_t row;
    Event line;
    float u2;
};

/// The rest of a draw, once the side is known. A function for each side: one branch between them
/// comes early, and later ones, in the slice too, are then predicted.
template <Side side>
[[gnu::always_inline]] inline DirectionDensity::Direction DirectionDensity::draw(
    const DrawnLine& given) const noexcept {
    const SphereQuarter quarter(given.line.number / quarter_lines);
    const Peaks& peaks = peaks_[static_cast<int>(side)];
    const float at_line =
        around_sample(given.line.number % quarter_lines, quarter_lines - 1, given.line.rest);
    const OutgoingCosine out =
        outgoing_cosine(quarter, peaks.slope, given.in, at_line * (1.0f / (quarter_lines - 1)));

    const std::size_t line = given.row * lines + static_cast<std::size_t>(given.line.number);
    const float around = inside_unit(given.u2) * 2 - 1;
    const Event event_along = event<azimuths>(along_azimuth_.data() + line * (azimuths + 1),
                                              inside_unit(std::abs(around)));
    const float at_azimuth = around_sample(event_along.number, azimuths - 1, event_along.rest);
    const Azimuth azimuth = azimuth_at(azimuth_scale(side, peaks, given.in, out.cosine),
                                       at_azimuth * (1.0f / (azimuths - 1)));
    const float density = at(SamplePlace(given.at_row, first_line(quarter), at_line, at_azimuth));
    return {side,
            out.cosine.mu,
            sine(out.cosine),
            azimuth.cosine,
            std::copysign(azimuth.sine, around),
            density / (out.stretch * azimuth.stretch * 2)};
}

DirectionDensity::Direction DirectionDensity::sample(const Inclination& from, float u1, float u2,
                                                     float u3) const noexcept {
    const Cosine in = cosine_of(from);
    const float at_row = row_place(in);
    const auto low_row = truncated(within(0, at_row, rows - 2));
    const auto row = static_cast<std::size_t>(low_row + (u3 < at_row - as_float(low_row) ? 1 : 0));
    const float* const over_lines = over_lines_.data() + row * (lines + 1);
    if (!(over_lines[lines] > 0)) return {Side::reflection, 1, 0, 1, 0, 0};
    const DrawnLine given{in, at_row, row, event<lines>(over_lines, inside_unit(u1)), u2};
    return given.line.number < lines / 2 ? draw<Side::reflection>(given)
                                         : draw<Side::transmission>(given);
}

std::size_t DirectionDensity::bytes() const noexcept {
    return sizeof *this +
           sizeof(float) * (density_.size() + along_azimuth_.size() + over_lines_.size());
}

}  // namespace stratus
