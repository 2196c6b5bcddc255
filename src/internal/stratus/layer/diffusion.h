// How deep and thin layers approach their limits: the scales by which tables are divided before they
// are interpolated, and the law by which they are continued below their thinnest sample.
//
// Deep inside any layer the light field decays as exp(-k tau), k the diffusion exponent [vdH80]; at
// w = 1, k = 0 and transmission falls as 1/(tau + q), q the extrapolation length. Near w = 1 and in
// deep layers R and T change with (tau, w) far faster than any affordable axis can follow, but only
// through these two functions; what is left after dividing by them is smooth.
#pragma once

#include <stratus/base/direction.h>

#include <cmath>

namespace stratus {

/// q (1 - g) of conservative isotropic scattering, 2 x 0.7104. [vdH80]
constexpr double reduced_extrapolation_length = 1.4208921792;

/// (1 - exp(-z)) / z for z >= 0, 1 at z = 0: the mean of exp(-x) over [0, z].
inline double mean_of_exponential(double z) noexcept { return z == 0 ? 1 : -std::expm1(-z) / z; }

/// How transmission falls with depth: sinh(k q) / sinh(k (tau + q)), at k = 0 q / (tau + q); 1 at
/// depth 0, 0 at infinity.
double transmission_scale(double optical_depth, double diffusion_exponent,
                          double extrapolation_length) noexcept;

/// How far reflection still is from that of an infinitely deep layer, as a share of it:
/// (exp(2 k q) - 1) / (exp(2 k (tau + q)) - 1), at k = 0 q / (tau + q); 1 at depth 0, 0 at
/// infinity.
double reflection_deficit(double optical_depth, double diffusion_exponent,
                          double extrapolation_length) noexcept;

/// How reflection nears its limit with depth: 1 / (1 + d + d^2), d its deficit, from 1/3 in thin
/// layers to 1 at infinity; in deep layers 1 - d, to the second order.
double reflection_scale(double optical_depth, double diffusion_exponent,
                        double extrapolation_length) noexcept;

/// The scale of that side.
double diffusion_scale(Side side, double optical_depth, double diffusion_exponent,
                       double extrapolation_length) noexcept;

/// Ratio of the light of a layer deeper than the deepest sample to that of the deepest.
double share_beyond_deepest(Side side, double optical_depth, double deepest,
                            double diffusion_exponent, double extrapolation_length) noexcept;

/// About how far transmitted light is at most from the distribution over directions behind any deeper layer, relative:
/// 7 exp((k - nu) tau), where nu is the rate at which the next mode of the light field dies out, that of the beam where
/// scattering is isotropic. nu^2 = (1 - w g^2) (1 - w g^3) is below what was measured for Henyey-Greenstein's phase
/// functions up to g = 0.85; 7 covers the errors measured for g from -0.5 to 0.93 (derived here).
double transmission_shape_error(double optical_depth, double albedo, double diffusion_exponent,
                                double extrapolation_length) noexcept;

/// How the orders n >= 2 of thin layers outgrow tau^2: the mean of E1(|t - t'|) over pairs of depths
/// t, t' in the layer, which light joins along the horizontal (derived here).
///
/// Accuracy 3 % of the mean up to tau = 1, 14 % at 5; its limit 3/2 - gamma - ln(tau) in thin layers.
double thin_growth(double optical_depth) noexcept;

/// thin_growth as tables are extrapolated by it: beyond 4, where light no longer grows so, that of 4.
double thin_growth_of_samples(double optical_depth) noexcept;

/// How a table goes on below its thinnest sample: R and T, divided by all that scales them, change linearly
/// in optical depth, as from a deeper layer to that sample.
struct ThinLayers {
    double thinnest, deeper;          // equal where one depth is all that there is
    double growth, growth_of_deeper;  // thin_growth_of_samples of either

    struct Weights {
        double of_thinnest, of_deeper;
    };

    /// Weights for fluxes, which are of all orders.
    Weights all_orders(double optical_depth) const noexcept {
        const double share =
            deeper > thinnest ? (optical_depth - thinnest) / (deeper - thinnest) : 0;
        return {1 - share, share};
    }

    /// Weights for the orders n >= 2, but for the growth from the thinnest on. Their slope flattens towards
    /// thin layers: a fifth less errs least where the thinnest is 0.1 to 1 (measured, isotropic and lobes).
    Weights higher_orders(double optical_depth) const noexcept {
        const double share = 0.8 * all_orders(optical_depth).of_deeper;
        return {1 - share, share * growth / growth_of_deeper};
    }
};

}  // namespace stratus
