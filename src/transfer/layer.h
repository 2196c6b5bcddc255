// One azimuthal mode of a layer as matrices, and their conventions.
//
// R_ij = s_i s_j R_m(mu_i, mu_j), s_i = sqrt(2 mu_i weight_i) (weight 1 for directions of weight
// zero), and the same for T. Reciprocity is matrix symmetry, a matrix product over the Gauss nodes
// is an integral over the hemisphere. T is the diffuse part; the unscattered beam,
// exp(-tau / mu), is kept apart as a diagonal.
#pragma once

#include <stratus/transfer/quadrature.h>

#include <Eigen/Core>

#include <vector>

namespace stratus {

/// One azimuthal mode of a homogeneous layer.
struct ModeMatrices {
    Eigen::MatrixXd reflection;    // n x n, n = directions.size()
    Eigen::MatrixXd transmission;  // n x n, diffuse
};

/// The mode's phase kernels between all directions: P+ into the same hemisphere, P- into the other;
/// unscaled.
struct PhaseKernels {
    Eigen::MatrixXd same;
    Eigen::MatrixXd other;
};

/// exp(-tau / mu) along all directions.
Eigen::VectorXd beam_along(const Directions& directions, double optical_depth);

/// Fourier series at an azimuth in radians: f_0 + 2 sum f_m cos(m azimuth), of all f_m, or of
/// f_m = modes[m](i, j).
double sum_modes(const std::vector<double>& modes, double azimuth);
double sum_modes(const std::vector<Eigen::MatrixXd>& modes, int i, int j, double azimuth);

}  // namespace stratus
