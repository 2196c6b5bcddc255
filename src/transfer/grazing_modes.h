// Azimuthal modes of layers with a narrow peak, out of grazing directions or into them.
//
// There light is bent away from the surface before it has gone far: the path law does not hold, and
// modes of high order count, each with all moments of the peak. Three things make them cheap.
//
//   Unresolved peaks: nodes, mu = x^2, crowd at grazing angles and are too far apart elsewhere. What
//   the peak scatters between two nodes stays in its direction (simd/phase_kernels.cpp), so that many
//   more moments are solved than the nodes hold, 4 to a node. Requested directions are nodes of almost
//   no weight then, since they need this as well; each comes twice, so that T into the same direction
//   is that into its copy, without what stays.
//   Few nodes: Y_l^m falls off as sin^m. Mode m takes the nodes with sin^m above 1e-3.
//   Few modes: orders n >= 2 are smooth in m, even and odd m apart. From 48 on, pairs of neighbours are
//   solved whose distance grows with m and with the tolerance; polynomials of degree 7 fill the gaps. At
//   a tolerance of 1e-2 that changes R and T of clouds and HG 0.98 by 6e-4 at most.
#pragma once

#include "climb.h"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace stratus {

/// Modes below `count` that are solved for a tolerance; ascending, the last pair included.
std::vector<int> thinned_modes(int count, double tolerance);

/// Makes a list of all modes up to the last one of a list of some, `solved`, by interpolation.
void fill_modes(std::span<const int> solved, std::vector<Eigen::MatrixXd>& modes);

/// Climbs as climb_harmonic does, all of task.directions included; modes ascend.
void climb_grazing(const ClimbTask& task, std::span<const int> modes, const RecordMode& record);

}  // namespace stratus
