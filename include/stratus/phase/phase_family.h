// Families of phase functions: one or two parameters of a phase function are axes of a table, or
// the share in which it is mixed with a second one. Members are the phase functions at the samples
// of these axes: the tensor product of both, the last axis fastest.
//
// Ranges are sampled where light varies evenly: radius, wavelength and variance in their logarithm,
// g in -log2(1 - g), the mixture in itself; lookups are cubic along them. Of an axis of discrete
// values a lookup takes one.
#pragma once

#include <stratus/base/axis.h>
#include <stratus/phase/phase_function.h>

#include <array>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace stratus {

/// Lengths are in um.
enum class PhaseParameter {
    mixture,  // f of f phi1 + (1 - f) phi2, [0, 1]
    g,        // of the henyey_greenstein among the terms, (-1, 1)
    radius,   // these of the mie among the terms, as there; of distribution gamma or lognormal
    wavelength,
    variance,
};

/// In the order of a family's axes.
inline constexpr std::array<PhaseParameter, 5> all_parameters{
    PhaseParameter::mixture, PhaseParameter::g, PhaseParameter::radius, PhaseParameter::wavelength,
    PhaseParameter::variance};

/// Its name in recipes, files and queries.
const char* parameter_name(PhaseParameter parameter) noexcept;

/// "um", or "1" for numbers.
const char* parameter_unit(PhaseParameter parameter) noexcept;

std::optional<PhaseParameter> parameter_named(const std::string& name) noexcept;

/// All names, for messages.
std::vector<std::string> parameter_names();

/// How a range of it is sampled.
AxisScale parameter_scale(PhaseParameter parameter) noexcept;

constexpr int max_family_axes = 2;

/// A value for each axis of a family, in their order.
class FamilyPoint {
  public:
    FamilyPoint() = default;
    FamilyPoint(std::initializer_list<double> values)
        : FamilyPoint(values.begin(), values.size()) {}
    explicit FamilyPoint(const std::vector<double>& values)
        : FamilyPoint(values.data(), values.size()) {}

    /// Values given, however many.
    std::size_t size() const noexcept { return size_; }

    double operator[](std::size_t axis) const noexcept { return value_[axis]; }
    double& operator[](std::size_t axis) noexcept { return value_[axis]; }

    /// True where the values given are the same.
    friend bool operator==(const FamilyPoint& a, const FamilyPoint& b) noexcept {
        if (a.size_ != b.size_) return false;
        for (std::size_t k = 0; k < a.size_ && k < max_family_axes; ++k)
            if (a.value_[k] != b.value_[k]) return false;
        return true;
    }

  private:
    FamilyPoint(const double* values, std::size_t count) noexcept : size_(count) {
        for (std::size_t k = 0; k < count && k < max_family_axes; ++k) value_[k] = values[k];
    }

    std::size_t size_ = 0;
    std::array<double, max_family_axes> value_{std::numeric_limits<double>::quiet_NaN(),
                                               std::numeric_limits<double>::quiet_NaN()};
};

struct FamilyAxis {
    PhaseParameter parameter;
    Axis axis;                 // ascending; a range in parameter_scale, two samples at least
    bool is_discrete = false;  // values in any steps, of which lookups take one

    const char* name() const noexcept { return parameter_name(parameter); }
};
using FamilyAxes = std::vector<FamilyAxis>;

/// Members around a point and their weights; unchosen: not-a-number.
struct FamilyStencil {
    static constexpr int max_count = stencil_size * stencil_size;
    int count = 1;
    int member[max_count] = {0};
    float weight[max_count] = {1};
};

/// A phase function with one parameter set, in the only one of its terms that has it.
///
/// Errors   std::invalid_argument for a phase function without such a term, or with several, and
///          for values that the term does not allow; for `mixture`.
PhaseFunction with_parameter(const PhaseFunction& phase_function, PhaseParameter parameter,
                             double value);

/// Sets all parameters of some axes (FamilyAxis, or anything with a `parameter`) but `mixture`.
template <class Axes>
PhaseFunction with_parameters(const PhaseFunction& phase_function, const Axes& axes,
                              const FamilyPoint& at) {
    PhaseFunction set = phase_function;
    for (std::size_t k = 0; k < axes.size(); ++k)
        if (axes[k].parameter != PhaseParameter::mixture)
            set = with_parameter(set, axes[k].parameter, at[k]);
    return set;
}

/// The phase function at a point of the axes, whose parameters are those of `first`. Errors as above.
template <class Axes>
PhaseFunction phase_function_at(const PhaseFunction& first, const PhaseFunction& second,
                                const Axes& axes, const FamilyPoint& at) {
    const PhaseFunction set = with_parameters(first, axes, at);
    for (std::size_t k = 0; k < axes.size(); ++k)
        if (axes[k].parameter == PhaseParameter::mixture)
            return PhaseFunction::mixture(at[k], set, second);
    return set;
}

/// 1 without axes.
std::size_t member_count(const FamilyAxes& axes) noexcept;

/// Range    member in [0, member_count()).
FamilyPoint member_at(const FamilyAxes& axes, std::size_t member);

/// Where all axes end.
std::vector<FamilyPoint> family_corners(FamilyAxes axes);

/// Clamped to ranges; discrete values must be met to 1e-7 of them, or the weights are not-a-number.
FamilyStencil family_stencil(const FamilyAxes& axes, const FamilyPoint& at) noexcept;

/// True of a family with an axis `mixture`.
bool mixes_two(const FamilyAxes& axes) noexcept;

/// True where a lookup may ask for the value: within the range, or one of the discrete values.
bool holds(const FamilyAxis& axis, double value) noexcept;

/// Describes the values that `holds` accepts, for messages.
std::string allowed_text(const FamilyAxis& axis);

/// Checks the axes of a table.
///
/// Errors   std::invalid_argument naming the axis, what is required and what was met.
void check_family(const PhaseFunction& first, const FamilyAxes& axes, const char* caller);

}  // namespace stratus
