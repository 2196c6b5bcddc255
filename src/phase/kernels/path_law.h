// The path law (path_law.h) of a bound layer at a light path.
#pragma once

#include <stratus/phase/path_law.h>

#include "base/interpolation.h"
#include "base/light_path.h"

namespace stratus {
namespace {

/// The angle of a light path among a sheet's.
template <class F, class Index>
struct PathAngle {
    Index sample;
    F fraction, scale;  // samples are to be multiplied by `scale`
};

template <class F>
STRATUS_INLINE auto path_angle(const PathSheetView& sheet, const LightPathOf<F>& path) {
    // Not-a-number becomes an end, never an index.
    const F x = clamped(minimum(path.forward(), path.backward()), 0.0f, 1.0f) + sheet.offset;
    const auto place = octave_place<PathOrders::angle_bits>(x);
    const auto sample = place.sample + where_less(path.backward(), path.forward(), sheet.angles) +
                        -sheet.first_angle;
    return PathAngle<F, std::remove_const_t<decltype(sample)>>{sample, place.fraction,
                                                               reciprocal(x)};
}

/// H, less its limit, between two neighbouring depths of a sheet, but for the angle's scale.
template <class F>
struct PathPiece {
    F here, next;   // H at the upper depth, at both angles around that of the light path
    F rest, slope;  // what H gains from there on, and dH/ds
};

/// later - earlier at the light path's angle: samples are subtracted from one another before anything
/// else is rounded.
template <class F>
STRATUS_INLINE F interpolated_rise(F fraction, F earlier, F earlier_next, F later, F later_next) {
    const F rise = later - earlier;
    return rise + fraction * ((later_next - earlier_next) - rise);
}

/// Interpolates the channel whose samples begin at `first`.
template <class F, class Index, class First>
STRATUS_INLINE PathPiece<F> path_piece(const PathSheetView& sheet, First first,
                                       const PathAngle<F, Index>& angle, F depth) {
    static_assert(PathSheet::depth_offset == 2);
    const auto place = octave_place<PathSheet::depth_bits>(
        minimum(depth + PathSheet::depth_offset, sheet.last_depth));
    constexpr int first_depth = (bits_of_1 + (1 << 23)) >> (23 - PathSheet::depth_bits);
    const int row = 4 * sheet.angles;
    const auto at = (place.sample + -first_depth) * row + angle.sample * 2 + first;
    const auto sample = [&](int from) { return neighbours<1, F>(sheet.sample + from, at); };
    const Neighbours<F> upper = sample(0), upper_next = sample(2), lower = sample(row),
                        lower_next = sample(row + 2);
    constexpr float cells = 1 << PathSheet::depth_bits;
    const F width = place.octave * (1 / cells), t = place.fraction;
    const F rise =
        interpolated_rise(angle.fraction, upper.here, upper_next.here, lower.here, lower_next.here);
    const auto end_slope = [&](const Neighbours<F>& here, const Neighbours<F>& next) {
        return (here.next + angle.fraction * (next.next - here.next)) * width;
    };
    const F start = end_slope(upper, upper_next), end = end_slope(lower, lower_next);
    const F b = rise * 3.0f - start * 2.0f - end, c = start + end - rise * 2.0f;
    return {upper.here, upper_next.here, t * (start + t * (b + t * c)),
            (start + t * (b * 2.0f + t * c * 3.0f)) * (place.octave_inverse * cells)};
}

/// R of the path law, orders n >= 2, at the slant depth of both ways.
template <class F, class Index, class First>
STRATUS_INLINE F path_reflected(const PathSheetView& sheet, First first,
                                const PathAngle<F, Index>& angle, F depth_of_both,
                                F reciprocal_sum) {
    const PathPiece<F> at = path_piece(sheet, first, angle, depth_of_both);
    const auto surface = [&](int from) {  // where H is 0
        return neighbours<1, F>(sheet.sample + from, angle.sample * 2 + first).here;
    };
    const F value =
        interpolated_rise(angle.fraction, surface(0), surface(2), at.here, at.next) + at.rest;
    return value * angle.scale * 0.25f * reciprocal_sum;
}

/// T likewise, between the slant depths `depth` and `depth` + `excess`: the mean slope of H between
/// them, which is that in the middle where they are close; 0 beyond the last depth.
template <class F, class Index, class First>
STRATUS_INLINE F path_transmitted(const PathSheetView& sheet, First first,
                                  const PathAngle<F, Index>& angle, F depth, F excess, F shallow) {
    constexpr float close = 0.01f;
    const F few = (depth + 1.0f) * close;
    const PathPiece<F> low =
        path_piece(sheet, first, angle, choose_less(excess, few, depth + excess * 0.5f, depth));
    const PathPiece<F> high = path_piece(sheet, first, angle, depth + excess);
    const F rise = interpolated_rise(angle.fraction, low.here, low.next, high.here, high.next) +
                   (high.rest - low.rest);
    const F mean = choose_less(excess, few, low.slope, rise * reciprocal(excess));
    return choose_less(depth + PathSheet::depth_offset, F(sheet.last_depth), mean, F(0.0f)) *
           angle.scale * depth * shallow * 0.25f;
}

}  // namespace
}  // namespace stratus
