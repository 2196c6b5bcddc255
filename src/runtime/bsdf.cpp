#include <stratus/runtime/bsdf.h>

#include <stratus/runtime/constants.h>

#include "kernels/light_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace stratus {
namespace {

// Samples of the density: incident cosines; places of mu_out in each part of the sphere; azimuths.
constexpr int rows = 25, places = 12, azimuths = 12;
/// Parts of the sphere: over Leaves, from mu_in to the normal and from mu_in to the horizon.
constexpr int parts = 4, lines = parts * places;

std::size_t size(int n) { return static_cast<std::size_t>(n); }

/// `low` for not-a-number. With branches: it is foreseen that they change nothing.
[[gnu::always_inline]] inline float within(float low, float x, float high) noexcept {
    return x > low ? (x < high ? x : high) : low;
}

/// A cosine by its coordinate v = sqrt(1 - sqrt(mu)): half the angle to the normal near it, half
/// the root of the cosine below 1 near the horizon.
struct Cosine {
    float v, root_mu, mu;
};

// Both ends are a little inside, where nothing is divided by 0.
constexpr float normal_v = 1e-6f, horizon_v = 1 - 5e-5f;

Cosine cosine_at(float v) noexcept {
    const float inside = within(normal_v, v, horizon_v);
    const float root_mu = (1 - inside) * (1 + inside);
    return {inside, root_mu, root_mu * root_mu};
}

Cosine cosine_of(const DirectionDensity::Inclination& to_normal) noexcept {
    const float mu = within(0, to_normal.cosine, 1);
    return cosine_at(square_root(to_normal.sine_squared / ((1 + mu) * (1 + square_root(mu)))));
}

/// Two at the cost of one division.
struct Cosines {
    Cosine in, out;

    Cosines(const DirectionDensity::Inclination& from,
            const DirectionDensity::Inclination& to) noexcept {
        const float mu_in = within(0, from.cosine, 1), mu_out = within(0, to.cosine, 1);
        const float below_in = (1 + mu_in) * (1 + square_root(mu_in));
        const float below_out = (1 + mu_out) * (1 + square_root(mu_out));
        const float one_over = 1 / (below_in * below_out);
        in = cosine_at(square_root(from.sine_squared * below_out * one_over));
        out = cosine_at(square_root(to.sine_squared * below_in * one_over));
    }
};

/// Among the incident cosines of the density; 0 at the normal itself.
float row_place(const Cosine& in) noexcept { return (in.v - normal_v) * (rows - 1); }

DirectionDensity::Inclination inclination(float mu) noexcept {
    return {mu, maximum((1 - mu) * (1 + mu), 0.0f)};
}

float sine(const Cosine& cosine) noexcept {
    return cosine.v * square_root((1 + cosine.root_mu) * (1 + cosine.mu));
}

/// One part of the sphere of outgoing directions, seen from mu_in. Numbers in place of choices, for
/// a branch would be as good as never foreseen.
struct Part {
    int number;

    Part(Side side, bool to_horizon) noexcept
        : number(2 * static_cast<int>(side) + (to_horizon ? 1 : 0)) {}
    explicit Part(int number_) noexcept : number(number_) {}

    Side side() const noexcept { return static_cast<Side>(number / 2); }
    int line() const noexcept { return places * number; }
    /// From mu_in to its end, with a sign.
    float reach(const Cosine& in) const noexcept { return as_float(number % 2) - in.v; }
};

/// From mu_in, s = 0, to an end, s = 1: v - v_in = reach (slope s + (1 - slope) s^2).
struct OutgoingCosine {
    Cosine cosine;
    float stretch;  // |d mu / d s|
};

OutgoingCosine outgoing_cosine(const Part& part, float slope, const Cosine& in, float s) noexcept {
    const float reach = part.reach(in);
    const Cosine out = cosine_at(in.v + reach * s * (slope + (1 - slope) * s));
    return {out, std::abs(reach) * (slope + 2 * (1 - slope) * s) * (4 * out.v * out.root_mu)};
}

/// tan(azimuth / 2) = a q / (b (1 - q)), q in [0, 1].
struct AzimuthScale {
    float a, b;
};

[[gnu::always_inline]] inline AzimuthScale azimuth_scale(Side side,
                                                         const DirectionDensity::Peaks& peaks,
                                                         const Cosine& in,
                                                         const Cosine& out) noexcept {
    // The least and the largest angle from the middle of either peak, as azimuth goes around.
    const float apart = std::abs(in.v - out.v), sum = in.v + out.v;
    const float elevation = (in.mu + out.mu) * 0.5f;
    const float nearer = (peaks.at_same_cosine + apart) * (peaks.at_horizon + 1);
    const float farther = (peaks.at_same_cosine + sum) * (peaks.at_horizon + elevation);
    const float both[2] = {farther, nearer};
    const int index = static_cast<int>(side);
    return {both[index], both[1 - index]};
}

struct Azimuth {
    float cosine, sine;
    float stretch;  // d azimuth / d q
};

Azimuth azimuth_at(const AzimuthScale& scale, float q) noexcept {
    const float x = scale.b * (1 - q), y = scale.a * q;
    const float one_over = 1 / (x * x + y * y);
    return {(x - y) * (x + y) * one_over, 2 * x * y * one_over, 2 * scale.a * scale.b * one_over};
}

/// A place in [0, last] with the density of a tent around a sample, folded back at both ends.
float around_sample(int sample, int last, float u) noexcept {
    const float w = 2 * u - 1;
    const float tent = std::copysign(1 - square_root(within(0, 1 - std::abs(w), 1)), w);
    const float place = std::abs(as_float(sample) + tent);
    return std::min(place, as_float(2 * last) - place);
}

/// One of `count` events of given cumulative probability, and what is left of the random number.
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

/// Directions of one incident cosine, to be evaluated together.
class Geometries {
  public:
    void add(Side side, const Cosine& in, const OutgoingCosine& out, const Azimuth& azimuth) {
        const float sine_out = sine(out.cosine);
        const bool lit = side == Side::reflection;
        const float vectors[6] = {sine(in),
                                  0,
                                  in.mu,
                                  -sine_out * azimuth.cosine,
                                  sine_out * azimuth.sine,
                                  lit ? out.cosine.mu : -out.cosine.mu};
        for (std::size_t i = 0; i < 6; ++i) vectors_[i].push_back(vectors[i]);
    }

    std::size_t count() const { return vectors_[0].size(); }

    void evaluate(const DirectionDensity::Light& light, float* value) const {
        const float* const in[3] = {vectors_[0].data(), vectors_[1].data(), vectors_[2].data()};
        const float* const out[3] = {vectors_[3].data(), vectors_[4].data(), vectors_[5].data()};
        light(count(), in, out, value);
    }

  private:
    std::array<std::vector<float>, 6> vectors_;
};

constexpr float no_peak = 100;  // wide enough for all coordinates to be even

/// The width of a peak that light at equal cosines meets as azimuth goes around: of
/// Henyey-Greenstein's, the root of a quarter of (1 - g)^2 / g.
float peak_width(const DirectionDensity::Light& light, Side side, float mu, bool at_same_cosine) {
    constexpr int octaves = 20;
    const bool at_azimuth_0 = (side == Side::transmission) == at_same_cosine;
    const Cosine cosine = cosine_of(inclination(mu));
    const auto share_at = [&](int n) { return n == 0 ? 0 : std::ldexp(1.0f, n - octaves); };
    Geometries geometries;
    for (int n = 0; n <= octaves; ++n) {
        const float share = at_azimuth_0 ? share_at(n) : 1 - share_at(n);  // sin^2(azimuth / 2)
        geometries.add(side, cosine, {cosine, 0},
                       {1 - 2 * share, 2 * square_root(share * (1 - share)), 0});
    }
    std::vector<float> value(geometries.count());
    geometries.evaluate(light, value.data());
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

float end_half(int sample, int count) { return sample == 0 || sample == count - 1 ? 0.5f : 1.0f; }

}  // namespace

struct DirectionDensity::Place {
    std::size_t row, line, azimuth;  // samples, and how far on from them
    float past_row, past_line, past_azimuth;

    Place(float at_row, int first_line, float at_line, float at_azimuth) noexcept {
        const auto part = [](float at, int count, std::size_t& whole, float& rest) {
            const float from = within(0, at, as_float(count - 1) * (1 - 1e-7f));
            const auto n = truncated(from);
            whole = static_cast<std::size_t>(n);
            rest = from - as_float(n);
        };
        part(at_row, rows, row, past_row);
        part(at_line, places, line, past_line);
        part(at_azimuth, azimuths, azimuth, past_azimuth);
        line += static_cast<std::size_t>(first_line);
    }
};

DirectionDensity::DirectionDensity(const Light& light) {
    for (const Side side : {Side::reflection, Side::transmission})
        peaks_[static_cast<int>(side)] = peaks_of(light, side);
    std::vector<float> value(size(lines * azimuths)), stretch(value.size());
    for (int row = 0; row < rows; ++row) {
        constexpr float lowest = 0.995f;  // mu = 1e-4: of the limit at 0, thin layers know nothing
        const Cosine in = cosine_at(std::min(as_float(row) / (rows - 1), lowest));
        Geometries geometries;
        for (int line = 0; line < lines; ++line) {
            const Part part = Part(line / places);
            const Peaks& peaks = peaks_[static_cast<int>(part.side())];
            const OutgoingCosine out =
                outgoing_cosine(part, peaks.slope, in, as_float(line % places) / (places - 1));
            const AzimuthScale scale = azimuth_scale(part.side(), peaks, in, out.cosine);
            for (int k = 0; k < azimuths; ++k) {
                const Azimuth azimuth = azimuth_at(scale, as_float(k) / (azimuths - 1));
                stretch[geometries.count()] = out.cosine.mu * out.stretch * azimuth.stretch;
                geometries.add(part.side(), in, out, azimuth);
            }
        }
        geometries.evaluate(light, value.data());
        std::array<double, lines> mass{};
        double all = 0;
        for (int line = 0; line < lines; ++line) {
            for (int k = 0; k < azimuths; ++k) {
                float& here = value[size(line * azimuths + k)];
                here *= stretch[size(line * azimuths + k)];
                mass[size(line)] += double{here} * end_half(k, azimuths);
            }
            all += mass[size(line)] * end_half(line % places, places);
        }
        const double scale = all > 0 ? (places - 1) * (azimuths - 1) / all : 0;
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
            line_sum += here * end_half(line % places, places);
        }
        over_lines_.push_back(all > 0 ? 1.0f : 0.0f);
    }
}

[[gnu::always_inline]] inline float DirectionDensity::at(const Place& place) const noexcept {
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
    const Part part(side, out.v > in.v);
    const AzimuthScale scale = azimuth_scale(side, peaks, in, out);
    const float x = scale.a * half.cosine, y = scale.b * half.sine;
    const float one_over = 1 / (x + y);
    const float reach = std::abs(part.reach(in));
    const float distance = within(0, std::abs(out.v - in.v) / reach, 1);
    // distance = slope s + (1 - slope) s^2, solved for s
    const float slope_here =
        square_root(peaks.slope * peaks.slope + 4 * (1 - peaks.slope) * distance);
    const float s = (slope_here - peaks.slope) * peaks.half_over_bend;
    const float density =
        at(Place(row_place(in), part.line(), s * (places - 1), y * one_over * (azimuths - 1)));
    // d mu / d s times d azimuth / d q, and one of two signs of the azimuth
    return density * (scale.a * scale.b) * half.square * (one_over * one_over) /
           (reach * slope_here * (16 * out.v * out.root_mu));
}

struct DirectionDensity::Draw {
    Cosine in;
    float at_row;
    std::size_t row;
    Event line;
    float u2;
};

/// What follows once the side is known. One function for either: the branch between them is met
/// early, and those that come later, in the slice too, then go the same way.
template <Side side>
[[gnu::always_inline]] inline DirectionDensity::Direction DirectionDensity::draw(
    const Draw& given) const noexcept {
    const Part part(given.line.number / places);
    const Peaks& peaks = peaks_[static_cast<int>(side)];
    const float at_line = around_sample(given.line.number % places, places - 1, given.line.rest);
    const OutgoingCosine out =
        outgoing_cosine(part, peaks.slope, given.in, at_line * (1.0f / (places - 1)));

    const std::size_t line = given.row * lines + static_cast<std::size_t>(given.line.number);
    const float around = inside_unit(given.u2) * 2 - 1;
    const Event event_along = event<azimuths>(along_azimuth_.data() + line * (azimuths + 1),
                                              inside_unit(std::abs(around)));
    const float at_azimuth = around_sample(event_along.number, azimuths - 1, event_along.rest);
    const Azimuth azimuth = azimuth_at(azimuth_scale(side, peaks, given.in, out.cosine),
                                       at_azimuth * (1.0f / (azimuths - 1)));
    const float density = at(Place(given.at_row, part.line(), at_line, at_azimuth));
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
    const Draw given{in, at_row, row, event<lines>(over_lines, inside_unit(u1)), u2};
    return given.line.number < lines / 2 ? draw<Side::reflection>(given)
                                         : draw<Side::transmission>(given);
}

std::size_t DirectionDensity::bytes() const noexcept {
    return sizeof *this +
           sizeof(float) * (density_.size() + along_azimuth_.size() + over_lines_.size());
}

namespace {

constexpr float one_over_pi = static_cast<float>(1 / pi);

float times(float value, float factor) noexcept { return value * factor; }
Rgb times(const Rgb& value, float factor) noexcept {
    return {value.r * factor, value.g * factor, value.b * factor};
}

void set(float& value, const float* channel) noexcept { value = channel[0]; }
void set(Rgb& value, const float* channel) noexcept {
    value = {channel[0], channel[1], channel[2]};
}

/// Gauss-Legendre on [0, 1].
struct Quadrature {
    static constexpr int nodes = 16;
    float x[nodes], weight[nodes];

    Quadrature() {
        for (int i = 0; i < nodes; ++i) {
            double z = std::cos(pi * (i + 0.75) / (nodes + 0.5)), slope = 1;
            for (int step = 0; step < 6; ++step) {  // Newton; converges quadratically
                double p = 1, before = 0;
                for (int l = 0; l < nodes; ++l) {
                    const double next = ((2 * l + 1) * z * p - l * before) / (l + 1);
                    before = p;
                    p = next;
                }
                slope = nodes * (z * p - before) / (z * z - 1);
                z -= p / slope;
            }
            x[i] = static_cast<float>((1 - z) / 2);
            weight[i] = static_cast<float>(1 / ((1 - z * z) * slope * slope));
        }
    }
};

// Samples of the albedo over the coordinate of mu_in.
constexpr int albedo_rows = 129;

/// Share of a beam that the layer intercepts; 1 where it is not all that scatters.
template <int channels>
float intercepted(const SliceOf<channels>& slice, int channel, float mu) noexcept {
    if (slice.is_one_sided()) return 1;
    const float depth = static_cast<float>(std::min(slice.medium().optical_depth[channel], 1e30));
    return attenuation(depth / std::max(mu, min_cosine)).extinguished;
}

/// The horizontal part of an incident direction; along x where it has none.
struct Horizontal {
    float x, y, square;

    explicit Horizontal(const Vector& w) noexcept
        : x(w.x + 1e-15f), y(w.y), square(x * x + y * y) {}
};

}  // namespace

template <int channels>
BsdfOf<channels>::BsdfOf(SliceOf<channels> slice)
    : slice_(std::move(slice)),
      density_([this](std::size_t count, const float* const wi[3], const float* const wo[3],
                      float* value) {
          std::vector<float> all(channels * count);
          slice_.eval(count, wi, wo, all.data());
          for (std::size_t i = 0; i < count; ++i) {
              value[i] = all[i];
              for (std::size_t c = 1; c < channels; ++c) value[i] += all[c * count + i];
          }
      }) {
    const Quadrature gauss;
    std::vector<float> value, weight;
    for (int row = 0; row < albedo_rows; ++row) {
        const Cosine in = cosine_at(as_float(row) / (albedo_rows - 1));
        for (const Side side : {Side::reflection, Side::transmission}) {
            const DirectionDensity::Peaks& peaks = density_.peaks(side);
            Geometries geometries;
            weight.clear();
            for (const bool to_horizon : {false, true})
                for (int i = 0; i < gauss.nodes; ++i) {
                    const OutgoingCosine out =
                        outgoing_cosine(Part(side, to_horizon), peaks.slope, in, gauss.x[i]);
                    const AzimuthScale scale = azimuth_scale(side, peaks, in, out.cosine);
                    for (int k = 0; k < gauss.nodes; ++k) {
                        const Azimuth azimuth = azimuth_at(scale, gauss.x[k]);
                        weight.push_back(2 * gauss.weight[i] * gauss.weight[k] * out.cosine.mu *
                                         out.stretch * azimuth.stretch);
                        geometries.add(side, in, out, azimuth);
                    }
                }
            value.resize(channels * weight.size());
            geometries.evaluate([this](auto... arguments) { slice_.eval(arguments...); },
                                value.data());
            for (int c = 0; c < channels; ++c) {
                double sum = 0;
                for (std::size_t i = 0; i < weight.size(); ++i)
                    sum += double{weight[i]} * value[size(c) * weight.size() + i];
                const float share = intercepted(slice_, c, in.mu);
                albedo_.push_back(share > 0 ? static_cast<float>(sum) / share : 0);
            }
        }
    }
}

template <int channels>
typename BsdfOf<channels>::Value BsdfOf<channels>::eval(Side side, float mu_in, float mu_out,
                                                        float azimuth) const noexcept {
    return times(side == Side::reflection ? slice_.reflection(mu_in, mu_out, azimuth)
                                          : slice_.transmission(mu_in, mu_out, azimuth),
                 one_over_pi);
}

template <int channels>
bool BsdfOf<channels>::is_lit(const Vector& wi) const noexcept {
    return (wi.z > 0) | ((wi.z < 0) & !slice_.is_one_sided());
}

template <int channels>
float BsdfOf<channels>::pdf(Side side, float mu_in, float mu_out, float azimuth) const noexcept {
    const float half = half_azimuth_sine_squared(azimuth);
    return density_.pdf(side, inclination(mu_in), inclination(mu_out),
                        {square_root(1 - half), square_root(half), 1});
}

template <int channels>
float BsdfOf<channels>::pdf(const Vector& wi, const Vector& wo) const noexcept {
    const float sides = wi.z * wo.z;
    if (!is_lit(wi) || sides == 0) return 0;
    const Horizontal in(wi);
    const float square = wo.x * wo.x + wo.y * wo.y;
    // Light travels along -wi: cos(azimuth) = -dot / m, and of tan(azimuth / 2) = |cross| / (m -
    // dot) = (m + dot) / |cross| the one that loses nothing.
    const float dot = in.x * wo.x + in.y * wo.y, cross = std::abs(in.x * wo.y - in.y * wo.x);
    const float m = std::max(square_root(in.square * square), 1e-18f);
    const float both[2] = {cross, m + std::abs(dot)};
    const int backward = dot > 0 ? 1 : 0;
    return density_.pdf(static_cast<Side>(sides < 0 ? 1 : 0), {std::abs(wi.z), in.square},
                        {std::abs(wo.z), square},
                        {both[1 - backward], both[backward], 2 * m * both[1]});
}

template <int channels>
typename BsdfOf<channels>::Sample BsdfOf<channels>::sample(const Vector& wi, float u1, float u2,
                                                           float u3) const noexcept {
    if (!is_lit(wi)) return {};
    const Horizontal in(wi);
    const DirectionDensity::Direction out =
        density_.sample({std::abs(wi.z), in.square}, u1, u2, u3);
    const float scale = out.sine * reciprocal_root(in.square);
    const float along = -scale * out.cos_azimuth, aside = -scale * out.sin_azimuth;
    const float side = 1 - 2 * as_float(static_cast<int>(out.side));
    const Vector wo{along * in.x - aside * in.y, along * in.y + aside * in.x,
                    std::copysign(out.mu, wi.z) * side};
    return {wo, slice_.eval(wi, wo), out.pdf};
}

template <int channels>
typename BsdfOf<channels>::SampleOfAngles BsdfOf<channels>::sample(float mu_in, float u1, float u2,
                                                                   float u3) const noexcept {
    const DirectionDensity::Direction out = density_.sample(inclination(mu_in), u1, u2, u3);
    const float azimuth = std::atan2(out.sin_azimuth, out.cos_azimuth);
    return {out.side, out.mu, azimuth, eval(out.side, mu_in, out.mu, azimuth), out.pdf};
}

template <int channels>
ScatteredShares<typename BsdfOf<channels>::Value> BsdfOf<channels>::albedo(
    float mu_in) const noexcept {
    const float place = cosine_of(inclination(mu_in)).v * (albedo_rows - 1);
    const int row = truncated(within(0, place, albedo_rows - 2));
    const float past = place - as_float(row);
    const float* const here = albedo_.data() + row * 2 * channels;
    float channel[2 * channels];
    for (int i = 0; i < 2 * channels; ++i)
        channel[i] = (here[i] + past * (here[i + 2 * channels] - here[i])) *
                     intercepted(slice_, i % channels, mu_in);
    ScatteredShares<Value> shares;
    set(shares.reflected, channel);
    set(shares.transmitted, channel + channels);
    return shares;
}

template <int channels>
ScatteredShares<typename BsdfOf<channels>::Value> BsdfOf<channels>::albedo(
    const Vector& wi) const noexcept {
    return is_lit(wi) ? albedo(std::abs(wi.z)) : ScatteredShares<Value>{};
}

template <int channels>
std::size_t BsdfOf<channels>::bytes() const noexcept {
    return sizeof *this - sizeof slice_ - sizeof density_ + slice_.bytes() + density_.bytes() +
           albedo_.size() * sizeof(float);
}

template class BsdfOf<1>;
template class BsdfOf<3>;

}  // namespace stratus
