// A slice: a layer of one optical depth and albedo, bound once so that every lookup is short.
//
// Binding does what is expensive: it interpolates a table along optical depth and albedo, refines
// its cosines and azimuths until straight lines between samples meet the table's tolerance, and
// picks the code for the effects asked for. A slice owns all that it reads; the table may go.
// Single scattering needs no table at all. Colours share everything but depth and albedo: one
// lookup of an RgbSlice gives three.
//
// Numbers are single precision. R and T are normalised as everywhere (single_scattering.h): a white
// Lambert surface has R = 1, BRDF = R / pi. No lookup allocates, throws or takes a lock; any number
// of threads may share a slice. Outside the table's cosines the orders n >= 2 are those of its
// edge.
#pragma once

#include <stratus/runtime/direction.h>
#include <stratus/runtime/effects.h>
#include <stratus/runtime/table.h>

#include <cstddef>
#include <memory>
#include <type_traits>

namespace stratus {

/// Red, green, blue.
struct Rgb {
    float r, g, b;
};

/// A layer's optical depth and single-scattering albedo, one for each channel.
template <int channels>
struct Medium {
    double optical_depth[channels];  // [0, inf]
    double albedo[channels];         // [0, 1]
};

template <int channels>
class SliceOf {
  public:
    static_assert(channels == 1 || channels == 3);
    using Value = std::conditional_t<channels == 1, float, Rgb>;

    /// Binds a table.
    ///
    /// Range    its medium in the table: albedo and upper end of depth are clamped to its axes for
    ///          the orders n >= 2, as lookups are (lookup.h).
    /// Errors   std::invalid_argument for a medium or effects out of range, a table whose mu_in and
    ///          mu_out differ, or one with a mixture axis seen at none (TableView::at_mixture).
    SliceOf(const TableView& table, const Medium<channels>& medium, const Effects& effects = {});

    /// Single scattering of a layer, with no table.
    SliceOf(const PhaseFunction& phase_function, const Medium<channels>& medium,
            const Effects& effects = {});

    SliceOf(SliceOf&&) noexcept;
    SliceOf& operator=(SliceOf&&) noexcept;
    ~SliceOf();

    /// R and diffuse T. 0 for a side that was not asked for.
    ///
    /// Range    cosines (0, 1], azimuth any, radians.
    Value reflection(float mu_in, float mu_out, float azimuth) const noexcept;
    Value transmission(float mu_in, float mu_out, float azimuth) const noexcept;

    /// BRDF or BTDF, R / pi or T / pi, by the hemispheres of the two directions; light may come
    /// from either side of the layer. Symmetric in wi and wo. Over ground, from above alone.
    Value eval(const Vector& wi, const Vector& wo) const noexcept;

    // Many at once, structure of arrays: channel c of lookup i lands in value[c * count + i]. The
    // same numbers to 1e-6.
    void reflection(std::size_t count, const float* mu_in, const float* mu_out,
                    const float* azimuth, float* value) const noexcept;
    void transmission(std::size_t count, const float* mu_in, const float* mu_out,
                      const float* azimuth, float* value) const noexcept;
    /// Arrays of x, y and z.
    void eval(std::size_t count, const float* const wi[3], const float* const wo[3],
              float* value) const noexcept;

    /// The beam that passes straight through, exp(-tau / mu).
    Value direct(float mu) const noexcept;

    /// Share of a background seen through the layer: the beam, and with single scattering the light
    /// that left it straight on. [Blinn82] 2.5
    Value background(float mu) const noexcept;

    /// Memory that lookups read.
    std::size_t bytes() const noexcept;

    const Medium<channels>& medium() const noexcept { return medium_; }

    /// True where something lies beneath: light from below meets nothing then.
    bool is_one_sided() const noexcept { return one_sided_; }

  private:
    struct BoundSide;

    SliceOf(const PhaseFunction& phase_function, const PhaseCurve& curve,
            const LowerBoundary* boundary, const Medium<channels>& medium, const Effects& effects);
    void set_kernels();
    Value at(const BoundSide& side, float mu_in, float mu_out, float azimuth) const noexcept;
    void many(const BoundSide& side, std::size_t count, const float* mu_in, const float* mu_out,
              const float* azimuth, float* value) const noexcept;

    Medium<channels> medium_;  // optical depth with the effect of density
    bool one_sided_ = false;   // something lies beneath
    float forward_phase_ = 0;  // phi(Theta = 0), 0 without single scattering
    std::unique_ptr<BoundSide> reflection_, transmission_;
};

using Slice = SliceOf<1>;
using RgbSlice = SliceOf<3>;

extern template class SliceOf<1>;
extern template class SliceOf<3>;

}  // namespace stratus
