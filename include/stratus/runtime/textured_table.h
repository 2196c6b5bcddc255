// A textured table: fast lookups where every one has an albedo and optical depth of its own, as
// rings and clouds of planets have them from textures.
//
// Which to use:
//   reflection, transmission (lookup.h)   cubic along all five axes of the table as it is; nothing
//                                         to prepare, half a microsecond to one
//   Slice (slice.h)                       one layer, many directions: the fastest by far
//   TexturedTable                         everything varies
//
// What lookup.h interpolates, samples divided by albedo, shares intercepted and diffusion scales,
// hardly differs in shape from one layer to the next. Within a block of neighbouring optical depths
// sixteen functions of the directions suffice for all layers: a basis chosen greedily from the
// layers themselves, as in reduced-basis methods, until the worst of them is met. A lookup is the
// product of sixteen coefficients, cubic in albedo and optical depth, with sixteen functions,
// linear in both cosines and cubic in azimuth.
//
// Numbers are single precision; limits and clamping are those of lookup.h, but that cosines below
// the first sample scale the multiply scattered part by the shares intercepted at the cosine
// itself. No lookup allocates, throws, or takes a lock; any number of threads may share a textured
// table.
#pragma once

#include <stratus/runtime/lookup.h>
#include <stratus/runtime/table.h>

#include <cstddef>
#include <memory>

namespace stratus {

/// Where lookups are asked for, structure of arrays: `count` of each.
struct TexturedPoints {
    const float *albedo, *optical_depth, *mu_in, *mu_out, *azimuth;
    std::size_t count;
};

struct TexturedMemory;  // of one side

class TexturedTable {
  public:
    /// Works out the functions; the table may go afterwards.
    ///
    /// Accuracy in 99.9 % of lookups 0.35 (R) or 0.6 (T) of the table's tolerance are added to its
    ///          errors, 1.2 at worst.
    /// Cost     of time, seconds for tables of 100 MB; of memory, see `bytes`.
    /// Errors   std::invalid_argument for a table whose mu_in and mu_out differ or that has a
    ///          mixture axis.
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
