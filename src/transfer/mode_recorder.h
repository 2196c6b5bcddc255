// Records solved modes: subtracts single scattering, keeps orders n >= 2 and the fluxes of mode 0,
// and decides from which mode on the rest is negligible. Subnormal numbers count as 0 meanwhile.
#pragma once

#include <stratus/transfer/solve.h>

#include "layer_modes.h"
#include "simd/doubling_steps.h"

#include <vector>

#ifdef __SSE2__
#include <immintrin.h>
#endif

namespace stratus {

/// Single scattering between the cosines of a solution, per unit of phase kernel.
using SingleFactors = PerSide<Eigen::MatrixXd>;

class ModeRecorder {
  public:
    /// `layers`: single scattering of each layer, seen from outside. The solution has its cosines
    /// and its lower boundary; `is_symmetric`: its modes are, as those of one layer. `take` may be null.
    ModeRecorder(const Directions& directions, ModeSolution& solution,
                 std::vector<SingleFactors> layers, Beam beam, bool is_symmetric = false,
                 const TakeMode* take = nullptr);

    /// Records the next mode: R and T of the whole, lower boundary included. `kernels` of each
    /// layer; null where that layer scatters nothing into the mode. `boundary`: null where it does not
    /// count by itself.
    void record(const LayerMode& all, const std::vector<const PhaseKernels*>& kernels,
                BoundaryModes* boundary);

    /// Mode 0: the flux that reaches the lower boundary through `above`.
    void record_boundary(const LayerMode& above, BoundaryModes& boundary);

    /// Mode 0: diffuse light that falls on the lower boundary, summed with `weights`, and the beam:
    /// column 0 is the net flux, column 1 what falls.
    void record_fluxes_below(const Eigen::MatrixXd& diffuse, const Eigen::MatrixXd& weights);

    /// True when the last `count` modes add less than this share anywhere.
    bool is_negligible(int count, double tolerance) const;

    /// exp(-tau*/mu) along all directions.
    const Eigen::VectorXd& beam() const { return beam_.unscattered; }

  private:
    void record_fluxes(const LayerMode& all);

    /// Diffuse light that falls on a Lambert surface, along all directions of incidence.
    Eigen::VectorXd flux_over_surface(const LayerMode& above, double albedo) const;
    Eigen::MatrixXd unscaled(const Eigen::MatrixXd& matrix) const;

    const Directions& directions_;
    ModeSolution& solution_;
    Eigen::VectorXd unscale_;  // 1 / s at its cosines
    std::vector<SingleFactors> layers_;
    Beam beam_;
    bool is_symmetric_;
    const TakeMode* take_;
    int recorded_ = 0;  // modes
};

/// Solves modes [first, end) group by group with solve(first, end), until one but the first is
/// negligible(count): a group of two covers both parities of l - m before stopping.
template <class Solve, class IsNegligible>
void solve_groups(int modes, int group, bool may_stop, Solve solve, IsNegligible is_negligible) {
    for (int first = 0; first < modes; first += group) {
        const int end = first + group < modes ? first + group : modes;
        solve(first, end);
        if (may_stop && first > 0 && is_negligible(end - first)) return;
    }
}

// Numbers below 2.2e-308 taken as 0 while a solution is made.
//
// Modes of high order fall off as sin^m towards the normal. Their matrices are full of subnormal
// numbers there, which processors handle a hundred times more slowly and no result contains.

/// In this thread, until the end of its life; not for depths so small or large that R or T is subnormal.
class FlushSubnormals {
  public:
#ifdef __SSE2__
    explicit FlushSubnormals(double depth) : before_(_mm_getcsr()) {
        constexpr unsigned flush_to_zero = 1u << 15, denormals_are_zero = 1u << 6;
        if (depth > 1e-150 && depth < 1e150)
            _mm_setcsr(before_ | flush_to_zero | denormals_are_zero);
    }
    ~FlushSubnormals() { _mm_setcsr(before_); }
    FlushSubnormals(const FlushSubnormals&) = delete;
    FlushSubnormals& operator=(const FlushSubnormals&) = delete;

  private:
    const unsigned before_;
#else
    explicit FlushSubnormals(double) {}  // not trivial: no compiler calls it unused
#endif
};

}  // namespace stratus
