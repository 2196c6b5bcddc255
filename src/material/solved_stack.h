// R and T of one colour of a material between all pairs of a list of cosines, lit from either side; R at any
// geometry from these; functions of azimuth as cosine series.
#pragma once

#include <stratus/material/material.h>
#include <stratus/transfer/stack.h>

#include <bit>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>

namespace stratus {

constexpr double grazing = 1e-9;  // cosine that is solved for the limit at 0

/// True where light passes through.
bool is_transparent(const Stack& stack);

/// A side that light leaves, by the side that it came from: R lit from above, diffuse T lit from above
/// (lit from below, the cosines change places), R lit from below.
enum class LitSide { reflection, transmission, reflection_below };

const char* lit_side_name(LitSide side);

class SolvedStack {
  public:
    SolvedStack() = default;
    SolvedStack(const Stack& stack, const std::vector<double>& mu, int nodes);

    /// R or T at many azimuths in radians; but for reflection 0 of what is opaque.
    std::vector<SolvedValue> values(LitSide side, int in, int out,
                                    const std::vector<double>& azimuths) const;

    /// Fluxes lit from above, over mu_in.
    std::vector<double> plane_albedo() const;
    std::vector<double> diffuse_transmittance() const;  // 0 of what is opaque

    /// Whether T is the same with the cosines exchanged, and R from either side.
    bool is_symmetric() const { return !below_.has_value(); }

    bool is_transparent() const { return transparent_; }

  private:
    StackSolution above_;
    std::optional<StackSolution> below_;  // of layers that differ and let light through
    bool transparent_ = false;
};

// Grids that strangers look up: cosines even in u = asin(sqrt(mu)) 2 / pi, azimuths even from 0 to
// pi, and R or T times mu_in + mu_out. That factor removes the growth at grazing angles; in u
// neither it nor the sines near the normal are steep.

/// `count` cosines even in u, of which the first stands for the limit 0.
std::vector<double> even_cosines(int count);

/// `count` azimuths from 0 to pi.
std::vector<double> even_azimuths(int count);

/// A material, colour by colour.
using SolvedColours = std::vector<SolvedStack>;

/// Reflection; transmission, where light passes; reflection_below, where it is another.
std::vector<LitSide> lit_sides(const Material& material, const SolvedColours& colours);

/// Optical depth that the beam passes, for each colour; infinity where nothing does.
std::vector<double> beam_depths(const Material& material);

// Even functions of azimuth as cosine series, as short as a relative error allows.

/// Numbers over (function, azimuth), or (function, term of its series).
using Functions = std::vector<std::vector<double>>;

/// Values of several functions at azimuths.
using AzimuthValues = std::function<Functions(const std::vector<double>& azimuths)>;

/// f = sum_k a_k cos(k azimuth) of each function, all equally long: within `tolerance` of every
/// value, or of a thousandth of the mean where that is more. Empty where no mean is above 0.
///
/// Errors   std::runtime_error where 4,096 terms do not suffice.
Functions cosine_series(const AzimuthValues& values, double tolerance);

// R of one colour at any geometry, from a solution at cosines that are dense everywhere: single
// scattering in closed form, the rest by polynomials through six samples of cosine and azimuth.

/// Single scattering of a stack lit from above, its ground included.
double single_reflection(const Stack& stack, const Geometry& geometry);

class ReflectionField {
  public:
    /// Cosines even in s = (2/pi asin(mu))^(2/3), of [0, 1], `count` of them: for solutions that
    /// this is made of. The first stands for the limit 0.
    static std::vector<double> cosines(int count);

    /// Takes a solution at `cosines(count)`.
    ReflectionField(const Stack& stack, const SolvedStack& solved, const std::vector<double>& mu,
                    int threads);

    /// R with mu_out the cosine of place `out`, any mu_in of [0, 1], azimuth of [0, pi].
    double operator()(double mu_in, int out, double azimuth) const;

  private:
    static constexpr int azimuth_intervals = 128;

    const Stack& stack_;
    const std::vector<double>& mu_;
    std::vector<double> rest_;  // orders n >= 2 over (out, in, azimuth)
};

// The formats, and what they share.

MaterialFile make_fourier(const Material& material, const MaterialOptions& options);
MaterialFile make_tensor(const Material& material, bool rgb, const MaterialOptions& options);
MaterialFile make_mqdiffuse(const Material& material, const MaterialOptions& options);
MaterialFile make_atlas(const Material& material, const MaterialOptions& options);
MaterialFile make_slice(const Material& material, const MaterialOptions& options);

/// Returns a MaterialFile::write of these bytes.
std::function<void(const std::filesystem::path&)> writing(std::vector<char> bytes);

/// Every colour of a material solved at the same cosines.
SolvedColours solve_colours(const Material& material, const std::vector<double>& mu,
                            const MaterialOptions& options);

/// Describes a material for a file's text: its title, layers and the ground under them.
std::string describe(const Material& material);

/// The note on what passes, for formats of reflection alone; none where nothing does.
void note_transmission(const Material& material, std::vector<std::string>& notes);

/// A little-endian file, built in memory.
class Encoder {
  public:
    static_assert(std::endian::native == std::endian::little, "files are little-endian");

    template <class Number>
    void put(const std::vector<Number>& values) {
        static_assert(std::is_arithmetic_v<Number>);
        const char* const first = reinterpret_cast<const char*>(values.data());
        bytes_.insert(bytes_.end(), first, first + values.size() * sizeof(Number));
    }
    template <class Number>
    void put(Number value) {
        put(std::vector{value});
    }
    void put(std::string_view text) { bytes_.insert(bytes_.end(), text.begin(), text.end()); }

    /// Returns the whole file, after which nothing is left.
    std::vector<char> finish() { return std::move(bytes_); }

  private:
    std::vector<char> bytes_;
};

}  // namespace stratus
