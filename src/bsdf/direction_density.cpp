#include <stratus/bsdf/bsdf.h>

#include <stratus/base/size.h>

#include "direction_coordinates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace stratus {
namespace {

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

using HalfAzimuth = DirectionDensity::HalfAzimuth;
using Direction = DirectionDensity::Direction;

constexpr float no_peak = 100;  // wide enough for even coordinates

/// The width of a peak, from azimuths at equal cosines; sqrt((1 - g)^2 / (4 g)) for
/// Henyey-Greenstein.
float peak_width(const Light& light, Side side, float mu, bool at_same_cosine) {
    constexpr int octaves = 20;
    const bool at_azimuth_0 = (side == Side::transmission) == at_same_cosine;
    const Cosine cosine = to_cosine(inclination(mu));
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

Peaks make_peaks(const Light& light, Side side) {
    constexpr float slanting = 0.5f, grazing = 0.02f, slope_of_width = 4, largest_slope = 0.9f;
    const float width = peak_width(light, side, slanting, true);
    const float slope = std::min(largest_slope, slope_of_width * width);
    return {width, peak_width(light, side, grazing, false), slope, 0.5f / (1 - slope)};
}

// Samples of the density: incident cosines; outgoing ones in each quarter of the sphere; azimuths.
// The samples of peaks hold a rainbow too.
struct LobeGrid : LobeCoordinates {
    static constexpr int rows = 25, quarter_lines = 12, azimuths = 12, lines = 4 * quarter_lines;
};
struct PeakedGrid : PeakedCoordinates {
    static constexpr int rows = 33, quarter_lines = 24, azimuths = 32, lines = 4 * quarter_lines;
};

template <class Grid>
struct SamplePlace {
    std::size_t row, line, azimuth;  // samples, and the share of the way to the next
    float past_row, past_line, past_azimuth;

    SamplePlace(float at_row, const SphereQuarter& quarter, float at_line,
                float at_azimuth) noexcept {
        const auto split = [](float at, int count, std::size_t& whole, float& rest) {
            const float from = within(0, at, as_float(count - 1) * (1 - 1e-7f));
            const auto n = truncated(from);
            whole = size(n);
            rest = from - as_float(n);
        };
        split(at_row, Grid::rows, row, past_row);
        split(at_line, Grid::quarter_lines, line, past_line);
        split(at_azimuth, Grid::azimuths, azimuth, past_azimuth);
        line += size(Grid::quarter_lines * quarter.number);
    }
};

/// A sample counts by half at either end.
float end_half(int sample, int count) { return sample == 0 || sample == count - 1 ? 0.5f : 1.0f; }

/// Light per area of the coordinates at incident cosine `in`, of all channels one after the other:
/// at lines and azimuths a share `past` of the way from sample to sample, row by row.
template <class Grid>
std::vector<float> light_at(int channels, const PerSide<Peaks>& all_peaks, const Light& light,
                            const Cosine& in, float past) {
    const int moved = past > 0 ? 1 : 0;  // one sample fewer along either axis
    DirectionPairs pairs;
    std::vector<float> stretch;
    for (int number = 0; number < 4; ++number)
        for (int line = 0; line < Grid::quarter_lines - moved; ++line) {
            const SphereQuarter quarter(number);
            const Peaks& peaks = all_peaks[quarter.side()];
            const OutgoingCosine out = Grid::outgoing_cosine(
                quarter, peaks, in, (as_float(line) + past) / (Grid::quarter_lines - 1));
            const auto scale = Grid::azimuth_scale(quarter.side(), peaks, in, out.cosine);
            for (int k = 0; k < Grid::azimuths - moved; ++k) {
                const Azimuth azimuth =
                    Grid::azimuth_at(scale, (as_float(k) + past) / (Grid::azimuths - 1));
                stretch.push_back(out.cosine.mu * out.stretch * azimuth.stretch);
                pairs.add(quarter.side(), in, out, azimuth);
            }
        }
    std::vector<float> value(size(channels) * stretch.size());
    pairs.evaluate(light, value.data());
    for (std::size_t i = 0; i < value.size(); ++i)
        value[i] = std::max(value[i], 0.0f) * stretch[i % stretch.size()];
    return value;
}

/// The trapezoidal rule over the samples `value`.
template <class Grid>
double integral(const float* value) {
    double sum = 0;
    for (int line = 0; line < Grid::lines; ++line)
        for (int k = 0; k < Grid::azimuths; ++k)
            sum += double{*value++} * end_half(k, Grid::azimuths) *
                   end_half(line % Grid::quarter_lines, Grid::quarter_lines);
    return sum;
}

/// Calls cell(places of its four corners among the samples, value) for all values half-way between the
/// samples.
template <class Grid, class Cell>
void for_each_cell(const std::vector<float>& half_way, const Cell& cell) {
    constexpr std::size_t azimuths = size(Grid::azimuths),
                          quarter_lines = size(Grid::quarter_lines);
    auto met = half_way.begin();
    for (std::size_t line = 0; met != half_way.end(); ++line) {
        if (line % quarter_lines == quarter_lines - 1) continue;
        for (std::size_t k = line * azimuths; k < (line + 1) * azimuths - 1; ++k)
            cell({k, k + 1, k + azimuths, k + azimuths + 1}, *met++);
    }
}

/// The samples of all channels, raised until straight lines between them do not cut off what lies
/// half-way.
template <class Grid>
std::vector<float> raised(const std::vector<float>& value, const std::vector<float>& half_way) {
    std::vector<float> high = value;
    for_each_cell<Grid>(half_way, [&](const std::array<std::size_t, 4>& corners, float here) {
        float mean = 0;
        for (const std::size_t at : corners) mean += value[at] / 4;
        const float factor = here / std::max(mean, 1e-30f);
        for (const std::size_t at : corners) high[at] = std::max(high[at], factor * value[at]);
    });
    return high;
}

/// One density for several channels. Of densities f of each, of integral 1, and f' of its `raised`
/// samples, it is proportional to the largest over channels c of
///
///     f_c (light of c / light of the brightest)^4   and   f'_c / L.
///
/// For a single dim channel no density has less variance in the brightest one, of those that keep
/// weights below the same limit. Channels of much the same light count alike.
struct Envelope {
    std::vector<float> factor, factor_of_raised;  // of each channel

    std::vector<float> of(const std::vector<float>& value, const std::vector<float>& high) const {
        const std::size_t channels = factor.size(), count = value.size() / channels;
        std::vector<float> largest(count);
        for (std::size_t c = 0; c < channels; ++c)
            for (std::size_t i = 0; i < count; ++i)
                largest[i] = std::max({largest[i], factor[c] * value[c * count + i],
                                       factor_of_raised[c] * high[c * count + i]});
        return largest;
    }
};

/// With the largest L for which no channel's weight exceeds 3.95 times its mean. Between samples it
/// may, by a quarter where a rainbow is narrower than their distance.
template <class Grid>
Envelope envelope(int channels, const std::vector<float>& value, const std::vector<float>& high) {
    constexpr double max_weight = 3.95;
    std::vector<double> light;
    for (int c = 0; c < channels; ++c)
        light.push_back(integral<Grid>(&value[size(c) * value.size() / size(channels)]));
    const double brightest = *std::max_element(light.begin(), light.end());
    Envelope found{std::vector<float>(size(channels)), std::vector<float>(size(channels))};
    double low = 1, high_end = max_weight;
    for (int step = 0; step < 12; ++step) {
        const double L = (low + high_end) / 2;
        for (std::size_t c = 0; c < light.size(); ++c) {
            if (!(light[c] > 0)) continue;
            const double share = light[c] / brightest;
            found.factor[c] = static_cast<float>(share * share * share);
            found.factor_of_raised[c] = static_cast<float>(1 / (L * share));
        }
        const double all = integral<Grid>(found.of(value, high).data()) / brightest;
        (L * all <= max_weight ? low : high_end) = L;
    }
    return found;
}

/// Relative standard deviation of light over density, half-way between the samples `value`.
template <class Grid>
double deviation(const std::vector<float>& value, const std::vector<float>& half_way) {
    double sum = 0, density_sum = 0, squares = 0;
    for_each_cell<Grid>(half_way, [&](const std::array<std::size_t, 4>& corners, float light) {
        const double here{light};
        double density = 0;
        for (const std::size_t at : corners) density += double{value[at]} / 4;
        sum += here;
        density_sum += density;
        if (here > 0) squares += here * here / std::max(density, here * 1e-3);
    });
    return sum > 0 ? std::sqrt(std::max(squares * density_sum / (sum * sum) - 1, 0.0)) : 0;
}

struct Filled {
    DirectionDensity::Samples samples;
    double largest_deviation;
};

template <class Grid>
Filled filled(int channels, const PerSide<Peaks>& peaks, const Light& light) {
    constexpr int rows = Grid::rows, lines = Grid::lines, azimuths = Grid::azimuths;
    Filled made{};
    auto& [density, along_azimuth, over_lines] = made.samples;
    double& largest_deviation = made.largest_deviation;
    for (int row = 0; row < rows; ++row) {
        constexpr float lowest = 0.995f;  // mu = 1e-4: thin layers are far from their limit at 0
        const Cosine in = cosine_at(std::min(Grid::incident_v(as_float(row) / (rows - 1)), lowest));
        constexpr int check_every = 6;  // the horizon included: there all sharp peaks are seen
        const bool is_checked = row % check_every == 0;
        std::vector<float> value = light_at<Grid>(channels, peaks, light, in, 0), half_way;
        if (channels > 1 || is_checked) half_way = light_at<Grid>(channels, peaks, light, in, 0.5f);
        if (channels > 1) {
            const std::vector<float> high = raised<Grid>(value, half_way);
            const Envelope over = envelope<Grid>(channels, value, high);
            if (is_checked)
                largest_deviation =
                    std::max(largest_deviation,
                             deviation<Grid>(over.of(value, value), over.of(half_way, half_way)));
            value = over.of(value, high);
        } else if (is_checked) {
            largest_deviation = std::max(largest_deviation, deviation<Grid>(value, half_way));
        }
        std::array<double, lines> mass{};
        double all = 0;
        for (int line = 0; line < lines; ++line) {
            for (int k = 0; k < azimuths; ++k)
                mass[size(line)] +=
                    double{value[size(line * azimuths + k)]} * end_half(k, azimuths);
            all += mass[size(line)] * end_half(line % Grid::quarter_lines, Grid::quarter_lines);
        }
        const double scale = all > 0 ? (Grid::quarter_lines - 1) * (azimuths - 1) / all : 0;
        double line_sum = 0;
        for (int line = 0; line < lines; ++line) {
            double sum = 0;
            const double here = mass[size(line)];
            for (int k = 0; k < azimuths; ++k) {
                const double one = value[size(line * azimuths + k)];
                density.push_back(static_cast<float>(one * scale));
                along_azimuth.push_back(here > 0 ? static_cast<float>(sum / here) : 0);
                sum += one * end_half(k, azimuths);
            }
            along_azimuth.push_back(1);
            over_lines.push_back(all > 0 ? static_cast<float>(line_sum / all) : 0);
            line_sum += here * end_half(line % Grid::quarter_lines, Grid::quarter_lines);
        }
        over_lines.push_back(all > 0 ? 1.0f : 0.0f);
    }
    return made;
}

}  // namespace

DirectionDensity::DirectionDensity(int channels, const Light& light) {
    const Light sum = [&](std::size_t count, const float* const wi[3], const float* const wo[3],
                          float* value) {
        std::vector<float> all(size(channels) * count);
        light(count, wi, wo, all.data());
        for (std::size_t i = 0; i < count; ++i) {
            value[i] = all[i];
            for (std::size_t c = 1; c < size(channels); ++c) value[i] += all[c * count + i];
        }
    };
    for (const Side side : both_sides) peaks_[side] = make_peaks(sum, side);
    constexpr double bearable = 0.2;  // met by Henyey-Greenstein's g = 0.95
    Filled made = filled<LobeGrid>(channels, peaks_, light);
    if (made.largest_deviation > bearable) {
        Filled peaked = filled<PeakedGrid>(channels, peaks_, light);
        is_peaked_ = peaked.largest_deviation < made.largest_deviation;
        if (is_peaked_) made = std::move(peaked);
    }
    samples_ = std::move(made.samples);
}

namespace {

template <class Grid>
[[gnu::always_inline]] inline float density_at(const DirectionDensity& density,
                                               const SamplePlace<Grid>& place) noexcept {
    constexpr int lines = Grid::lines, azimuths = Grid::azimuths;
    const float* const here =
        density.samples().data() + (place.row * lines + place.line) * azimuths + place.azimuth;
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

float lobe_pdf(const DirectionDensity& density, Side side, const Inclination& from,
               const Inclination& to, const HalfAzimuth& half) noexcept {
    const auto [in, out] = Cosines(from, to);
    const Peaks& peaks = density.peaks(side);
    const SphereQuarter quarter(side, out.v > in.v);
    const AzimuthScale scale = LobeGrid::azimuth_scale(side, peaks, in, out);
    const float x = scale.a * half.cosine, y = scale.b * half.sine;
    const float one_over = 1 / (x + y);
    const float reach = std::abs(quarter.reach(in));
    const float distance = within(0, std::abs(out.v - in.v) / reach, 1);
    // distance = slope s + (1 - slope) s^2, solved for s
    const float slope_here =
        square_root(peaks.slope * peaks.slope + 4 * (1 - peaks.slope) * distance);
    const float s = (slope_here - peaks.slope) * peaks.half_over_bend;
    const float value = density_at(
        density, SamplePlace<LobeGrid>(LobeGrid::incident_place(in) * (LobeGrid::rows - 1), quarter,
                                       s * (LobeGrid::quarter_lines - 1),
                                       y * one_over * (LobeGrid::azimuths - 1)));
    // d mu / d s times d azimuth / d q, and one of two signs of the azimuth
    return value * (scale.a * scale.b) * half.square * (one_over * one_over) /
           (reach * slope_here * (16 * out.v * out.root_mu));
}

float peaked_pdf(const DirectionDensity& density, Side side, const Inclination& from,
                 const Inclination& to, const HalfAzimuth& half) noexcept {
    const auto [in, out] = Cosines(from, to);
    const Peaks& peaks = density.peaks(side);
    const SphereQuarter quarter(side, out.v > in.v);
    const float reach = std::abs(quarter.reach(in));
    const FourthRoot along = PeakedGrid::cosine_root(quarter, in);
    const FourthRoot around = PeakedGrid::azimuth_scale(side, peaks, in, out);
    const float s = along.place(within(0, std::abs(out.v - in.v) / reach, 1));
    const float t = half.sine / (square_root(half.square) + half.cosine);
    const float q = around.place(within(0, t, 1));
    const float value = density_at(
        density, SamplePlace<PeakedGrid>(PeakedGrid::incident_place(in) * (PeakedGrid::rows - 1),
                                         quarter, s * (PeakedGrid::quarter_lines - 1),
                                         q * (PeakedGrid::azimuths - 1)));
    // d mu / d s times d azimuth / d q, and one of two signs of the azimuth
    return value * (1 + t * t) /
           (reach * along.stretch(s) * around.stretch(q) * (32 * out.v * out.root_mu));
}

struct DrawnLine {
    Cosine in;
    float at_row;
    std::size_t row;
    Event line;
    float u2;
};

/// The rest of a draw, once the side is known. A function for each side: one branch between them
/// comes early, and later ones, in the slice too, are then predicted.
template <class Grid, Side side>
[[gnu::always_inline]] inline Direction draw(const DirectionDensity& density,
                                             const DrawnLine& given) noexcept {
    constexpr int quarter_lines = Grid::quarter_lines, azimuths = Grid::azimuths;
    const SphereQuarter quarter(given.line.number / quarter_lines);
    const Peaks& peaks = density.peaks(side);
    const float at_line =
        around_sample(given.line.number % quarter_lines, quarter_lines - 1, given.line.rest);
    const OutgoingCosine out =
        Grid::outgoing_cosine(quarter, peaks, given.in, at_line * (1.0f / (quarter_lines - 1)));

    const std::size_t line = given.row * Grid::lines + size(given.line.number);
    const float around = inside_unit(given.u2) * 2 - 1;
    const Event event_along = event<azimuths>(
        density.along_azimuth().data() + line * (azimuths + 1), inside_unit(std::abs(around)));
    const float at_azimuth = around_sample(event_along.number, azimuths - 1, event_along.rest);
    const Azimuth azimuth = Grid::azimuth_at(Grid::azimuth_scale(side, peaks, given.in, out.cosine),
                                             at_azimuth * (1.0f / (azimuths - 1)));
    const float value =
        density_at(density, SamplePlace<Grid>(given.at_row, quarter, at_line, at_azimuth));
    return {side,
            out.cosine.mu,
            sine(out.cosine),
            azimuth.cosine,
            std::copysign(azimuth.sine, around),
            value / (out.stretch * azimuth.stretch * 2)};
}

template <class Grid>
[[gnu::always_inline]] inline Direction sample_grid(const DirectionDensity& density,
                                                    const Inclination& from, float u1, float u2,
                                                    float u3) noexcept {
    constexpr int rows = Grid::rows, lines = Grid::lines;
    const Cosine in = to_cosine(from);
    const float at_row = Grid::incident_place(in) * (rows - 1);
    const auto low_row = truncated(within(0, at_row, rows - 2));
    const auto row = size(low_row + (u3 < at_row - as_float(low_row) ? 1 : 0));
    const float* const over_lines = density.over_lines().data() + row * (lines + 1);
    if (!(over_lines[lines] > 0)) return {Side::reflection, 1, 0, 1, 0, 0};
    const DrawnLine given{in, at_row, row, event<lines>(over_lines, inside_unit(u1)), u2};
    return given.line.number < lines / 2 ? draw<Grid, Side::reflection>(density, given)
                                         : draw<Grid, Side::transmission>(density, given);
}

}  // namespace

float DirectionDensity::pdf(Side side, const Inclination& from, const Inclination& to,
                            const HalfAzimuth& half) const noexcept {
    return is_peaked_ ? peaked_pdf(*this, side, from, to, half)
                      : lobe_pdf(*this, side, from, to, half);
}

Direction DirectionDensity::sample(const Inclination& from, float u1, float u2,
                                   float u3) const noexcept {
    return is_peaked_ ? sample_grid<PeakedGrid>(*this, from, u1, u2, u3)
                      : sample_grid<LobeGrid>(*this, from, u1, u2, u3);
}

std::size_t DirectionDensity::bytes() const noexcept {
    return sizeof *this +
           sizeof(float) * (samples().size() + along_azimuth().size() + over_lines().size());
}

}  // namespace stratus
