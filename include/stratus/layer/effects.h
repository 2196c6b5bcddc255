// Effects of a layer: the opposition effect first, then the choice of all.
//
// How single scattering brightens towards phase angle 0: light that leaves by the way it came finds
// that way free of particles.
//
// Blinn's law evaluates [Blinn82] 5.2 as it is derived there. A particle under the vertical optical
// depth t is lit and seen if no other centre lies in one of two cylinders of the particles' radius
// r, of lengths z / mu0 and z / mu, with the probability exp(-n V), V the volume of their union.
// V = pi r^2 z (1/mu0 + 1/mu) - O, and what is counted twice brightens single scattering by
//
//     int_0^tau exp(-s t + n O) dt / int_0^tau exp(-s t) dt,    s = 1/mu0 + 1/mu.
//
// Both cylinders begin at the particle with flat ends. Across the line that halves the phase angle,
// x away from the particle, their sections share the area
// r^2 (L(x sin(a/2) / r) - L(x / (r sin(a/2)))) / cos(a/2), with
// L(q) = 2 acos(q) - 2 q sqrt(1 - q^2) for q < 1, the area that unit circles 2 q apart share, and 0
// beyond. The layer's boundary cuts the overlap at x = z / mu_b, mu_b = (mu0 + mu) / (2 cos(a/2)).
// So
//
//     n O = (b1 G(u / b1) - b2 G(u / b2)) / pi,    u = 2 t / (mu0 + mu),
//     b1 = R / (sin(a/2) cos(a/2)),    b2 = R tan(a/2),
//     G(q) = int_0^q L = 2 q acos(q) - 2 w + 4/3 + (2/3) w^3,  w = sqrt(1 - q^2);  4/3 from q = 1,
//
// and the medium enters by R alone: particle radius over mean free path, n pi r^3 = (3/4) D. Deep
// in the layer n O = (4 / (3 pi)) R cot(a/2): 0 at a = pi. At a = 0 it is u, and the factor
// 1 + tanh(tau / (2 mu)): light is attenuated once, not twice.
#pragma once

#include <vector>

namespace stratus {

struct Opposition {
    enum class Law {
        none,
        blinn,
        hapke,  // 1 + amplitude / (1 + tan(a/2) / h): measured
    };
    Law law = Law::none;
    double width = 0;      // R of Blinn's law, h of Hapke's; 0: of the density, see below
    double amplitude = 1;  // of Hapke's law, [0, 1]

    bool is_present() const noexcept { return law != Law::none; }

    /// Particles that fill the share `density` of the volume; without it, that of Effects::density.
    ///
    /// Range    density (0, 1).
    static Opposition blinn(double density);
    static Opposition blinn() noexcept { return {Law::blinn, 0, 1}; }

    /// Without a width, that of Effects::density.
    ///
    /// Range    amplitude [0, 1], width (0, inf).
    static Opposition hapke(double amplitude, double width);
    static Opposition hapke(double amplitude);

    /// Particle radius over mean free path: n pi r^3 = (3/4) D.
    ///
    /// Range    density (0, 1).
    static double radius_in_free_paths(double density);

    /// Hapke's h, half the ratio above for few particles: -(3/8) ln(1 - D).
    ///
    /// Range    density (0, 1).
    static double width_of_density(double density);
};

/// Returns the opposition effect in a layer whose particles fill the share `density`: a width not
/// given follows from the density, and Blinn's number density is n / (1 - D), as in effective_optical_depth.
/// [Blinn82] 5.1
///
/// Range    density [0, 1), above 0 where the width is not given.
Opposition seen_opposition(const Opposition& opposition, double density);

/// Throws std::invalid_argument, naming `caller` and the argument, when a number is out of range or
/// neither width nor density is given.
void check_opposition(const Opposition& opposition, double density, const char* caller);

/// The factor by which opposition multiplies single scattering on the lit side.
///
/// Range    a law with its width; cos_scattering_angle [-1, 1]; optical_depth [0, inf]; cosines
///          (0, 1].
/// Accuracy 1e-8.
/// Cost     of Blinn's law, by quadrature over depth: 2 to 10 us.
double opposition_factor(const Opposition& opposition, double cos_scattering_angle,
                         double optical_depth, double mu_in, double mu_out) noexcept;

/// The samples read by fast lookups of Blinn's law; trivially copyable.
struct OppositionTableView {
    static constexpr int angles = 33, depths = 25, etas = 17;  // samples

    // Over (angle, depth, eta), see src/layer/kernels/closed_form.h.
    const float* sample = nullptr;
    float radius = 0;       // R
    float angle_scale = 1;  // half of its value, samples of the angle lie evenly in sin(a/2)
};

/// Blinn's law made ready for fast lookups, for all depths.
///
/// Accuracy 1e-3 of the factor up to R = 1; 2e-3 up to R = 7.
/// Cost     of construction, some milliseconds; 56 kB.
/// Threads  lookups are safe; they allocate nothing.
class OppositionTable {
  public:
    /// Makes a table without opposition.
    OppositionTable() = default;

    /// Any law, with its width.
    explicit OppositionTable(const Opposition& opposition);

    /// opposition_factor.
    double factor(double cos_scattering_angle, double optical_depth, double mu_in,
                  double mu_out) const noexcept;

    OppositionTableView view() const noexcept;

    std::size_t sample_count() const noexcept { return samples_.size(); }

  private:
    Opposition opposition_;
    std::vector<float> samples_;  // empty: not Blinn's law
};

// Effects of a layer, each asked for by name and paid for only then.
//
// Effects are chosen when a slice is bound (slice.h), once for all its lookups. How they combine:
//
//   density      particles that fill the share D of the volume: every order sees the depth
//                tau / (1 - D). [Blinn82] 5.1
//   opposition   less shadow where the light comes from behind the eye (above): single
//                scattering on the lit side alone is multiplied by it; light scattered twice has
//                lost the direction that it came from. [Blinn82] 5.2
//   background   the share of a uniform background that is seen through the layer: the beam and the
//                diffuse transmittance of the orders asked for (SliceOf::background). Binding works
//                out the latter, some 0.1 ms without a table; without this effect the beam is seen
//                alone.

/// The share D of the volume that particles of one radius fill: n (4/3) pi r^3. [Blinn82] figures 1
/// and 2
///
/// Units    number_density per cubed unit of radius, any unit.
/// Range    number_density [0, inf), radius (0, inf), so that D is in [0, 1).
double volume_fraction(double number_density, double radius);

/// tau / (1 - D). [Blinn82] 5.1
///
/// Range    optical_depth [0, inf], density [0, 1).
double effective_optical_depth(double optical_depth, double density) noexcept;

/// The effects asked of a layer. A lookup does nothing for the others.
struct Effects {
    bool single = true;
    bool multiple = true;  // all orders n >= 2 that the table holds; needs a table
    bool reflection = true;
    bool transmission = true;
    bool background = true;  // light scattered in SliceOf::background; costs a lookup nothing
    double density = 0;      // D, [0, 1)
    Opposition opposition;   // as seen_opposition(opposition, density)
};

/// Throws std::invalid_argument, naming the argument, when a number is out of range.
void check_effects(const Effects& effects);

}  // namespace stratus
