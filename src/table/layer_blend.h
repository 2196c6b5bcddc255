// A layer of any member of a family, optical depth and albedo as a weighted sum of those that a table holds:
// cubic along these axes, by the laws of diffusion between the deepest sample and infinity, around
// samples that float cannot hold. The fluxes that a table holds are summed up likewise.
#pragma once

#include <stratus/layer/diffusion.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/table/table.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace stratus {

/// A reflection deficit (diffusion.h) below this at the deepest sample: that sample is the limit.
constexpr double min_deficit = 1e-5;

/// Samples grow as the square of a small albedo: those of a tiny one are 0, divided or not.
constexpr double tiny_albedo = 1e-15;

/// On one side.
inline std::ptrdiff_t samples_per_layer(const TableView& table) noexcept {
    return std::ptrdiff_t{table.mu_in.count} * table.mu_out.count * table.azimuth.count;
}

/// How many samples the stencils of an axis count.
inline int used_samples(const AxisView& axis) noexcept {
    return std::min(axis.count, stencil_size);
}

/// One (member, albedo, optical_depth) of a side: where its directions start among the side's
/// samples, its share of the sum, its depth.
struct BlendTerm {
    std::ptrdiff_t first;
    float share;
    int depth;
};

/// The terms that a lookup adds up, each over (mu_in, mu_out, azimuth) times the table's weights of
/// its depth along both directions: at most 16 members by 4 albedos by 4 depths, by 5 of thin layers.
struct LayerBlend {
    const float* samples;  // of the side
    BlendTerm term[FamilyStencil::max_count * stencil_size * (1 + stencil_size)];
    int count = 0;
    double optical_depth = 0;  // clamped to the table
    double growth =
        1;  // of the orders n >= 2 in layers thinner than the table's (thin_growth, diffusion.h)
    bool fades = false;  // see `directional_factor`
};

/// The law beyond the deepest sample of a table that has none at infinity.
enum class BeyondDeepest { is_clamped, follows_diffusion };

/// The depth at which a table is looked up: beyond its deepest sample that one, unless light is known
/// further on.
double depth_in(const TableView& table, double optical_depth,
                BeyondDeepest beyond = BeyondDeepest::is_clamped) noexcept;

/// Factor that takes transmitted light from a member of a family, of that diffusion exponent, to the
/// chosen point. Light of n orders is a polynomial of degree n in a mixture and divided by nothing; but
/// in deep layers many orders make it exponential.
double fall_from_member(double optical_depth, double exponent, double chosen_exponent,
                        double extrapolation_length) noexcept;

/// Members around a point with that factor in their weights, for light transmitted by a layer within
/// the table. Without a family they come back as they are.
FamilyStencil transmitted_members(const TableView& table, FamilyStencil members, double albedo,
                                  double optical_depth) noexcept;

/// The deeper layer is an octave deeper, if the first three samples reach so far.
ThinLayers thin_layers(const AxisView& depths) noexcept;

/// Needs a table that has this side. `with_order_1`: of fluxes, which a table holds in all orders.
LayerBlend layer_blend(const TableView& table, Side side, double albedo, double optical_depth,
                       BeyondDeepest beyond = BeyondDeepest::is_clamped,
                       bool with_order_1 = false) noexcept;

/// Factor of the sum along both directions: the divisor of the samples.
double directional_factor(const TableView& table, const LayerBlend& blend, double mu_in,
                          double mu_out) noexcept;

/// The law of thin layers: what the orders n >= 2 of a layer without a boundary grow with.
double thin_law(const TableView& table, Side side, double albedo, double optical_depth,
                const Geometry& geometry) noexcept;

/// Ratio of the light of a thin layer over a surface to that of the thinnest sampled: a surface alone
/// scatters once, and a thin layer adds in proportion to what it extinguishes.
double share_of_thinnest(double optical_depth, double thinnest, double mu_in,
                         double mu_out) noexcept;

// Which layers a table knows: those between its samples, and by law some beyond them (slice.h); and how
// closely faster lookups follow it.

/// True where a table knows a value on one of its axes, to the rounding of a float.
bool holds(const AxisView& axis, double value);

/// True where the orders n >= 2 are 0: nothing in the layer scatters, and a surface alone does so
/// once.
bool is_scattered_once(const TableView& table, double albedo, double optical_depth);

/// Between the samples of optical depth, below them by the law of thin layers, beyond them by that
/// of diffusion, once reflection is at its limit and transmission has the shape of a deep layer's.
bool is_depth_known(const TableView& table, Side side, double albedo, double optical_depth);

// Ranges covered by the table and by the laws that extend it, for messages.
std::string allowed_albedo(const TableView& table);
std::string allowed_depth(const TableView& table);

/// Errors count relative to R or T, but not to less than this share of the largest of a layer.
constexpr double darkest_share = 0.01;

/// The tolerance that a table was baked for; the usual one of a table that does not say.
inline double kept_tolerance(const TableView& table) {
    constexpr double usual = 1e-3;
    return table.tolerance > 0 ? table.tolerance : usual;
}

}  // namespace stratus
