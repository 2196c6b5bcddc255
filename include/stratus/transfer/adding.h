// Adding: one mode of two unlike layers put together.
//
// A layer made of unlike parts looks different from its two sides. With light going down as columns
// of T and up as columns of its transpose (reciprocity), four things hold all of it: R lit from
// above, R* lit from below, T downward, and the beam that passes straight. Scaled matrices as in
// layer.h, over the Gauss nodes followed by the extra directions.
#pragma once

#include <Eigen/Core>

namespace stratus {

/// What a layer of any make does to light in one azimuthal mode.
struct LayerMode {
    Eigen::MatrixXd reflection;        // lit from above; symmetric
    Eigen::MatrixXd reflection_below;  // R*, lit from below; symmetric
    Eigen::MatrixXd transmission;      // diffuse, downward: out of row, into column
    Eigen::VectorXd beam;              // exp(-tau / mu)

    /// Whether nothing passes: a surface, a layer without end. It has reflection alone.
    bool is_opaque() const { return transmission.size() == 0; }
};

/// `above` lying on `below`.
///
/// Source   [HT74], the adding equations.
/// Range    `above` lets light through; both over the same n directions, the first `nodes` of them
///          the Gauss nodes.
/// Errors   std::invalid_argument when the sizes differ or `above` is opaque.
/// Cost     some 10 n^3 operations.
LayerMode add(const LayerMode& above, const LayerMode& below, int nodes);

/// Diffuse light that arrives on `below` for light that falls on `above`, one row an incident
/// direction, summed over the hemisphere with each column of `weights`. Light thrown back and forth
/// between the two is in it, the beam is not: add beam.asDiagonal() * weights.
///
/// With s the scaling of layer.h, weights s give the downward flux times s in mode 0, and s - R s of
/// `below` the net flux, which `below` absorbs where it is opaque.
///
/// Shapes   weights n x any.
/// Errors   as add.
Eigen::MatrixXd diffuse_flux_between(const LayerMode& above, const LayerMode& below,
                                     const Eigen::MatrixXd& weights, int nodes);

}  // namespace stratus
