#include <stratus/bsdf/bsdf.h>

#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/gauss_legendre.h>
#include <stratus/base/size.h>

#include "direction_coordinates.h"
#include "table/lookup_arguments.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {
namespace {

constexpr float one_over_pi = static_cast<float>(1 / pi);

/// Gauss-Legendre on [0, 1].
template <int nodes>
struct Quadrature {
    float x[nodes], weight[nodes];

    Quadrature() {
        const GaussLegendre gauss(nodes);
        for (std::size_t i = 0; i < nodes; ++i) {
            x[i] = static_cast<float>((1 - gauss.x[i]) / 2);
            weight[i] = static_cast<float>(gauss.weight[i] / 2);
        }
    }
};

// Samples of the albedo over the coordinate of mu_in.
constexpr int albedo_rows = 129;

/// Share of a beam that the layer intercepts; 1 over a lower boundary, which scatters too.
template <int channels>
float intercepted(const SliceOf<channels>& slice, int channel, float mu) noexcept {
    if (slice.is_one_sided()) return 1;
    const float depth = static_cast<float>(std::min(slice.medium().optical_depth[channel], 1e30));
    return attenuation(depth / std::max(mu, min_cosine)).extinguished;
}

/// The horizontal part of an incident direction, along x where it has none: what is added is large enough
/// for normal products with the sines of outgoing directions, and never cancels.
struct Horizontal {
    float x, y, square;

    explicit Horizontal(const Vector& w) noexcept
        : x(w.x + std::copysign(1e-9f, w.x)), y(w.y), square(x * x + y * y) {}
};

template <int channels>
SliceOf<channels> checked(SliceOf<channels> slice) {
    require(slice.has_all_directions(), "Bsdf", "table of the slice",
            "one of all directions, which are sampled and integrated over", "one narrowed to some");
    return slice;
}

}  // namespace

template <int channels>
BsdfOf<channels>::BsdfOf(SliceOf<channels> slice)
    : slice_(checked(std::move(slice))),
      density_(channels, [this](auto... arguments) { slice_.eval(arguments...); }) {
    if (density_.is_peaked())
        integrate_albedo<PeakedCoordinates, 40, 32>();
    else
        integrate_albedo<LobeCoordinates, 16, 16>();
}

template <int channels>
template <class Coordinates, int cosines, int azimuths>
void BsdfOf<channels>::integrate_albedo() {
    const Quadrature<cosines> over_cosines;
    const Quadrature<azimuths> over_azimuths;
    std::vector<float> value, weight;
    for (int row = 0; row < albedo_rows; ++row) {
        const Cosine in = cosine_at(as_float(row) / (albedo_rows - 1));
        for (const Side side : both_sides) {
            const Peaks& peaks = density_.peaks(side);
            DirectionPairs pairs;
            weight.clear();
            for (const bool to_horizon : {false, true})
                for (int i = 0; i < cosines; ++i) {
                    const OutgoingCosine out = Coordinates::outgoing_cosine(
                        SphereQuarter(side, to_horizon), peaks, in, over_cosines.x[i]);
                    const auto scale = Coordinates::azimuth_scale(side, peaks, in, out.cosine);
                    for (int k = 0; k < azimuths; ++k) {
                        const Azimuth azimuth = Coordinates::azimuth_at(scale, over_azimuths.x[k]);
                        weight.push_back(2 * over_cosines.weight[i] * over_azimuths.weight[k] *
                                         out.cosine.mu * out.stretch * azimuth.stretch);
                        pairs.add(side, in, out, azimuth);
                    }
                }
            value.resize(channels * weight.size());
            pairs.evaluate([this](auto... arguments) { slice_.eval(arguments...); }, value.data());
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
auto BsdfOf<channels>::eval(Side side, float mu_in, float mu_out, float azimuth) const noexcept
    -> Value {
    return slice_.scattering(side, mu_in, mu_out, azimuth) * one_over_pi;
}

template <int channels>
bool BsdfOf<channels>::is_lit(const Vector& wi) const noexcept {
    return (wi.z > 0) | ((wi.z < 0) & !slice_.is_one_sided());
}

template <int channels>
float BsdfOf<channels>::pdf(Side side, float mu_in, float mu_out, float azimuth) const noexcept {
    check_angles(mu_in, mu_out, azimuth);
    if (is_unknown(mu_in, mu_out, azimuth * 0)) return not_a_number;
    const Pair<float> halves = half_azimuth_squares(azimuth);
    return density_.pdf(side, inclination(mu_in), inclination(mu_out),
                        {square_root(halves.second()), square_root(halves.first()), 1});
}

template <int channels>
float BsdfOf<channels>::pdf(const Vector& wi, const Vector& wo) const noexcept {
    check_vectors(wi, wo);
    const float sides = wi.z * wo.z;
    if (!is_lit(wi) || sides == 0) return zero_or_nan(wi.x, wi.y, wi.z, wo.x, wo.y, wo.z);
    const Horizontal in(wi);
    const float square = wo.x * wo.x + wo.y * wo.y;
    // Light travels along -wi: cos(azimuth) = -dot / m. Of
    //     tan(azimuth / 2) = |cross| / (m - dot) = (m + dot) / |cross|
    // the one without cancellation is used.
    const float dot = in.x * wo.x + in.y * wo.y, cross = std::abs(in.x * wo.y - in.y * wo.x);
    const float m = std::max(square_root(in.square * square), 1e-18f);
    const float both[2] = {cross, m + std::abs(dot)};
    const int backward = dot > 0 ? 1 : 0;
    return density_.pdf(static_cast<Side>(sides < 0 ? 1 : 0), {std::abs(wi.z), in.square},
                        {std::abs(wo.z), square},
                        {both[1 - backward], both[backward], 2 * m * both[1]}) +
           zero_or_nan(dot, sides);
}

template <int channels>
auto BsdfOf<channels>::sample(const Vector& wi, float u1, float u2, float u3) const noexcept
    -> Sample {
    check_vectors(wi, wi);
    check_random_numbers(u1, u2, u3);
    if (is_unknown(wi.x, wi.y, wi.z, u1, u2, u3))
        return {all_channels<Vector>(not_a_number), all_channels<Value>(not_a_number),
                not_a_number};
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
auto BsdfOf<channels>::sample(float mu_in, float u1, float u2, float u3) const noexcept
    -> SampleOfAngles {
    check_angles(mu_in, mu_in, 0);
    check_random_numbers(u1, u2, u3);
    if (is_unknown(mu_in, u1, u2, u3))
        return {Side::reflection, not_a_number, not_a_number, all_channels<Value>(not_a_number),
                not_a_number};
    const DirectionDensity::Direction out = density_.sample(inclination(mu_in), u1, u2, u3);
    const float azimuth = std::atan2(out.sin_azimuth, out.cos_azimuth);
    return {out.side, out.mu, azimuth, eval(out.side, mu_in, out.mu, azimuth), out.pdf};
}

template <int channels>
auto BsdfOf<channels>::albedo(float cosine) const noexcept -> ScatteredShares<Value> {
    const float mu_in = cosine_in_range("mu_in", cosine);
    const float place = to_cosine(inclination(mu_in)).v * (albedo_rows - 1);
    const int row = truncated(within(0, place, albedo_rows - 2));
    const float past = place - as_float(row);
    const float* const here = albedo_.data() + row * 2 * channels;
    float channel[2 * channels];
    for (int i = 0; i < 2 * channels; ++i)
        channel[i] = (here[i] + past * (here[i + 2 * channels] - here[i])) *
                         intercepted(slice_, i % channels, mu_in) +
                     zero_or_nan(mu_in);
    return {from_channels<Value>(channel), from_channels<Value>(channel + channels)};
}

template <int channels>
auto BsdfOf<channels>::albedo(const Vector& wi) const noexcept -> ScatteredShares<Value> {
    check_vectors(wi, wi);
    const float unknown = zero_or_nan(wi.x, wi.y, wi.z);
    return is_lit(wi)
               ? albedo(std::abs(wi.z) + unknown)
               : ScatteredShares<Value>{all_channels<Value>(unknown), all_channels<Value>(unknown)};
}

template <int channels>
std::size_t BsdfOf<channels>::bytes() const noexcept {
    return sizeof *this - sizeof slice_ - sizeof density_ + slice_.bytes() + density_.bytes() +
           albedo_.size() * sizeof(float);
}

template class BsdfOf<1>;
template class BsdfOf<3>;

}  // namespace stratus
