// Textbook doubling of one mode, kept as a reference solver, and the reference solvers' phase kernels.
//
// Its start, its doubling and the kernels are independent of the solver's on purpose, so that
// comparing it or the Markov chain with the solver also checks simd/phase_kernels.h. Nodes, truncation, single scattering and the sum over modes are shared with the solver and not checked.
#pragma once

#include "../layer.h"

namespace stratus {

/// Mode kernels by the addition theorem, mode 0 rescaled to conserve energy.
PhaseKernels reference_phase_kernels(const Directions& directions,
                                     const std::vector<double>& moments, int mode);

/// A layer doubled by  R' = R + T (I - R R)^-1 R T,  T' = T (I - R R)^-1 T.  [HT74]
///
/// Starts at `thin_depth` from the diamond rule [W76],
///
///     R + T = (I + h B)^-1 (I - h B)      R - T = (I + (h A)^-1)^-1 (I - (h A)^-1)
///
/// with h = tau/2, A and B as in simd/doubling.cpp, or from single scattering in closed form. The
/// beam is part of T's matrices, on a diagonal of its own.
class ClassicLayer {
  public:
    ClassicLayer(const Directions& directions, const PhaseKernels& kernels, int mode, double albedo,
                 double thin_depth, ClassicStart start);

    /// Errors   std::runtime_error when the layer is no longer finite.
    void double_depth();

    /// Conservative layers approach their limit as 1/tau and are doubled as far as rounding allows.
    void double_to_infinity();

    const ModeMatrices& matrices() const { return layer_; }

  private:
    void start_diamond(const PhaseKernels& kernels, double albedo);
    void start_single(const PhaseKernels& kernels, double albedo);

    const Directions& directions_;
    int mode_;
    double optical_depth_;
    ModeMatrices layer_;
};

/// Doublings from a layer no thicker than `start_depth`; 0: than 1e-3 of the smallest node's
/// cosine, where the diamond rule (error of order (tau / mu)^2) is good to 1e-6.
int count_classic_doublings(const Directions& directions, double optical_depth, double start_depth);

}  // namespace stratus
