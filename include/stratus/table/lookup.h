// Lookup: closed-form single scattering plus the interpolated higher orders.
//
// Cubic along all five axes. What is interpolated are the samples divided by the albedo, by the
// shares of light that the layer intercepts along both directions (single_scattering.h) and by the
// diffusion scales (diffusion.h); between the deepest finite sample and the one at infinity,
// reflection follows the diffusion law.
//
// Over a lower boundary (lower_boundary.h) reflection is that of both. Single scattering includes
// light that the boundary alone reflected, once, and samples are interpolated as they are: light
// from the boundary vanishes neither with the depth nor with the albedo of the layer.
//
// Outside the table a lookup clamps to its edge: cosines below the first sample, albedo and the
// upper end of optical depth are clamped for the multiply scattered part (single scattering stays
// exact), and so are directions outside a table that was narrowed to some. Below the first optical
// depth the multiply scattered part is what it is divided by, in thin layers tau^2, and the growth of thin
// layers (thin_growth, diffusion.h) times a line in optical depth (ThinLayers, there): from a thinnest
// sample of 0.01 down to depths of 1e-6 it is off by 1 % in the median and 37 % at most (isotropic, Rayleigh,
// Henyey-Greenstein 0.5; cosines from 0.02). Over a surface it is in proportion to what the layer
// extinguishes; over a semi-infinite layer it is clamped. Slices extend a table further, and refuse what it
// does not know (slice.h).
//
// Where a deep sample has fallen out of float's reach (T below 1e-35, or R within 1e-5 of its
// limit), the neighbour of higher albedo, which decays more slowly, is used instead.
//
// Arguments  Not-a-number in any gives not-a-number; every other number out of range counts as the
//            nearest in range, so that R and T are never negative. Cosines below 1e-6 count as that,
//            and an infinite azimuth, which has no nearest, gives not-a-number. So it is in lookups of
//            slices, BSDFs and packed tables too. A library built with STRATUS_CHECKED refuses both
//            instead: it ends the program with a sentence that names argument, range and value.
//
// A table with a mixture axis is looked up through a view of one mixture, `view.at({f})`. The
// up to four samples around it are each looked up as a table of their own and joined by a cubic;
// what is transmitted is divided by how it falls with depth before.
//
// No lookup allocates, throws, or takes a lock; any number of threads may share a table.
#pragma once

#include <stratus/layer/single_scattering.h>
#include <stratus/table/table.h>

namespace stratus {

/// R or T by origin; `total` is what a renderer wants. BRDF or BTDF = total / pi.
struct Scattered {
    double single;
    double multiple;
    double total() const noexcept { return single + multiple; }
};

/// R or diffuse T of the layer at one geometry, by the side. A side that the table does not hold gives
/// its single scattering and multiple = 0. T is 0 over a lower boundary; the unscattered beam is no part
/// of it (`direct_transmittance`).
///
/// Range    albedo [0, 1], optical_depth [0, inf], cosines [0, 1], azimuth finite, radians.
Scattered scattering(const TableView& table, Side side, double albedo, double optical_depth,
                     const Geometry& geometry) noexcept;

/// Estimated error of R or T of a layer thinner than the table's first sample, relative to it, [0, 1]: how far
/// the line by which it is extrapolated is from the parabola through two octaves above; over a surface, from
/// a line in the logarithm of the depth. 1 where a single depth tells neither; 0 between the samples, and over
/// other boundaries, where thinner layers are unknown.
double thin_layer_error(const TableView& table, Side side, double albedo, double optical_depth,
                        const Geometry& geometry) noexcept;

inline Scattered reflection(const TableView& table, double albedo, double optical_depth,
                            const Geometry& geometry) noexcept {
    return scattering(table, Side::reflection, albedo, optical_depth, geometry);
}

inline Scattered transmission(const TableView& table, double albedo, double optical_depth,
                              const Geometry& geometry) noexcept {
    return scattering(table, Side::transmission, albedo, optical_depth, geometry);
}

}  // namespace stratus
