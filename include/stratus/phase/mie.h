#pragma once

#include <stratus/phase/kinds.h>

#include <complex>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace stratus {

/// Homogeneous spheres and the light that they scatter. Lengths in micrometres.
struct Droplets {
    /// n(r): of effective radius a and effective variance v the gamma distribution
    /// r^((1-3v)/v) exp(-r / (a v)) [HT74] 2.56, or the lognormal one, of
    /// sigma^2 = ln(1 + v) and median radius a / (1 + v)^(5/2); by its own parameters the modified
    /// gamma distribution r^alpha exp(-b r^gamma), b = alpha / (gamma mode_radius^gamma), largest at
    /// the mode radius (D. Deirmendjian, Electromagnetic Scattering on Spherical Polydispersions,
    /// 1969); or straight lines between rows, with nothing beyond them.
    enum class Distribution { gamma, lognormal, modified_gamma, rows };
    enum class Material { water, ice, other };

    double effective_radius = 10;   // of gamma and lognormal: the mean of r^3 over that of r^2
    double effective_variance = 0;  // of these, [0, 0.5]; 0: all have one radius
    Distribution distribution = Distribution::gamma;
    double mode_radius = 4, alpha = 6, gamma = 1;  // of modified_gamma; [0.1, 100], [0.25, 10]
    std::vector<double> radius, number;            // of rows: radii and droplets per um of radius
    double wavelength = 0.55;  // above 0; [0.19010783, 5.046613] in water, [0.25, 4] in ice
    Material material = Material::water;
    std::complex<double> index = 0;  // of other material: n in [0.01, 10], k in [0, 10]
    /// Where the index was read from a file: the only wavelength that it is of. 0: of any.
    double index_wavelength = 0;

    /// True where effective_radius and effective_variance are what gives the sizes.
    bool has_effective_parameters() const noexcept {
        return distribution == Distribution::gamma || distribution == Distribution::lognormal;
    }
};

/// Effective radius (um) and variance [HT74] 2.53, 2.54.
struct EffectiveSize {
    double radius, variance;
};

/// The effective size of any distribution: as given, from gamma functions, or integrated over rows.
EffectiveSize effective_size(const Droplets& droplets);

/// True where the droplets are of the same sizes, whatever they consist of.
bool have_same_sizes(const Droplets& a, const Droplets& b) noexcept;

/// The index of refraction n + i k: of water from Segelstein, University of Missouri, 1981, of ice
/// from Warren and Brandt, J. Geophys. Res. 113, 2008.
std::complex<double> index_of_refraction(const Droplets& droplets);

/// Droplets by Mie scattering, unpolarised.
///
/// Sizes    2,000 to 4,000, or 2,000 and at least four between neighbouring rows, up to where those left
///          out add less than 1e-6 to phi at 0 degrees. Without absorption, resonances are narrower than any
///          spacing: with all sizes, phi would differ by up to 2.2 %, most of all straight back, by 0.4 % in root
///          mean square, and g by 2e-4; but hardly otherwise for droplets of nearly the same size.
/// Range    2 pi radius / wavelength of every droplet at most 10,000, of the effective radius at
///          least 1e-4.
/// Accuracy phi 1e-6 relative in the forward peak; moments 1e-12.
/// Cost     of the first value, at 0.55 um: 0.04 s for a cloud of 10 um, 1.6 s for 50 um, 10 s for
///          100 um, two minutes for 200 um; all objects of the same droplets share one table.
/// Threads  may be constructed and asked by several at a time.
struct Mie : SampledPhase {
    static constexpr PhaseKind kind{
        "mie",
        {"radius", "variance", "distribution", "mode_radius", "alpha", "gamma", "wavelength",
         "material", "index"},
        false,
        "mie:radius=10um,variance=0.1,wavelength=0.55um,material=water",
        "droplets of an effective radius and variance (0: one radius alone); also "
        "distribution=lognormal, material=ice, index=1.33+1e-6i, index=FILE.csv (columns "
        "wavelength_um, n, k); in place of radius and variance "
        "distribution=modified_gamma,mode_radius=4um,alpha=6,gamma=1 or distribution=FILE.csv "
        "(columns radius_um, number_per_um)"};

    Droplets droplets;

    explicit Mie(const Droplets& droplets);

    /// The value of `first` and `NAME=value` after each comma: see kind's help. Lengths have
    /// units: um or nm.
    static Mie read(PhaseText& text, const std::string& first);
    std::string parameter_text() const;

    /// Returns the single-scattering albedo, (0, 1].
    double albedo() const;
    /// Cross-section over the geometric one.
    double extinction_efficiency() const;

    double operator()(double c) const noexcept;
    std::vector<double> moments(std::size_t count) const;
    std::string caption() const;

    struct Scattering {
        double albedo, extinction_efficiency;
        std::vector<double> chi;
        std::vector<double> value;  // uniformly over Theta, continued beyond both ends
        double intervals;           // over 0 .. pi
    };

    class SharedScattering;

    /// A place that keeps scattering between runs, by the text of the droplets' parameters.
    struct Store {
        std::function<std::optional<std::vector<double>>(const std::string& droplets)> find;
        std::function<void(const std::string& droplets, const std::vector<double>& numbers)> keep;
    };

    /// Scattering that is not known yet is looked for there from now on, and kept there once it is
    /// computed. Both functions may be called by several threads at a time.
    static void keep_scattering_in(Store store);

  private:
    std::shared_ptr<const SharedScattering> scattering_;
};

}  // namespace stratus
