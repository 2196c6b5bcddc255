// A packed table: what fast lookups read, in one small file that is mapped into memory.
//
// Which to use:
//   reflection, transmission (lookup.h)   cubic along all five axes of a table, 0.5 to 1 microsecond
//   Slice (slice.h)                       one layer, many directions: the fastest by far
//   PackedTable                           everything varies
//
// Samples divided by albedo, shares intercepted and diffusion scales, as lookup.h interpolates them,
// hardly differ in shape from one layer to the next. Within a block of neighbouring albedos and
// optical depths 16 or 32 functions of the directions suffice for all layers: a basis chosen
// greedily from the layers themselves, as in reduced-basis methods, until the largest error is
// small enough. A lookup is the product of as many coefficients, cubic in albedo and optical depth,
// with these functions, cubic in both cosines and azimuth at the table's own samples.
//
// Slices and BSDFs bind its view, and lookups of a view read it, too. Numbers are single precision,
// functions halves where these suffice, with what rounding leaves of the first of them; limits and
// clamping are those of lookup.h, except that below the first cosine the multiply scattered part is
// scaled by the shares intercepted at the cosine itself. A table that was narrowed to some
// directions is clamped to them. No lookup allocates, throws, or takes a lock; any number of threads
// may share a packed table.
//
// A file may come from a stranger: every offset, shape and number is checked before it is used. The
// layout is that of `safetensors`, described in docs/packed.md.
#pragma once

#include <stratus/table/lookup.h>
#include <stratus/table/table.h>

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace stratus {

class LayerSamples;  // layer_samples.h
struct PackedSide;   // src/table/kernels/packed.h

/// How names of packed tables' files end.
constexpr const char* packed_ending = ".stratus";

/// Arguments of many lookups, structure of arrays: `count` of each.
struct PackedPoints {
    const float *albedo, *optical_depth, *mu_in, *mu_out, *azimuth;
    std::size_t count;
};

/// Three layers, as three colours see one.
struct PackedLayers {
    double albedo[3], optical_depth[3];
};

/// The file of a table.
///
/// Accuracy lookups in 99.9 % of cases add at most 0.5 of the table's tolerance to its errors,
///          relative to R or T, but not to less than 1 % of a layer's largest.
/// Cost     up to seconds for tables of 100 MB.
/// Errors   std::invalid_argument for an attribute whose name the format reserves.
std::vector<char> pack(const Table& table);

/// Packs a table that holds no samples, but one on each side that it has: layers are asked for.
/// Returns nothing on ranks but the first.
std::vector<char> pack(const Table& table, LayerSamples& samples);

/// Returns a file of the same numbers with the measured error and the attributes of `table`, which are known
/// once the packed samples have been looked up.
std::vector<char> restated(std::string_view file, const Table& table);

class PackedTable {
  public:
    /// Maps a file.
    ///
    /// Errors   std::runtime_error "PATH: reason" for one that is missing, damaged or foreign.
    explicit PackedTable(const std::string& path);

    /// Refers to a file in memory that outlives this and all views of it, aligned to 64 bytes.
    ///
    /// Errors   std::invalid_argument for bytes that are no packed table.
    PackedTable(const void* data, std::size_t bytes);

    /// Keeps a copy of a file's bytes.
    explicit PackedTable(const std::vector<char>& bytes);

    PackedTable(PackedTable&&) noexcept;
    PackedTable& operator=(PackedTable&&) noexcept;
    ~PackedTable();

    /// The bytes of its file, where they lie.
    std::string_view file() const noexcept;

    /// The table without its samples: axes, fluxes, phase functions, attributes.
    const Table& header() const noexcept;

    /// For lookups, slices and BSDFs, valid while this lives and is not moved.
    TableView view() const noexcept;

    /// Counterparts of the functions of these names in lookup.h. Mixture [0, 1]: the share of the first phase
    /// function, which tables without a family ignore. Families of other parameters answer with
    /// not-a-number: look them up through view().at(point), here and below.
    Scattered scattering(Side side, double albedo, double optical_depth, const Geometry& geometry,
                         double mixture = 1) const noexcept;
    Scattered reflection(double albedo, double optical_depth, const Geometry& geometry,
                         double mixture = 1) const noexcept {
        return scattering(Side::reflection, albedo, optical_depth, geometry, mixture);
    }
    Scattered transmission(double albedo, double optical_depth, const Geometry& geometry,
                           double mixture = 1) const noexcept {
        return scattering(Side::transmission, albedo, optical_depth, geometry, mixture);
    }

    /// Orders n >= 2 alone, around a point of a family without its path law.
    double multiple(Side side, double albedo, double optical_depth, const Geometry& geometry,
                    const FamilyStencil& members) const noexcept;

    /// Orders n >= 2 of three layers along the same directions: the same numbers, faster than one
    /// by one.
    void multiple(Side side, const PackedLayers& layers, const Geometry& geometry, double mixture,
                  double (&value)[3]) const noexcept;

    /// Totals of many at once, all of one mixture; the same numbers to 1e-6.
    void scattering(Side side, const PackedPoints& points, float* total,
                    double mixture = 1) const noexcept;
    void reflection(const PackedPoints& points, float* total, double mixture = 1) const noexcept {
        scattering(Side::reflection, points, total, mixture);
    }
    void transmission(const PackedPoints& points, float* total, double mixture = 1) const noexcept {
        scattering(Side::transmission, points, total, mixture);
    }

    bool has_reflection() const noexcept;
    bool has_transmission() const noexcept;

    /// Orders n >= 2 without the path law, over (mu_in, mu_out, azimuth) at the samples of a view's
    /// axes, divided by the shares intercepted along both directions; over a lower boundary as they
    /// are. What slices are bound from.
    std::vector<float> layer(Side side, double albedo, double optical_depth,
                             const FamilyStencil& members) const;

    /// The table with its samples as lookups give them, which its attribute `samples` says.
    Table unpacked() const;

    /// Returns the numbers that lookups of a side read; for a family, those of its first member.
    const PackedSide& side(Side side) const noexcept;

    /// Whether the file is as it was written, by its checksum. Opening one does not ask.
    ///
    /// Cost     of reading all of it, some 2 ms a megabyte.
    bool is_intact() const;

  private:
    struct Contents;
    std::unique_ptr<const Contents> contents_;
};

}  // namespace stratus
