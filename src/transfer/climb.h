// Doubling of all modes of layers of one phase function, recorded at every depth of a ladder; grazing modes of
// narrow peaks by ways of their own.
#pragma once

#include "layer.h"

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace stratus {

/// Layers after truncation.
struct ClimbTask {
    struct Albedo {
        double albedo;
        double co_albedo;
        double first_depth;  // of the first octave
    };
    const Directions& directions;
    const std::vector<double>& moments;
    DepthLadder ladder;  // its first depth is that of each albedo
    std::vector<Albedo> albedos;
    bool between_requested = false;  // modes above 0 of climb_harmonic: R, T and kernels are those
                                     // between requested directions alone
    bool completed = false;  // peaks between nodes stay in their direction (simd/phase_kernels.h)
};

/// Called for each mode of each albedo at each depth of the ladder that is asked for, infinity last,
/// where R + T is the limit of R. Modes ascend. Returns whether deeper layers reflect the same and
/// transmit nothing, as climb_harmonic then has it.
using RecordMode = std::function<bool(int mode, std::size_t albedo, int depth, ModeMatrices layer,
                                      const PhaseKernels& kernels)>;

/// The modes `first` to before `end`.
std::vector<int> modes_between(int first, int end);

/// (mode, albedo) pairs eight at a time or one by one.
void climb_harmonic(const ClimbTask& task, std::span<const int> modes, const RecordMode& record);

/// By textbook doubling (reference/classic.h).
void climb_classic(const ClimbTask& task, const SolverOptions& options, std::span<const int> modes,
                   const RecordMode& record);

/// The sum of orders with the weights of each albedo; up to eight modes. All albedos share a first
/// depth, that of the layers before the share `fraction` was truncated.
void climb_orders(const ClimbTask& task, double fraction,
                  const std::vector<Eigen::VectorXd>& order_weights, std::span<const int> modes,
                  const RecordMode& record);

// Azimuthal modes of layers with a narrow peak, out of grazing directions or into them. There light is
// bent away from the surface before it has gone far: the path law does not hold, and modes of high
// order count, each with all moments of the peak. Three things make them cheap.
//
//   Unresolved peaks: nodes, mu = x^2, crowd at grazing angles and are too far apart elsewhere. What
//   the peak scatters between two nodes stays in its direction (simd/phase_kernels.h), so that many
//   more moments are solved than the nodes hold, 4 to a node. Requested directions are nodes of almost
//   no weight then, since they need this as well; each comes twice, so that T into the same direction
//   is that into its copy, without what stays.
//   Few nodes: Y_l^m falls off as sin^m. Mode m takes the nodes with sin^m above 1e-3.
//   Few modes: orders n >= 2 are smooth in m, even and odd m apart. From 48 on, pairs of neighbours are
//   solved whose distance grows with m and with the tolerance; polynomials of degree 7 fill the gaps. At
//   a tolerance of 1e-2 that changes R and T of clouds and HG 0.98 by 6e-4 at most.

/// Modes below `count` that are solved for a tolerance; ascending, the last pair included.
std::vector<int> thinned_modes(int count, double tolerance);

/// Makes a list of all modes up to the last one of a list of some, `solved`, by interpolation.
void fill_modes(std::span<const int> solved, std::vector<AzimuthalMode>& modes);

/// Climbs as climb_harmonic does, all of task.directions included; modes ascend.
void climb_grazing(const ClimbTask& task, std::span<const int> modes, const RecordMode& record);

}  // namespace stratus
