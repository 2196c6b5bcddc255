// A textured table: fast lookups where each has an albedo and optical depth of its own, such as
// textures give rings and clouds of planets.
//
// Which to use:
//   reflection, transmission (lookup.h)   cubic along all five axes of the table as it is; nothing
//                                         to prepare, 0.5 to 1 microsecond
//   Slice (slice.h)                       one layer, many directions: the fastest by far
//   TexturedTable                         everything varies
//
// What lookup.h interpolates, samples divided by albedo, shares intercepted and diffusion scales,
// hardly differs in shape from one layer to the next. Within a block of neighbouring optical depths
// sixteen functions of the directions suffice for all layers: a basis chosen greedily from the
// layers themselves, as in reduced-basis methods, until the largest error is small enough. A lookup
// is the product of sixteen coefficients, cubic in albedo and optical depth, with sixteen
// functions, linear in both cosines and cubic in azimuth.
//
// Numbers are single precision; limits and clamping are those of lookup.h, except that below the
// first cosine the multiply scattered part is scaled by the shares intercepted at the cosine
// itself. A table that was narrowed to some directions is clamped to them. No lookup allocates, throws, or takes a lock; any number of threads may share a textured
// table.
#pragma once

#include <stratus/runtime/lookup.h>
#include <stratus/runtime/table.h>

#include <cstddef>
#include <memory>

namespace stratus {

/// Arguments of many lookups, structure of arrays: `count` of each.
struct TexturedPoints {
    const float *albedo, *optical_depth, *mu_in, *mu_out, *azimuth;
    std::size_t count;
};

struct TexturedMemory;  // of one side

class TexturedTable {
  public:
    /// Computes the functions; the table is not needed afterwards.
    ///
    /// Accuracy in 99.9 % of lookups adds at most 0.35 (R) or 0.6 (T) of the table's tolerance to
    ///          its errors, 1.2 at worst.
    /// Cost     seconds for tables of 100 MB; memory: see `bytes`.
    /// Errors   std::invalid_argument for a table that has a mixture axis.
    explicit TexturedTable(const TableView& table);
    TexturedTable(TexturedTable&&) noexcept;
    TexturedTable& operator=(TexturedTable&&) noexcept;
    ~TexturedTable();

    /// As the functions of the same names in lookup.h.
    Scattered reflection(double albedo, double optical_depth,
                         const Geometry& geometry) const noexcept;
    Scattered transmission(double albedo, double optical_depth,
                           const Geometry& geometry) const noexcept;

    /// Totals of many at once; the same numbers to 1e-6.
    void reflection(const TexturedPoints& points, float* total) const noexcept;
    void transmission(const TexturedPoints& points, float* total) const noexcept;

    /// Memory that lookups read.
    std::size_t bytes() const noexcept;

  private:
    std::unique_ptr<const TexturedMemory> reflection_, transmission_;
};

}  // namespace stratus
