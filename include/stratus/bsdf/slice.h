// A slice: a layer of one optical depth and albedo, bound once so that every lookup is short.
//
// Binding does the expensive work: it interpolates a table along optical depth and albedo, refines
// its cosines until straight lines between samples meet the table's tolerance, or cubics where the
// tolerance is fine, and its azimuths until cubics do, and picks the code for the effects asked for. A slice owns all that it reads; the table may go.
// Single scattering needs no table at all. Colours share everything but depth and albedo: one
// lookup of an RgbSlice gives three.
//
// A table knows the layers between its samples, and by law some beyond them: thinner ones (orders
// n >= 2 fall with the shares intercepted, lookup.h), albedo 0 (nothing is scattered twice),
// infinite depth (nothing is transmitted), and layers deeper than the deepest sample where
// reflection is within the table's tolerance of its limit (diffusion.h); their transmission, where the
// deepest sample is so deep that it falls off with depth alike in all directions, or is negligible.
// Any other is refused, or clamped on request.
//
// A table of a stack (stack_layers.h) knows the stack alone: its depth, its albedo, no density and
// no opposition. Light comes from above alone; it may leave below.
//
// Numbers are single precision. R and T are normalised as everywhere (single_scattering.h): a white
// Lambert surface has R = 1, BRDF = R / pi. No lookup allocates, throws or takes a lock; any number
// of threads may share a slice. Outside the table's cosines and azimuths the orders n >= 2 are
// those of its edge: of a table that was narrowed to some directions ask for no others.
// Not-a-number in an argument gives not-a-number, of many lookups in that one alone; others out of
// range count as the nearest in range, and R and T are never negative (lookup.h).
#pragma once

#include <stratus/base/direction.h>
#include <stratus/layer/effects.h>
#include <stratus/table/table.h>

#include <array>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

namespace stratus {

/// Red, green, blue.
struct Rgb {
    float r, g, b;

    friend Rgb operator*(const Rgb& value, float factor) noexcept {
        return {value.r * factor, value.g * factor, value.b * factor};
    }
};

/// A layer's optical depth and single-scattering albedo, one for each channel.
template <int channels>
struct Medium {
    double optical_depth[channels];  // [0, inf]
    double albedo[channels];         // [0, 1]
};

/// How binding treats a layer that the table does not know.
enum class OutsideTable {
    refuse,
    clamp,  // orders n >= 2 of the nearest layer that it knows, of thinner ones by what they intercept
};

template <int channels>
class SliceOf {
  public:
    static_assert(channels == 1 || channels == 3);
    using Value = std::conditional_t<channels == 1, float, Rgb>;

    /// Binds a table.
    ///
    /// Range    layers that the table knows, see above.
    /// Errors   std::invalid_argument for a medium or effects out of range, for a layer that the
    ///          table does not know, or a table with a family of which no point was chosen
    ///          (TableView::at).
    SliceOf(const TableView& table, const Medium<channels>& medium, const Effects& effects = {},
            OutsideTable outside = OutsideTable::refuse);

    /// Single scattering of a layer, with no table.
    SliceOf(const PhaseFunction& phase_function, const Medium<channels>& medium,
            const Effects& effects = {});

    /// Binds the single scattering of a stack (stack_layers.h), alike in all channels.
    SliceOf(const StackLayers& layers, const Effects& effects);

    SliceOf(SliceOf&&) noexcept;
    SliceOf& operator=(SliceOf&&) noexcept;
    ~SliceOf();

    /// R or diffuse T, by the side. 0 for a side that was not asked for, or that the table lacks.
    ///
    /// Range    cosines [0, 1], azimuth finite, radians; accurate below a million.
    Value scattering(Side side, float mu_in, float mu_out, float azimuth) const noexcept;
    Value reflection(float mu_in, float mu_out, float azimuth) const noexcept {
        return scattering(Side::reflection, mu_in, mu_out, azimuth);
    }
    Value transmission(float mu_in, float mu_out, float azimuth) const noexcept {
        return scattering(Side::transmission, mu_in, mu_out, azimuth);
    }

    /// BRDF or BTDF, R / pi or T / pi, by the hemispheres of the two directions; light may come
    /// from either side of the layer, over a lower boundary or of a stack from above alone.
    /// Symmetric in wi and wo where the table is; elsewhere wi is that of the incident light.
    ///
    /// Range    unit vectors, which are not normalised here: of others the value means nothing.
    Value eval(const Vector& wi, const Vector& wo) const noexcept;

    // Many at once, structure of arrays: channel c of lookup i lands in value[c * count + i]. The
    // same numbers to 1e-6, and faint ones, exp(-x), to the rounding of x.
    void scattering(Side side, std::size_t count, const float* mu_in, const float* mu_out,
                    const float* azimuth, float* value) const noexcept;
    void reflection(std::size_t count, const float* mu_in, const float* mu_out,
                    const float* azimuth, float* value) const noexcept {
        scattering(Side::reflection, count, mu_in, mu_out, azimuth, value);
    }
    void transmission(std::size_t count, const float* mu_in, const float* mu_out,
                      const float* azimuth, float* value) const noexcept {
        scattering(Side::transmission, count, mu_in, mu_out, azimuth, value);
    }
    /// Arrays of x, y and z.
    void eval(std::size_t count, const float* const wi[3], const float* const wo[3],
              float* value) const noexcept;

    /// The beam that is transmitted unscattered, exp(-tau / mu). Over a lower boundary 0 like all
    /// that follows: nothing is seen through it.
    Value direct(float mu) const noexcept;

    /// Share of a uniform background that is seen through the layer: the beam, and the diffuse
    /// transmittance of the orders asked for. Of a table without diffuse_transmittance order 1
    /// alone; without Effects::background the beam alone. At most 1.
    Value background(float mu) const noexcept;

    /// A small bright source straight behind the layer: the beam, and the radiance scattered once
    /// towards the viewer for each steradian of the source. It is no share: it may exceed 1.
    /// [Blinn82] 2.5
    Value source_behind(float mu) const noexcept;

    /// Memory that lookups read.
    std::size_t bytes() const noexcept;

    const Medium<channels>& medium() const noexcept { return medium_; }

    /// True over a lower boundary and of a stack: light may come from above alone.
    bool is_one_sided() const noexcept { return one_sided_; }

    /// False where orders n >= 2 are from a table that was narrowed to some directions.
    bool has_all_directions() const noexcept { return has_all_directions_; }

    /// True where OutsideTable::clamp took the nearest layer that the table knows instead.
    bool clamped() const noexcept { return clamped_; }

  private:
    struct BoundSide;

    SliceOf(const PhaseFunction& phase_function, const PhaseCurve& curve,
            const LowerBoundary* boundary, const Medium<channels>& medium, const Effects& effects);
    void set_kernels();
    void bind_stack(const StackLayers& layers, const LowerBoundary* boundary);
    void bind_layers(const StackLayers& layers, Side which);
    void check_coverage(const TableView& table, Side which, OutsideTable outside);
    void bind_orders(const TableView& table, Side which);
    void bind_background(const TableView* table, const PhaseFunction& phase_function,
                         const StackLayers* layers, const Effects& effects);
    /// of(channel, mu) for every channel; 0 over a lower boundary.
    template <class OfChannel>
    Value seen_through(float mu, const OfChannel& of) const noexcept;

    Medium<channels> medium_;  // optical depth with the effect of density
    bool over_boundary_ = false;
    bool one_sided_ = false;  // over a boundary, or of a stack
    bool clamped_ = false;
    bool has_all_directions_ = true;
    float forward_phase_ = 0;  // phi(Theta = 0), 0 without single scattering

    // Diffuse transmittance divided by the share intercepted, over cosines; empty where it is 0.
    AxisView background_mu_{};
    std::array<std::vector<float>, channels> background_;

    PathSheet path_;  // empty where there is no path law
    PerSide<std::unique_ptr<BoundSide>> sides_;
};

using Slice = SliceOf<1>;
using RgbSlice = SliceOf<3>;

extern template class SliceOf<1>;
extern template class SliceOf<3>;

/// The layer of one optical depth and albedo: two milliseconds where it takes less than a megabyte.
Slice bind(const TableView& table, double optical_depth, double albedo, const Effects& effects = {},
           OutsideTable outside = OutsideTable::refuse);
/// Binds at a point of a table's family, TableView::at(parameters): bind(table, tau, w, {10}).
Slice bind(const TableView& table, double optical_depth, double albedo,
           std::initializer_list<double> parameters, const Effects& effects = {},
           OutsideTable outside = OutsideTable::refuse);
RgbSlice bind_rgb(const TableView& table, const double (&optical_depth)[3],
                  const double (&albedo)[3], const Effects& effects = {},
                  OutsideTable outside = OutsideTable::refuse);

}  // namespace stratus
