// R and T of solved layers at all pairs of their cosines and a list of azimuths.
//
// One value is the sum of four parts: the Fourier series of orders n >= 2, the correction for the
// truncated peak (PeakCorrection), that for the lower boundary, and single scattering in closed
// form. Everything that does not depend on depth and albedo is tabulated once and serves all
// solutions.
//
// Tables of a narrow peak leave the path law (path_law.h) to the lookup: what it knows in closed
// form is then single scattering and the path law, what is tabulated is their rest.
#pragma once

#include <stratus/base/size.h>
#include <stratus/layer/lower_boundary.h>
#include <stratus/layer/single_scattering.h>
#include <stratus/phase/path_law.h>
#include <stratus/phase/phase_function.h>
#include <stratus/transfer/solve.h>

#include <Eigen/Core>

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace stratus {

/// Which cosines of a solution are paired: positions among them, every one of `in` with every one
/// of `out`.
struct CosinePairs {
    std::vector<int> in, out;
    bool exchangeable = true;  // false where values are not symmetric in them: of stacks

    /// All with all: values are then symmetric, and half of them are computed.
    bool are_symmetric() const { return exchangeable && in == out; }
};

/// Pairs of the cosines of solutions, and azimuths, with the quantities that solutions share.
class DirectionGrid {
  public:
    /// `max_modes`: as many as any solution has; 2 SolverOptions::nodes always suffice.
    /// `path_law`: null where nothing of it is left to lookups.
    /// `pairs`: none given stands for all with all.
    DirectionGrid(const PhaseFunction& phase_function, const LowerBoundary& boundary,
                  std::vector<double> mu, std::vector<double> azimuth, int max_modes,
                  std::shared_ptr<const PathOrders> path_law = {}, CosinePairs pairs = {});

    /// Returns the cosines of the solutions.
    const std::vector<double>& mu() const { return mu_; }
    const CosinePairs& pairs() const { return pairs_; }
    const std::vector<double>& azimuth() const { return azimuth_; }

    int in_count() const { return int_size(pairs_.in); }
    int out_count() const { return int_size(pairs_.out); }
    double mu_in(int in) const { return cosine(pairs_.in, in); }
    double mu_out(int out) const { return cosine(pairs_.out, out); }

    std::size_t size() const { return pairs_.in.size() * pairs_.out.size() * azimuth_.size(); }
    /// Position of (mu_in, mu_out, azimuth) in all values over a grid.
    std::size_t at(int in, int out, int azimuth) const {
        return (stratus::size(in) * pairs_.out.size() + stratus::size(out)) * azimuth_.size() +
               stratus::size(azimuth);
    }

    /// cos(m azimuth) with the factor 2 of m > 0; azimuths x max_modes.
    const Eigen::MatrixXd& cosines() const { return cosines_; }
    /// Over the grid: cos Theta, and the phase function there.
    const std::vector<double>& cos_scattering_angle(Side side) const {
        return cos_scattering_angle_[side];
    }
    const std::vector<double>& phase(Side side) const { return phase_[side]; }
    /// Phase value of the lower boundary, 1 for a surface.
    const std::vector<double>& boundary_phase() const { return boundary_phase_; }
    const PathOrders* path_law() const { return path_law_.get(); }

  private:
    double cosine(const std::vector<int>& places, int n) const {
        return mu_[stratus::size(places[stratus::size(n)])];
    }

    std::vector<double> mu_;
    CosinePairs pairs_;
    std::vector<double> azimuth_;
    Eigen::MatrixXd cosines_;
    PerSide<std::vector<double>> cos_scattering_angle_, phase_;
    std::vector<double> boundary_phase_;
    std::shared_ptr<const PathOrders> path_law_;
};

/// R or T over a DirectionGrid; the sum is the total.
struct GridValues {
    std::vector<double> closed_form;  // single scattering; with a path law that, too
    std::vector<double> tabulated;    // the rest of all orders
};

/// R (T) of a solution at every direction of the grid, symmetric in the two cosines where the pairs
/// are. T over a lower boundary is 0. The grid's path law counts as closed form. Solutions of
/// stacks bring phase functions of their own.
///
/// Range    the phase function and boundary of the grid are those of the solution, and so are its
///          cosines, in the same order.
/// Errors   std::invalid_argument when the cosines differ in number or the solution has more modes.
GridValues evaluate(const LayerSolution& solution, Side side, const DirectionGrid& grid);

/// Returns the part of `evaluate` that tables store, without the closed form.
std::vector<double> evaluate_tabulated(const LayerSolution& solution, Side side,
                                       const DirectionGrid& grid);

struct SketchedPair;  // fourier_sum.cpp

/// Some positions of a grid, ascending, for solutions that differ in albedo and depth, not in phase
/// function, lower boundary and options.
class GridPositions {
  public:
    /// `grid` outlives this.
    GridPositions(const DirectionGrid& grid, Side side, const std::vector<std::size_t>& positions);
    ~GridPositions();

    /// Adds the next mode to a solution's `series` at these positions: for a TakeMode.
    void add_mode(ModeSolution& solution, int number, const AzimuthalMode& mode) const;

    /// Evaluates what some solutions leave to tables at these positions alone: a list of values for each
    /// solution, whose modes were all taken by `add_mode`, or which is that of a stack.
    ///
    /// Cost     that of the pairs of cosines among the positions; all positions are faster at once.
    std::vector<std::vector<double>> evaluate_tabulated(
        const std::vector<const LayerSolution*>& solutions) const;

  private:
    const DirectionGrid& grid_;
    Side side_;
    std::size_t count_;
    std::vector<SketchedPair> pairs_;
    mutable std::once_flag has_rest_;
    mutable std::vector<Eigen::MatrixXd> rest_;  // of a path law's orders, at each pair
};

}  // namespace stratus
