#include "kernels.h"

#include "base/interpolation.h"
#include "layer/kernels/closed_form.h"
#include "phase/kernels/path_law.h"

#include <utility>

namespace stratus::STRATUS_ISA {
namespace {

/// Returns the path that all channels share.
STRATUS_INLINE LightPath path_of_first(const LightPathOf<ChannelLanes>& path) {
    return {{path.mu_in().v[0], path.mu_out().v[0]},
            {path.forward().v[0], path.backward().v[0]},
            path.half_azimuth.v[0],
            path.unknown.v[0]};
}

// ---- orders n >= 2

/// Among the samples of a slice (kernels.h): the one before a place, and the share of the way to
/// the next.
template <class F, class Index>
struct SlicePlace {
    AxisPlace<F, Index> mu, other, azimuth;
};

template <class F>
STRATUS_INLINE F place_along(const SlicePlaces& places, int axis, F coordinate) {
    return clamped(coordinate * places.scale[axis] + places.offset[axis], 0.0f, places.last[axis]);
}

template <bool azimuthal, int channels, class F>
STRATUS_INLINE auto slice_place(const SliceSide<channels>& side, const LightPathOf<F>& path) {
    Pair<F> cosines(place_along(side.places, 0, mu_coordinate(path.mu_in())),
                    place_along(side.places, 1, mu_coordinate(path.mu_out())));
    if (side.symmetric) cosines = higher_first(cosines);
    const auto mu = axis_place(cosines.first()), other = axis_place(cosines.second()),
               azimuth = axis_place(place_along(side.places, 2, square_root(path.half_azimuth)));
    return SlicePlace<F, decltype(mu.sample + 0)>{mu, other, azimuth};
}

/// All three at once.
template <bool azimuthal, int channels>
STRATUS_INLINE auto slice_place(const SliceSide<channels>& side, const LightPath& path) {
    QuantityLanes mu = path.mu.lanes();
    if (side.symmetric) mu = lower_first(path.mu).lanes();
    const QuantityLanes scale = load<QuantityLanes>(side.places.scale),
                        offset = load<QuantityLanes>(side.places.offset),
                        last = load<QuantityLanes>(side.places.last);
    // Coordinates as in mu_coordinate, the azimuth third.
    const QuantityLanes rest = 1.0f - mu, roots = square_root(low_and_low(mu, rest));
    const QuantityLanes of_mu = 1.0f - square_root(roots) * 0.5f;
    const float of_azimuth = azimuthal ? square_root(path.half_azimuth) : 0;
    const QuantityLanes place = quantities(roots.v[2], roots.v[3], 1, 1) * scale *
                                    quantities(of_mu.v[0], of_mu.v[1], of_azimuth, 0) +
                                offset;
    // The samples are there sooner than a place within the last.
    const auto sample = clamped(truncated(place), 0, truncated(last));
    const QuantityLanes fraction = clamped(place, 0.0f, last) - as_float(sample);
    return SlicePlace<float, std::int32_t>{
        {sample.v[0], fraction.v[0]}, {sample.v[1], fraction.v[1]}, {sample.v[2], fraction.v[2]}};
}

/// All channels share a place.
template <bool azimuthal, int channels>
STRATUS_INLINE auto slice_place(const SliceSide<channels>& side,
                                const LightPathOf<ChannelLanes>& path) {
    const auto at = slice_place<azimuthal>(side, path_of_first(path));
    using F = ChannelLanes;
    return SlicePlace<F, std::int32_t>{{at.mu.sample, F(at.mu.fraction)},
                                       {at.other.sample, F(at.other.fraction)},
                                       {at.azimuth.sample, F(at.azimuth.fraction)}};
}

/// Reads stored samples: straight lines along both cosines, or cubics, and cubics along azimuth.
template <Orders orders, int channels, class F>
STRATUS_INLINE void interpolate(const SliceSide<channels>& side, const LightPathOf<F>& path,
                                F* value) {
    constexpr bool azimuthal = orders != Orders::without_azimuth;
    const auto [mu, other, azimuth] = slice_place<azimuthal>(side, path);
    const int azimuths = azimuthal ? side.azimuths : 1;
    const int column = azimuths * channels;
    auto row = mu.sample * (side.columns * column) + other.sample * column;
    if (__builtin_expect(side.cubic, false))
        return between_cubics<channels, azimuthal>(
            side.sample, side.columns * column, column,
            azimuthal ? row + azimuth.sample * channels : row, mu.fraction, other.fraction,
            azimuth.fraction, value);
    auto next = row + side.columns * column;
    if (side.symmetric) {
        row = (halved(mu.sample * (mu.sample + 3)) + other.sample) * column;
        next = row + (mu.sample + 2) * column;
    }
    if constexpr (azimuthal)
        return between_samples<channels>(side.sample, column, row + azimuth.sample * channels,
                                         next + azimuth.sample * channels, mu.fraction,
                                         other.fraction, azimuth.fraction, value);
    for (int c = 0; c < channel_steps<channels, F>; ++c) {
        const float* const sample = side.sample + c;
        const F a = sample_at<F>(sample, row), b = sample_at<F>(sample + column, row);
        const F d = sample_at<F>(sample, next), e = sample_at<F>(sample + column, next);
        const F near = a + other.fraction * (b - a), far = d + other.fraction * (e - d);
        value[c] = near + mu.fraction * (far - near);
    }
}

// ---- one side of a layer

/// The path law of a channel, or of all: of(channel, angle, lane) with lane(x) the x of the channel.
template <class F, class Of>
STRATUS_INLINE F path_of_channel(const PathSheetView& sheet, const LightPathOf<F>& path,
                                 int channel, const Of& of) {
    if constexpr (std::is_same_v<F, ChannelLanes>) {  // each has a sheet and depths of its own
        const auto angle = path_angle(sheet, path_of_first(path));
        F value(0.0f);
        for (int k = 0; k < 3; ++k) value.v[k] = of(k, angle, [k](const F& x) { return x.v[k]; });
        return value;
    } else {
        return of(channel, path_angle(sheet, path), [](const F& x) { return x; });
    }
}

/// The optical depth of a channel, or not-a-number where the azimuth is and the phase function does
/// not depend on it as a polynomial does.
template <PhaseForm form, int channels, class F>
STRATUS_INLINE auto depth_of_channel(const SliceSide<channels>& side, const LightPathOf<F>& path,
                                     int channel) {
    const auto depth = channel_value<F>(side.optical_depth, channel);
    if constexpr (form == PhaseForm::polynomial || form == PhaseForm::one_lobe ||
                  form == PhaseForm::two_lobes)
        return depth;
    else
        return path.unknown + depth;
}

/// Light of all orders: neither that of n >= 2 nor the sum is below `least`. Of a constant phase function
/// neither is negative.
template <PhaseForm form, Orders orders, int channels, class F>
STRATUS_INLINE F all_orders(const SliceSide<channels>& side, const F& single, const F& multiple) {
    if constexpr (form == PhaseForm::constant)
        return single + multiple;
    else if constexpr (orders == Orders::none)
        return at_least(side.least, single);
    else
        return at_least(side.least, single + at_least(side.least, multiple));
}

/// R of the layer, per channel.
template <PhaseForm form, Orders orders, int channels, class F>
STRATUS_INLINE void reflected(const SliceSide<channels>& side, const LightPathOf<F>& path,
                              F* value) {
    const ReflectedPath<F> directions(path);
    const PhaseValues<F> phase = phase_values<form>(side.phase, path);
    if constexpr (orders != Orders::none) interpolate<orders>(side, path, value);
    [[maybe_unused]] const PhaseAngle<F> angle(path);
    [[maybe_unused]] const F eta = path_eta(directions);
    for (int c = 0; c < channel_steps<channels, F>; ++c) {
        const auto depth = depth_of_channel<form>(side, path, c);
        constexpr bool opposed = form == PhaseForm::with_opposition_and_boundary;
        BothWays<F> both;
        [[maybe_unused]] Attenuation<F> quarter;  // at a quarter of the depth along both
        if constexpr (orders == Orders::none) {
            const F along_both = directions.depth_of_both(depth);
            if constexpr (opposed) {
                Attenuation<F> of[2];
                attenuate({along_both, along_both * 0.25f}, of);
                both.sum = of[0];
                quarter = of[1];
            } else {
                both.sum = attenuation(along_both);
            }
        } else {
            const Pair<F> depths = directions.depths(depth);
            if constexpr (opposed) {
                Attenuation<F> of[3];
                attenuate({depths.first(), depths.second(), sum(depths) * 0.25f}, of);
                both = both_ways(of[0], of[1]);
                quarter = of[2];
            } else {
                both = both_ways(attenuations(depths));
            }
        }
        F single(0.0f);
        if constexpr (form == PhaseForm::of_stack) {
            single = single_reflected_by(side.layer, side.layers, path, directions) +
                     both.sum.transmitted * channel_value<F>(side.surface_albedo, c);
        } else if constexpr (form != PhaseForm::none) {
            const auto surface_albedo = channel_value<F>(side.surface_albedo, c);
            const BoundaryAlbedos<decltype(surface_albedo + 0.0f)> boundary{
                surface_albedo, channel_value<F>(side.boundary_quarter_albedo, c)};
            PhaseValues<F> seen = phase;
            if constexpr (opposed)
                seen.layer =
                    seen.layer + seen.layer * opposition_bump(side.opposition, angle, eta, quarter);
            single = single_reflected<form>(directions, seen, both.sum,
                                            channel_value<F>(side.quarter_albedo, c), boundary);
        }
        F multiple(0.0f);
        if constexpr (orders != Orders::none)
            multiple = value[c] * (both.shares * side.slope + side.level);
        if constexpr (orders == Orders::with_azimuth_and_path) {
            const F s = directions.depth_of_both(depth);
            multiple =
                multiple + path_of_channel(
                               side.path, path, c, [&](int k, const auto& angle, const auto& lane) {
                                   return path_reflected(side.path, k * side.path.channel, angle,
                                                         lane(s), lane(directions.reciprocal_sum));
                               });
        }
        value[c] = all_orders<form, orders>(side, single, multiple);
    }
}

/// Diffuse T of the layer, per channel.
template <PhaseForm form, Orders orders, int channels, class F>
STRATUS_INLINE void transmitted(const SliceSide<channels>& side, const LightPathOf<F>& path,
                                F* value) {
    const TransmittedPath<F> directions(path);
    F phase;
    if constexpr (form != PhaseForm::none && form != PhaseForm::of_stack)
        phase = phase_value<form>(side.phase, path);
    if constexpr (orders != Orders::none) interpolate<orders>(side, path, value);
    for (int c = 0; c < channel_steps<channels, F>; ++c) {
        const auto optical_depth = depth_of_channel<form>(side, path, c);
        const F depth = directions.depth(optical_depth), excess = directions.excess(optical_depth);
        Attenuation<F> of[2];
        attenuate({depth, excess}, of);
        const auto& [beam, more] = of;
        F single(0.0f);
        if constexpr (form == PhaseForm::of_stack)
            single =
                path.unknown + single_transmitted_by(side.layer, side.layers, path, directions);
        else if constexpr (form != PhaseForm::none)
            single = single_transmitted(directions, phase, depth, excess, beam, more,
                                        channel_value<F>(side.quarter_albedo, c));
        F multiple(0.0f);
        if constexpr (orders != Orders::none)
            multiple = value[c] * (transmitted_shares(beam, more) * side.slope + side.level);
        if constexpr (orders == Orders::with_azimuth_and_path)
            multiple =
                multiple + path_of_channel(
                               side.path, path, c, [&](int k, const auto& angle, const auto& lane) {
                                   return path_transmitted(side.path, k * side.path.channel, angle,
                                                           lane(depth), lane(excess),
                                                           lane(directions.shallow));
                               });
        value[c] = all_orders<form, orders>(side, single, multiple);
    }
}

template <Side side, PhaseForm form, Orders orders, int channels, class F>
STRATUS_INLINE void evaluate(const SliceSide<channels>& view, const LightPathOf<F>& path,
                             F* value) {
    if constexpr (side == Side::reflection)
        reflected<form, orders>(view, path, value);
    else
        transmitted<form, orders>(view, path, value);
}

/// At one light path: plain floats, or all channels at once.
template <Side side, PhaseForm form, Orders orders, int channels>
STRATUS_INLINE ChannelValues<channels> evaluate_one(const SliceSide<channels>& view,
                                                    const LightPath& path) {
    ChannelValues<channels> value;
    if constexpr (channels == 1) {
        evaluate<side, form, orders>(view, path, value.of);
    } else {
        ChannelLanes here;
        using F = ChannelLanes;
        evaluate<side, form, orders>(view,
                                     LightPathOf<F>{{F(path.mu_in()), F(path.mu_out())},
                                                    {F(path.forward()), F(path.backward())},
                                                    F(path.half_azimuth),
                                                    F(path.unknown)},
                                     &here);
        for (int c = 0; c < channels; ++c) value.of[c] = here.v[c];
    }
    return value;
}

template <Side side, PhaseForm form, Orders orders, int channels>
ChannelValues<channels> at_angles(const SliceSide<channels>& view, float mu_in, float mu_out,
                                  float azimuth) {
    return evaluate_one<side, form, orders>(view, light_path<side>(mu_in, mu_out, azimuth));
}

template <Side side, PhaseForm form, Orders orders, int channels>
ChannelValues<channels> at_vectors(const SliceSide<channels>& view, const Vector& wi,
                                   const Vector& wo) {
    return evaluate_one<side, form, orders>(view, light_path(wi.x, wi.y, wi.z, wo.x, wo.y, wo.z));
}

/// Calls put(number, where the first of all paths is) for each number of a path.
template <class Put>
STRATUS_INLINE void for_numbers(const LightPathOf<LookupLanes>& path, LightPaths& paths,
                                const Put& put) {
    const LookupLanes number[path_numbers] = {path.mu_in(), path.mu_out(), path.forward(),
                                              path.backward(), path.half_azimuth};
#pragma GCC unroll 5
    for (int k = 0; k < path_numbers; ++k) put(number[k], paths.number[k]);
}

template <Side side, PhaseForm form, Orders orders, int channels>
void evaluate_many(const SliceSide<channels>& view, const LightPaths& paths, int count,
                   float* value) {
    static_assert(most_lanes % lane_width == 0);
    for (int i = 0; i < count; i += lane_width) {
        const auto number = [&](int k) { return load<LookupLanes>(paths.number[k] + i); };
        const LookupLanes half_azimuth = number(4);
        const LightPathOf<LookupLanes> path{
            {number(0), number(1)}, {number(2), number(3)}, half_azimuth, half_azimuth * 0.0f};
        LookupLanes here[channels];
        evaluate<side, form, orders>(view, path, here);
        for (int c = 0; c < channels; ++c) store(here[c], value + c * path_room + i);
    }
}

template <Side side, PhaseForm form, Orders orders, int channels>
constexpr SideKernel<channels> kernel() {
    constexpr bool impossible =
        side == Side::transmission &&
        (form == PhaseForm::with_boundary || form == PhaseForm::with_opposition_and_boundary);
    if constexpr (impossible || !has_kernel(form, orders))
        return {};
    else
        return {at_angles<side, form, orders, channels>, at_vectors<side, form, orders, channels>,
                evaluate_many<side, form, orders, channels>};
}

template <Side side, int channels, int... place>
constexpr SideKernels<channels> all_kernels(std::integer_sequence<int, place...>) {
    return {{kernel<side, static_cast<PhaseForm>(place / order_forms),
                    static_cast<Orders>(place % order_forms), channels>()...}};
}

template <Side side>
void paths_of_angles(const float* mu_in, const float* mu_out, const float* azimuth, int count,
                     LightPaths& paths) {
    for (int i = 0; i < count; i += lane_width)
        for_numbers(light_path<side>(load<LookupLanes>(mu_in + i), load<LookupLanes>(mu_out + i),
                                     load<LookupLanes>(azimuth + i)),
                    paths, [i](LookupLanes number, float* all) { store(number, all + i); });
}

/// Appends the paths of some lanes.
STRATUS_INLINE void append(const LightPathOf<LookupLanes>& path, unsigned lanes, LightPaths& paths,
                           int& count) {
    for_numbers(path, paths, [&](LookupLanes number, float* all) {
        compress_store(number, lanes, all + count);
    });
    count += __builtin_popcount(lanes);
}

/// Fills the last register with the first path.
void fill_last(LightPaths& paths, int count) {
    if (count == 0) return;
    for (auto& all : paths.number) store(LookupLanes(all[0]), all + count);
}

void paths_of_vectors(const float* const wi[3], const float* const wo[3], int count, bool one_sided,
                      PartedPaths& parted) {
    parted.count[0] = parted.count[1] = 0;
    const LookupLanes none(0.0f), seen(static_cast<float>(1 / pi));
    for (int i = 0; i < count; i += lane_width) {
        const auto in = load<LookupLanes>(wi[2] + i), out = load<LookupLanes>(wo[2] + i);
        const auto path =
            light_path(load<LookupLanes>(wi[0] + i), load<LookupLanes>(wi[1] + i), in,
                       load<LookupLanes>(wo[0] + i), load<LookupLanes>(wo[1] + i), out);
        const LookupLanes sides = in * out;
        const unsigned all = (1u << (count - i < lane_width ? count - i : lane_width)) - 1;
        const unsigned reflected = lanes_less(none, sides) & all;
        append(path, reflected, parted.paths[0], parted.count[0]);
        append(path, all & ~reflected, parted.paths[1], parted.count[1]);
        parted.reflected[i / lane_width] = reflected;
        const LookupLanes factor(sides.v == none.v ? none.v : seen.v);
        const LookupLanes unknown = path.unknown + sides * 0.0f;
        store((one_sided ? choose_less(none, in, factor, none) : factor) + unknown,
              parted.factor + i);
    }
    for (const int side : {0, 1}) fill_last(parted.paths[side], parted.count[side]);
}

void joined(const PartedPaths& parted, const float* reflected, const float* transmitted, int count,
            float* value) {
    for (int i = 0; i < count; i += lane_width) {
        const unsigned lanes = parted.reflected[i / lane_width];
        const LookupLanes all = (expand_load(reflected, lanes) + expand_load(transmitted, ~lanes)) *
                                load<LookupLanes>(parted.factor + i);
        reflected += __builtin_popcount(lanes);
        transmitted += lane_width - __builtin_popcount(lanes);
        if (count - i >= lane_width)
            store(all, value + i);
        else
            for (int k = 0; k < count - i; ++k) value[i + k] = all.v[k];
    }
}

}  // namespace
}  // namespace stratus::STRATUS_ISA

namespace stratus {

template <>
const Kernels& functions_for<Kernels, InstructionSet::STRATUS_ISA>() noexcept {
    using namespace STRATUS_ISA;
    constexpr std::make_integer_sequence<int, phase_forms * order_forms> places;
    static constexpr Kernels kernels{
        {all_kernels<Side::reflection, 1>(places), all_kernels<Side::transmission, 1>(places)},
        {all_kernels<Side::reflection, 3>(places), all_kernels<Side::transmission, 3>(places)},
        {paths_of_angles<Side::reflection>, paths_of_angles<Side::transmission>},
        paths_of_vectors,
        joined};
    return kernels;
}

}  // namespace stratus
