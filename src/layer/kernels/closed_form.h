// Single scattering in closed form, [Blinn82] 2.4, and what orders n >= 2 were divided by: the shares of
// light intercepted along both directions, and the scales of diffusion.h. For one lookup, for many, and
// for packed tables.
//
// A depth or an albedo is a number of type N: F itself, or a float that all lanes share.
#pragma once

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
}  // namespace stratus
