// Effects of a layer, each asked for by name and paid for only then.
//
// Effects are chosen when a slice is bound (slice.h), once for all its lookups. How they combine:
//
//   density      particles that fill the share D of the volume: every order sees the depth
//                tau / (1 - D). [Blinn82] 5.1
//   opposition   less shadow where the light comes from behind the eye: single scattering on the
//                lit side alone is multiplied by 1 + bump; light scattered twice has lost the
//                direction that it came from. [Blinn82] 5.2
//   background   the share of a uniform background that is seen through the layer: the beam and the
//                diffuse transmittance of the orders asked for (SliceOf::background). Binding works
//                out the latter, some 0.1 ms without a table; without this effect the beam is seen
//                alone.
#pragma once

namespace stratus {

/// How single scattering brightens towards phase angle 0.
struct Opposition {
    enum class Law {
        none,
        /// bump = tanh(tau (1/mu + 1/mu0) / 4) (h^2 / (sin^2(a/2) + h^2 cos^2(a/2)))^2: at a = 0
        /// the light that leaves by the way it came is attenuated once, not twice. [Blinn82] 5.2
        blinn,
        /// bump = amplitude / (1 + tan(a/2) / h), the measured law of Hapke.
        hapke,
    };
    Law law = Law::none;
    double width = 0;      // h, in tan(a/2); > 0
    double amplitude = 1;  // of Hapke's law, [0, 1]

    static Opposition blinn(double density);
    static Opposition hapke(double amplitude, double width);

    /// The angular width that a volume fraction brings with it: h = -(3/8) ln(1 - D), particle
    /// radius over mean free path.
    ///
    /// Range    density (0, 1).
    static double width_of_density(double density);
};

/// The factor by which opposition multiplies single scattering on the lit side.
///
/// Range    cos_scattering_angle [-1, 1]; optical_depth [0, inf]; cosines (0, 1].
double opposition_factor(const Opposition& opposition, double cos_scattering_angle,
                         double optical_depth, double mu_in, double mu_out) noexcept;

/// tau / (1 - D). [Blinn82] 5.1
///
/// Range    optical_depth [0, inf], density [0, 1).
double effective_optical_depth(double optical_depth, double density) noexcept;

/// What is asked of a layer. A lookup does nothing for what is not.
struct Effects {
    bool single = true;
    bool multiple = true;  // all orders n >= 2 that the table holds; needs a table
    bool reflection = true;
    bool transmission = true;
    bool background = true;  // light scattered in SliceOf::background; costs a lookup nothing
    double density = 0;      // D, [0, 1)
    Opposition opposition;
};

/// Throws std::invalid_argument, naming the argument, when a number is out of range.
void check_effects(const Effects& effects);

}  // namespace stratus
