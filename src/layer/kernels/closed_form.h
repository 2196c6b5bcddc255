// Closed forms of fast lookups: single scattering, then the opposition effect.
//
// Single scattering in closed form, [Blinn82] 2.4, and what orders n >= 2 were divided by: the shares of
// light intercepted along both directions, and the scales of diffusion.h. For one lookup, for many, and
// for packed tables.
//
// A depth or an albedo is a number of type N: F itself, or a float that all lanes share.
#pragma once

#include <stratus/layer/effects.h>

#include "base/interpolation.h"
#include "phase/kernels/phase_values.h"

namespace stratus {
namespace {

// ---- light reflected

/// The two directions.
template <class F>
struct ReflectedPath {
    Pair<F> mu, reciprocal_mu;
    F reciprocal_sum;  // 1 / (mu + mu0)

    STRATUS_INLINE explicit ReflectedPath(const LightPathOf<F>& path) : mu(path.mu) {
        if constexpr (std::is_same_v<F, float>) {  // one division serves all
            const QuantityLanes both = (mu + swapped(mu)).lanes();
            const QuantityLanes all = reciprocal(low_and_low(mu.lanes(), both));
            reciprocal_mu = Pair<F>(all);
            reciprocal_sum = all.v[2];
        } else {
            reciprocal_mu = each([](auto x) { return reciprocal(x); }, mu);
            reciprocal_sum = reciprocal(sum(mu));
        }
    }

    /// tau / mu0 and tau / mu.
    template <class N>
    STRATUS_INLINE Pair<F> depths(N optical_depth) const {
        return scaled(reciprocal_mu, optical_depth);
    }
    /// Their sum.
    template <class N>
    STRATUS_INLINE F depth_of_both(N optical_depth) const {
        return sum(reciprocal_mu) * optical_depth;
    }
};

/// Along both directions, one after the other.
template <class F>
struct BothWays {
    Attenuation<F> sum;
    F shares;  // product of the shares intercepted along each
};

template <class F>
STRATUS_INLINE BothWays<F> both_ways(const Attenuation<F>& in, const Attenuation<F>& out) {
    const F shares = in.extinguished * out.extinguished;
    return {{in.transmitted * out.transmitted, in.extinguished + out.extinguished - shares},
            shares};
}
template <class F>
STRATUS_INLINE BothWays<F> both_ways(const Attenuations<F>& at) {
    return both_ways<F>({at.transmitted.first(), at.extinguished.first()},
                        {at.transmitted.second(), at.extinguished.second()});
}

/// Lower boundary: R of a Lambert surface, w / 4 of a layer.
template <class N>
struct BoundaryAlbedos {
    N surface, quarter;
};

/// R of order 1 of the layer and of its lower boundary, seen through it.
template <PhaseForm form, class F, class N, class B>
STRATUS_INLINE F single_reflected(const ReflectedPath<F>& path, const PhaseValues<F>& phase,
                                  const Attenuation<F>& both, N quarter_albedo,
                                  const BoundaryAlbedos<B>& boundary) {
    const F single = phase.layer * both.extinguished * path.reciprocal_sum * quarter_albedo +
                     both.transmitted * boundary.surface;
    if constexpr (form == PhaseForm::with_boundary ||
                  form == PhaseForm::with_opposition_and_boundary)
        return single +
               path.reciprocal_sum * (phase.boundary * both.transmitted * boundary.quarter);
    else
        return single;
}

/// R of order 1 of the layers of a stack, each seen through those above it.
template <class F, class Layer>
STRATUS_INLINE F single_reflected_by(const Layer* layer, int layers, const LightPathOf<F>& path,
                                     const ReflectedPath<F>& directions) {
    F sum(0.0f);
    for (const Layer* at = layer; at != layer + layers; ++at) {
        Attenuation<F> of[2];
        attenuate(
            {directions.depth_of_both(at->above), directions.depth_of_both(at->optical_depth)}, of);
        const F phase = phase_value<PhaseForm::sampled>(at->phase, path);
        sum = sum + phase * of[0].transmitted * (of[1].extinguished * at->quarter_albedo);
    }
    return sum * directions.reciprocal_sum;
}

// ---- light transmitted

/// 1 / cosine of the two directions.
template <class F>
struct TransmittedPath {
    F steep, shallow;  // of the larger cosine, of the smaller

    STRATUS_INLINE explicit TransmittedPath(const LightPathOf<F>& path) {
        const Pair<F> of_mu = each([](auto x) { return reciprocal(x); }, path.mu);
        steep = minimum(of_mu.first(), of_mu.second());
        shallow = maximum(of_mu.second(), of_mu.first());  // not-a-number stays in one of both
    }

    /// tau / mu along the steeper direction.
    template <class N>
    STRATUS_INLINE F depth(N optical_depth) const {
        return steep * optical_depth;
    }
    /// By how much tau / mu is larger along the other. Never 0, for it is divided by; its square
    /// does not underflow, for that takes processors fifty cycles.
    template <class N>
    STRATUS_INLINE F excess(N optical_depth) const {
        return at_least(1e-18f, (shallow - steep) * optical_depth);
    }
};

/// Diffuse T of order 1, from the attenuations at `depth` and at `excess`. Written with the mean of
/// exp(-x) over [0, excess], which is regular at equal cosines.
template <class F, class N>
STRATUS_INLINE F single_transmitted(const TransmittedPath<F>& path, F phase, F depth, F excess,
                                    const Attenuation<F>& beam, const Attenuation<F>& more,
                                    N quarter_albedo) {
    return phase * beam.transmitted * depth * path.shallow *
           (more.extinguished * reciprocal(excess)) * quarter_albedo;
}

/// Diffuse T of order 1 of the layers of a stack, each behind those above and before those below it.
template <class F, class Layer>
STRATUS_INLINE F single_transmitted_by(const Layer* layer, int layers, const LightPathOf<F>& path,
                                       const TransmittedPath<F>& directions) {
    const F in = reciprocal(path.mu_in()), out = reciprocal(path.mu_out());
    F sum(0.0f);
    for (const Layer* at = layer; at != layer + layers; ++at) {
        const F depth = directions.depth(at->optical_depth),
                excess = directions.excess(at->optical_depth);
        Attenuation<F> of[3];
        attenuate({depth, excess, in * at->above + out * at->below}, of);
        const F phase = phase_value<PhaseForm::sampled>(at->phase, path);
        sum = sum + of[2].transmitted * single_transmitted(directions, phase, depth, excess, of[0],
                                                           of[1], at->quarter_albedo);
    }
    return sum;
}

/// Product of the shares intercepted along either direction, from the same attenuations.
template <class F>
STRATUS_INLINE F transmitted_shares(const Attenuation<F>& beam, const Attenuation<F>& more) {
    return beam.extinguished * (beam.extinguished + beam.transmitted * more.extinguished);
}

// ---- light deep in the layer: k is the diffusion exponent, q the extrapolation length. From attenuations,
// each is a ratio of numbers that keep their relative accuracy.

/// The reflection that is missing towards infinite depth: remaining / whole.
template <class F>
struct ReflectionDeficit {
    F remaining, whole;

    /// From attenuations at 2 k q and at 2 k tau; `whole` is 1 - exp(-2 k (tau + q)).
    STRATUS_INLINE ReflectionDeficit(const Attenuation<F>& length, const Attenuation<F>& depth)
        : remaining(depth.transmitted * length.extinguished),
          whole(length.extinguished + depth.extinguished -
                length.extinguished * depth.extinguished) {}

    STRATUS_INLINE F deficit() const { return remaining * reciprocal(whole); }

    /// 1 / (1 + d + d^2) for the deficit d.
    STRATUS_INLINE F scale() const {
        const F d = deficit();
        return reciprocal(d * (d + 1.0f) + 1.0f);
    }
};

/// sinh(k q) / sinh(k (tau + q)), from attenuations at 2 k q and at k tau.
template <class F>
STRATUS_INLINE F transmission_fall(const Attenuation<F>& length, const Attenuation<F>& depth) {
    const F twice = depth.extinguished * (depth.transmitted + 1.0f);  // extinguished at 2 k tau
    return depth.transmitted * length.extinguished *
           reciprocal(length.extinguished + twice - length.extinguished * twice);
}

}  // namespace

// Blinn's opposition (effects.h) from its table, for one lookup and for many.
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
