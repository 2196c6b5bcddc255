// Layers as matrices, then the depth to which each is doubled.
//
// One azimuthal mode of a layer as matrices: their conventions, and two layers added to one.
//
// R_ij = s_i s_j R_m(mu_i, mu_j), s_i = sqrt(2 mu_i weight_i) (weight 1 for directions of weight
// zero), and the same for T. Reciprocity is matrix symmetry, a matrix product over the Gauss nodes
// is an integral over the hemisphere. T is the diffuse part; the unscattered beam,
// exp(-tau / mu), is kept apart as a diagonal.
#pragma once

#include <stratus/base/direction.h>
#include <stratus/transfer/quadrature.h>
#include <stratus/transfer/solver_options.h>

#include <Eigen/Core>

#include <vector>

namespace stratus {

struct AzimuthalMode;  // solve.h

/// One azimuthal mode of a homogeneous layer: n x n, n = directions.size(); T is diffuse.
using ModeMatrices = PerSide<Eigen::MatrixXd>;

/// The mode's phase kernels between all directions, unscaled: P+ into the same hemisphere, which is
/// `transmission`, and P- into the other.
using PhaseKernels = PerSide<Eigen::MatrixXd>;

/// exp(-tau / mu) along directions of these cosines.
Eigen::VectorXd beam_along(const Eigen::VectorXd& mu, double optical_depth);

/// Fourier series at an azimuth in radians: f_0 + 2 sum f_m cos(m azimuth), f_m = modes[m](i, j).
double sum_modes(const std::vector<AzimuthalMode>& modes, int i, int j, double azimuth);

// Adding. An inhomogeneous layer differs between its two sides. Four quantities describe it: R lit
// from above, R* lit from below, T downward (its transpose is T upward, by reciprocity), and the
// unscattered beam. Matrices are over the Gauss nodes followed by the extra directions.

/// diag(d) + K over all directions: the unscattered beam on a diagonal of its own, never mixed with
/// the diffuse light in K. Products sum over the Gauss nodes alone.
struct BeamMatrix {
    Eigen::VectorXd d;
    Eigen::MatrixXd K;
};

/// F G; the first `nodes` directions are the Gauss nodes.
BeamMatrix product(const BeamMatrix& F, const BeamMatrix& G, int nodes);

/// F^-1.
BeamMatrix inverse(const BeamMatrix& F, int nodes);

/// One azimuthal mode of a layer, homogeneous or not.
struct LayerMode {
    Eigen::MatrixXd reflection;          // lit from above; symmetric
    Eigen::MatrixXd reflection_below{};  // R*, lit from below; symmetric
    Eigen::MatrixXd transmission{};      // diffuse, downward: out of row, into column
    Eigen::VectorXd beam{};              // exp(-tau / mu)
    /// s at the nodes in mode 0 of a layer that absorbs nothing: s^T (R + T + beam) = s^T. Else empty.
    Eigen::VectorXd conserved{};

    bool is_conservative() const { return conserved.size() > 0; }

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
/// With s the scaling of the matrices, weights s give the downward flux times s in mode 0, and s - R s
/// of `below` the net flux, which `below` absorbs where it is opaque.
///
/// Shapes   weights n x any.
/// Errors   as add.
Eigen::MatrixXd diffuse_flux_between(const LayerMode& above, const LayerMode& below,
                                     const Eigen::MatrixXd& weights, int nodes);

// How the layer of a given depth follows from doubling: thin | solved | conservative | infinite.

/// In a layer this thin second-order scattering is below rounding, while single scattering is still
/// a normal number.
constexpr double thinnest_depth = 1e-280;

enum class DepthRegime {
    thin,          // below thinnest_depth: R and T in proportion to the depth
    solved,        // doubled to the depth itself
    conservative,  // beyond 2^12 / (1 - g) at w = 1: T by the law of diffusion
    infinite,      // doubled until T vanishes
};

struct DepthTarget {
    double optical_depth;
    DepthRegime regime = DepthRegime::solved;
    double doubled_depth = optical_depth;  // where doubling ends
};

/// The regime of a depth in [0, inf], for a layer that is conservative or not.
DepthTarget choose_target(double optical_depth, bool conservative, double asymmetry);

/// The ladder to double through; its last depth becomes the target (reach). Two depths where
/// conservative, the first of them half the second.
DepthLadder ladder_to(const DepthTarget& target);

/// R and T of a mode at the target, from those at the end of its ladder. T is empty at infinite
/// depth. `half_transmittance`: uniform_mean one depth earlier, where conservative.
ModeMatrices reach(const DepthTarget& target, int mode, double half_transmittance,
                   const Directions& directions, ModeMatrices layer);

/// Reflectance or diffuse transmittance under uniform illumination, from R or T of mode 0.
double uniform_mean(const Directions& directions, const Eigen::MatrixXd& mode);

/// Doublings to `optical_depth` from a thin start, exact to rounding along all cosines from the
/// smallest on.
int count_doublings(double smallest_cosine, double optical_depth);

/// Where doubling to infinity alone begins, a depth like any other.
constexpr double first_depth_to_infinity = 1;

}  // namespace stratus
