// Blinn's opposition (opposition.h) from its table, for one lookup and for many.
//
// With T = tanh(v / 2), v = tau (1/mu0 + 1/mu) / 2, and eta = 4 mu mu0 / (mu + mu0)^2 the factor is
// 1 + P S: P has its limits, at a = 0 and pi, at all depths and at grazing light, and S, near 1, is
// sampled.
//
//     P = 1 / ((1 + (1 - eta) T) / (eta T) + 1 / g) * eta T / (eta T + 1.4 b2),
//     g = (4 / (3 pi)) R cot(a/2).
//
// Samples lie evenly over 1 - cos(a/2) and s / (s + h) + s / (s + 8 h), s = sin(a/2), added in the
// shares below; over sqrt(tanh(v / 4)); and over sqrt(eta).
#pragma once

#include <stratus/layer/opposition.h>

#include "base/interpolation.h"
#include "closed_form.h"

namespace stratus {
namespace {

constexpr float narrow_angle_share = 0.4f, wide_angle_share = 0.2f;
constexpr float overlap_scale = 0.42441318f;  // 4 / (3 pi)
constexpr float near_scale = 1.4f;

/// The phase angle of a lookup.
template <class F>
struct PhaseAngle {
    F sine, cosine;  // of a/2

    STRATUS_INLINE explicit PhaseAngle(const LightPathOf<F>& path)
        : sine(square_root(path.backward() * 0.5f)), cosine(square_root(path.forward() * 0.5f)) {}
    STRATUS_INLINE PhaseAngle(F sine_of_half, F cosine_of_half)
        : sine(sine_of_half), cosine(cosine_of_half) {}
};

/// Where samples of an angle lie, [0, 1].
template <class F>
STRATUS_INLINE F angle_place(const OppositionTableView& table, const PhaseAngle<F>& angle) {
    const float h = table.angle_scale;
    const F near = angle.sine + h, far = angle.sine + 8 * h;
    return angle.sine * (near + far) * reciprocal(near * far) * narrow_angle_share +
           (1.0f - angle.cosine) * wide_angle_share;
}

/// tanh(v / 2) and tanh(v / 4) of the attenuation at v / 2.
template <class F>
struct DepthTangents {
    F half, quarter;

    STRATUS_INLINE explicit DepthTangents(const Attenuation<F>& at) {
        const F a = at.transmitted + 1.0f, b = a * a + at.extinguished * at.extinguished;
        const F scaled = at.extinguished * reciprocal(a * b);
        quarter = scaled * b;
        half = scaled * (a * a) * 2.0f;
    }
};

/// P.
template <class F>
STRATUS_INLINE F opposition_limits(const OppositionTableView& table, const PhaseAngle<F>& angle,
                                   F eta, F tangent) {
    const F both = eta * tangent, deep = angle.cosine * (overlap_scale * table.radius);
    constexpr float tiny = 1e-18f;  // nothing is 0 / 0 without depth, at a = 0 and pi
    const F first = deep * ((1.0f - eta) * tangent + 1.0f) + (both * angle.sine + tiny);
    const F near = both * angle.cosine;
    const F second = near + (angle.sine * (near_scale * table.radius) + tiny);
    return both * deep * near * reciprocal(first * second);
}

/// samples[index], each channel its own.
template <class F, class Index>
STRATUS_INLINE F opposition_sample(const float* samples, Index index) {
    if constexpr (std::is_same_v<F, ChannelLanes>) {
        F value;
        for (int k = 0; k < 4; ++k) value.v[k] = samples[index.v[k]];
        return value;
    } else {
        return sample_at<F>(samples, index);
    }
}

/// The factor less 1. `at` is the attenuation at v / 2.
template <class F>
STRATUS_INLINE F opposition_bump(const OppositionTableView& table, const PhaseAngle<F>& angle,
                                 F eta, const Attenuation<F>& at) {
    using View = OppositionTableView;
    const DepthTangents<F> tangent(at);
    const auto place = [](F x, int samples) {  // stays below the last, so that there is a next one
        return axis_place(clamped(x, 0.0f, 1 - 1e-6f) * static_cast<float>(samples - 1));
    };
    const auto in_angle = place(angle_place(table, angle), View::angles);
    const auto in_depth = place(square_root(tangent.quarter), View::depths);
    const auto in_eta = place(square_root(eta), View::etas);
    const auto first =
        (in_angle.sample * View::depths + in_depth.sample) * View::etas + in_eta.sample;
    const auto line = [&](int offset) {
        const F here = opposition_sample<F>(table.sample + offset, first);
        const F next = opposition_sample<F>(table.sample + offset + 1, first);
        return here + in_eta.fraction * (next - here);
    };
    const auto sheet = [&](int offset) {
        const F here = line(offset), next = line(offset + View::etas);
        return here + in_depth.fraction * (next - here);
    };
    const F here = sheet(0), next = sheet(View::depths * View::etas);
    return opposition_limits(table, angle, eta, tangent.half) *
           (here + in_angle.fraction * (next - here));
}

/// 4 mu mu0 / (mu + mu0)^2.
template <class F>
STRATUS_INLINE F path_eta(const ReflectedPath<F>& path) {
    return product(path.mu) * (path.reciprocal_sum * path.reciprocal_sum) * 4.0f;
}

}  // namespace
}  // namespace stratus
