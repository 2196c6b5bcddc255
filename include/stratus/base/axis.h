// Axes of a table: value -> fractional index and back, and the four weights of a cubic.
//
// Each quantity is sampled uniformly in the coordinate in which scattered light varies evenly:
// optical depth in log2(tau), albedo in sqrt(1 - w), parameters of phase functions as phase_family.h
// says, azimuth in itself or, where light is scattered mostly straight on, in its square root,
// cosines in asin(mu^(1/4)): thin layers vary fast at grazing angles, and odd azimuthal modes carry
// a factor sqrt(1 - mu^2), which has infinite slope at mu = 1 in any power of mu. Interpolation is
// by the cubic through the four nearest samples (Lagrange), fewer where the axis has fewer.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace stratus {

enum class AxisScale {
    linear,                     // azimuth, mixture: the value itself
    arcsine_of_fourth_root,     // mu: asin(mu^(1/4))
    logarithmic,                // optical depth: log2(tau)
    square_root_of_complement,  // albedo: -sqrt(1 - w)
    square_root,                // azimuth of peaked light: sqrt(azimuth)
    fourth_root_of_complement,  // albedo of deep layers near 1: -(1 - w)^(1/4)
    logarithm_of_complement,    // g of a family: -log2(1 - g)
};

/// Name of a scale in files: as above.
const char* axis_scale_name(AxisScale scale) noexcept;
/// The scale of this name; none of another.
std::optional<AxisScale> axis_scale_named(const std::string& name) noexcept;

/// Name in files of the linear scale of a mixture.
constexpr const char* mixture_scale_name = "identity";

/// Samples that a cubic interpolates between.
constexpr int stencil_size = 4;

/// Up to four neighbouring samples and their weights; unused weights are 0. On an axis of fewer
/// than four samples `first` is 0 and the weights past its end, all 0, belong to no sample.
struct Stencil {
    int first;
    float weight[stencil_size];
};

/// The numbers of an axis that a lookup needs; trivially copyable.
struct AxisView {
    AxisScale scale;
    int count;               // finite samples
    bool ends_at_infinity;   // one more sample, at infinity, follows them
    double first;            // coordinate of sample 0
    double inverse_step;     // samples per unit of coordinate; 0 when count = 1
    double lowest, highest;  // finite range, in values

    /// Samples in all, the one at infinity included.
    int size() const noexcept { return count + (ends_at_infinity ? 1 : 0); }

    /// Value of a finite sample, to rounding.
    double value(int sample) const noexcept;

    /// Fractional index of a value, clamped to the finite samples [0, count - 1]; 0 for
    /// not-a-number.
    double index(double value) const noexcept;

    /// Cubic weights at a value (clamped to the finite range).
    Stencil stencil(double value) const noexcept;

    /// Weights along an axis of azimuths, mirrored where it reaches 0 or pi: light is even in it
    /// about both. In its square root it is so about 0; about pi, where peaked light varies slowly,
    /// the mirrored cubic measures no worse than one that ends there.
    Stencil mirrored_stencil(double value) const noexcept;
};

/// An axis with its sample values exactly as a file holds them, ascending; a logarithmic one may
/// end in infinity.
struct Axis {
    AxisScale scale = AxisScale::linear;
    std::vector<double> values;

    AxisView view() const noexcept;
};

/// `count` samples from `lowest` to `highest` (both met exactly), uniform in the scale's
/// coordinate; count = 1 needs lowest = highest. With `and_infinity` a sample at infinity follows
/// (logarithmic only); count = 0 is then legal.
///
/// Errors   std::invalid_argument for a range outside the scale's domain, or a count that does not
///          fit it.
Axis make_axis(AxisScale scale, double lowest, double highest, int count,
               bool and_infinity = false);

/// Checks values that came from a file: finite (but for one final infinity), in the scale's domain,
/// ascending and uniform to 1e-9 of a step or to the last bits of a value.
///
/// Errors   std::invalid_argument naming `name`, what is required and the value met.
void check_axis(const Axis& axis, const char* name);

}  // namespace stratus
