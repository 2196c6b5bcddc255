// Adding: one mode of two different layers combined.
//
// An inhomogeneous layer differs between its two sides. Four quantities describe it: R lit from
// above, R* lit from below, T downward (its transpose is T upward, by reciprocity), and the
// unscattered beam. Scaled matrices as in layer.h, over the Gauss nodes followed by the extra
// directions.
#pragma once

#include <Eigen/Core>

namespace stratus {

/// One azimuthal mode of a layer, homogeneous or not.
struct LayerMode {
    Eigen::MatrixXd reflection;        // lit from above; symmetric
    Eigen::MatrixXd reflection_below;  // R*, lit from below; symmetric
    Eigen::MatrixXd transmission;      // diffuse, downward: out of row, into column
    Eigen::VectorXd beam;              // exp(-tau / mu)

    /// Whether nothing is transmitted: a surface or a semi-infinite layer. It has reflection alone.
    bool is_opaque() const { return transmission.size() == 0; }
};

/// `above` on top of `below`.
///
/// Source   [HT74], the adding equations.
/// Range    `above` transmits light; both over the same n directions, the first `nodes` of them
///          the Gauss nodes.
/// Errors   std::invalid_argument when the sizes differ or `above` is opaque.
/// Cost     some 10 n^3 operations.
LayerMode add(const LayerMode& above, const LayerMode& below, int nodes);

/// Diffuse light between two layers lit from above, interreflection included: going down, and up;
/// scaled, out of row, into column.
struct LightBetween {
    Eigen::MatrixXd downward, upward;
};

/// The light between `above` and `below`.
///
/// Source   [HT74], D and U of the adding equations.
/// Errors   as add.
LightBetween light_between(const LayerMode& above, const LayerMode& below, int nodes);

/// Diffuse light incident on `below` for light incident on `above`, one row per incident direction,
/// summed over the hemisphere with each column of `weights`. Interreflection between the two is
/// included, the beam is not: add beam.asDiagonal() * weights.
///
/// With s the scaling of layer.h, weights s give the downward flux times s in mode 0, and s - R s
/// of `below` the net flux, which `below` absorbs where it is opaque.
///
/// Shapes   weights n x any.
/// Errors   as add.
Eigen::MatrixXd diffuse_flux_between(const LayerMode& above, const LayerMode& below,
                                     const Eigen::MatrixXd& weights, int nodes);

}  // namespace stratus
