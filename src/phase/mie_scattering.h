// Scattering by homogeneous spheres: Mie's series [BH83], chapter 4, for one sphere and summed over
// spheres of many sizes; the sizes of droplets, and their indices of refraction.
//
// x = 2 pi radius / wavelength is the size parameter, m = n + i k the index of refraction relative
// to the medium, k >= 0 absorbs. Fields go as exp(-i omega t), as in [BH83]. Cross-sections are in
// units of 1 / wavenumber^2.
#pragma once

#include <stratus/phase/mie.h>
#include <stratus/phase/phase_function.h>

#include <complex>
#include <cstddef>
#include <vector>

namespace stratus {

constexpr double max_size_parameter = 10'000;

/// The amplitudes S1 (across the plane of scattering) and S2 (in it). [BH83] 4.74
struct MieAmplitudes {
    std::complex<double> S1, S2;
};

/// Returns those of one sphere.
///
/// Range  x in [1e-4, max_size_parameter].
MieAmplitudes mie_amplitudes(double x, std::complex<double> m, double cos_theta);

/// Cross-sections of one sphere, or their sums over many.
struct CrossSections {
    double area = 0;        // geometric, pi x^2
    double extinction = 0;  // [BH83] 4.62
    double scattering = 0;  // [BH83] 4.61
    double forward = 0;     // scattering times its mean cosine; [BH83], section 4.5

    double asymmetry() const { return forward / scattering; }
};

/// Returns those of one sphere; x as above.
CrossSections cross_sections(double x, std::complex<double> m);

/// Spheres of one size among many.
struct SphereSize {
    double x;
    double number;  // how many, in any unit
};

/// The summed scattering of many spheres.
struct SphereScattering {
    CrossSections total;
    std::vector<double> moments;  // chi_l of the phase function, to the last one, l = 2 n_max
};

/// Cost  about 2 (n + N) N^2 multiplications for n spheres of up to N terms, 8 n N^2 for few spheres:
///       0.04 s for a cloud of r_eff = 10 um at 0.55 um.
SphereScattering sphere_scattering(const std::vector<SphereSize>& spheres, std::complex<double> m);

// ---- the sizes that stand for a distribution of droplets (droplet_sizes.cpp)

constexpr int sizes_of_a_distribution = 2000;  // at least, and fewer than twice as many

/// Radii between which droplets count, over the effective radius.
struct RadiusRange {
    double min, max;
};

RadiusRange radius_range(const Droplets& droplets);

/// One sphere, or `count` of them at least and fewer than twice as many, uniform in the square root of the
/// radius: dense where the droplets are; large ones, which are few and costly, lie further apart.
std::vector<SphereSize> sphere_sizes(const Droplets& droplets, int count = sizes_of_a_distribution);

// ---- rows of indices of refraction n + i k, and what lies between them (refractive_index.cpp)

struct IndexRow {
    double wavelength, n, k;  // wavelength in vacuum, um
};

struct IndexRows {
    const IndexRow* first;
    std::size_t count;
};

/// The rows of liquid water.
IndexRows water_rows();

/// Interpolates n and ln k by monotone cubics in the logarithm of the wavelength, and passes through
/// every row. Beside a row with k = 0, k itself is interpolated, linearly.
///
/// Range  two rows or more, ascending; a wavelength within them.
std::complex<double> interpolated_index(IndexRows rows, double wavelength);

/// Interpolates likewise in a file with the columns wavelength_um, n and k.
///
/// Errors  std::invalid_argument naming the file and its line, what is allowed and what was met; for
///         fewer than two rows, and for a wavelength beyond them.
std::complex<double> index_of_file(const PhaseColumns& columns, double wavelength);

}  // namespace stratus
