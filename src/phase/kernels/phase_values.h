// Values of a phase curve (phase_curve.h) at a light path.
#pragma once

#include <stratus/phase/phase_curve.h>

#include "base/interpolation.h"
#include "base/light_path.h"

namespace stratus {
namespace {

template <class F>
STRATUS_INLINE F lobe_value(const PhaseLobe& lobe, const LightPathOf<F>& path) {
    const F r = reciprocal_root(path.forward() * lobe.forward +
                                (path.backward() * lobe.backward + lobe.offset));
    return r * r * (r * lobe.scale);
}

template <class F>
STRATUS_INLINE F sum_of_lobes(const PhaseLobe (&lobe)[2], const LightPathOf<F>& path) {
    if constexpr (std::is_same_v<F, float>) {
        const auto of_both = [&](float PhaseLobe::*number) {
            return Pair<F>(lobe[0].*number, lobe[1].*number);
        };
        const Pair<F> base =
            scaled(of_both(&PhaseLobe::forward), path.forward()) +
            (scaled(of_both(&PhaseLobe::backward), path.backward()) + of_both(&PhaseLobe::offset));
        const Pair<F> r = each([](auto x) { return reciprocal_root(x); }, base);
        return sum(r * r * (r * of_both(&PhaseLobe::scale)));
    } else {
        return lobe_value(lobe[0], path) + lobe_value(lobe[1], path);
    }
}

/// Two neighbouring samples (lanes.h) of those that all channels share.
template <int stride, class F, class Index>
STRATUS_INLINE Neighbours<F> shared_neighbours(const float* samples, Index index) {
    if constexpr (std::is_same_v<F, ChannelLanes>)
        return {F(samples[index.v[0]]), F(samples[index.v[0] + stride])};
    else
        return neighbours<stride, F>(samples, index);
}

/// The `width` values side by side at a scattering angle.
template <int width, class F>
STRATUS_INLINE void sampled_values(const PhaseCurveView& curve, const LightPathOf<F>& path,
                                   F* value) {
    const F x =
        (square_root(path.forward() * 0.5f) - square_root(path.backward() * 0.5f)) * 0.5f + 0.5f;
    // Stays below the last sample, so that there is a next one.
    const F place = clamped(x, 0.0f, 1 - 1e-6f) * static_cast<float>(curve.last);
    const auto index = truncated(place);
    const F fraction = place - as_float(index);
    for (int k = 0; k < width; ++k) {
        const Neighbours<F> at = shared_neighbours<width, F>(curve.sample + k, index * width);
        value[k] = at.here + fraction * (at.next - at.here);
    }
}

template <PhaseForm form, class F>
STRATUS_INLINE F phase_value(const PhaseCurveView& curve, const LightPathOf<F>& path) {
    if constexpr (form == PhaseForm::sampled) {
        F value[1];
        sampled_values<1>(curve, path, value);
        return value[0];
    } else if constexpr (form == PhaseForm::constant) {
        return F(curve.polynomial[0]);
    } else {
        F value = path.forward() * (path.forward() * curve.polynomial[2] + curve.polynomial[1]) +
                  curve.polynomial[0];
        if constexpr (form == PhaseForm::one_lobe) value = value + lobe_value(curve.lobe[0], path);
        if constexpr (form == PhaseForm::two_lobes) value = value + sum_of_lobes(curve.lobe, path);
        return value;
    }
}

/// All that single scattering on the lit side reads of a curve.
template <class F>
struct PhaseValues {
    F layer;     // phase function
    F boundary;  // of a layer that is the lower boundary
};

/// Without lower boundary where the curve is not composed.
template <PhaseForm form, class F>
STRATUS_INLINE PhaseValues<F> phase_values(const PhaseCurveView& curve,
                                           const LightPathOf<F>& path) {
    if constexpr (form == PhaseForm::with_boundary ||
                  form == PhaseForm::with_opposition_and_boundary) {
        F value[2];
        sampled_values<2>(curve, path, value);
        return {value[0], value[1]};
    } else if constexpr (form == PhaseForm::none || form == PhaseForm::of_stack) {
        return {};
    } else {
        return {phase_value<form>(curve, path), F(0.0f)};
    }
}

}  // namespace
}  // namespace stratus
