// The path law (path_law.h) of a stack: light near forward that layers of unlike particles scatter,
// one after the other, in place of what their truncated problem holds of it.
//
// Derived here. Let the moments of layer k be chi_l = p_l + c_l, c the series that its truncated
// problem keeps, p the peak that it takes for unscattered light, p_l = f. Light that turns inside
// layer j has crossed slant depths s_k; its peaks widen it to exp(P - S), P = sum w_k p_l,k s_k,
// S = sum s_k. It turns where it is scattered by c or, if by none, by p: at each of its m
// scatterings as likely as at any other, which makes a power series's n-th term 1/m of itself:
//
//     w_j [c_l e^P (e^C - 1)/C + p_l (e^P - 1)/P] e^-S,   C = sum w_k c_l,k s_k
//
// per unit of optical depth and of 1 / (4 mu mu0). Light scattered once, w_j chi_l e^-S, is known
// exactly and taken out. So is what the modes hold, which is the same with p_l = f, less what is
// scattered once by c or only by p: w_j c_l [(e^C - 1)/C - 1] e^(F - S), F = sum w_k f_k s_k. In a
// single layer this is the path law.
#pragma once

#include <stratus/layer/single_scattering.h>
#include <stratus/layer/stack_layers.h>
#include <stratus/transfer/solver_options.h>
#include <stratus/transfer/truncation.h>

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace stratus {

/// How each layer of a stack is truncated, and whether any layer's peak is left to the path law.
struct StackTruncation {
    std::vector<Truncation> layers;
    bool follows_paths = false;

    /// `has_line_law`: backward peaks are left to the line law, which is that of a single layer.
    StackTruncation(const std::vector<StackLayer>& stack, const SolverOptions& options,
                    bool has_line_law);
};

class StackPath {
  public:
    /// Layers as they are, and how each was truncated.
    StackPath(const std::vector<StackLayer>& layers, const std::vector<Truncation>& truncations);

    /// Legendre coefficients, 2l + 1 included, of what is added to the modes and to single
    /// scattering of light that goes up (Side::reflection) or down at the level below the first
    /// `above` layers, between two cosines: below none it is R, below all T. Of infinite depth there
    /// is no T.
    ///
    /// Accuracy 1e-8 of the integral over the depth of the turn.
    std::vector<double> legendre(Side side, std::size_t above, double mu_in, double mu_out) const;

  private:
    /// Adds what light gains that turns inside one layer, over 4 mu_in mu_out. Its slant depth is `before`
    /// in each layer and, in its own, grows by `rate` with the depth.
    void add_turns(Eigen::Index layer, const Eigen::VectorXd& before, double rate,
                   Eigen::VectorXd& sum) const;

    Eigen::VectorXd depth_, truncated_;  // of each layer; truncated: w f
    Eigen::MatrixXd peak_, kept_;  // w p_l and, of the moments that are kept, w c_l; l x layers
    Eigen::VectorXd steepest_;     // of each row and all after it, the largest |w p_l|
    Eigen::Index alike_ = 0;       // rows before it have w p_l = w f in every layer
    double deepest_ = 0;           // slant depth beyond which nothing that turns is added any more
};

}  // namespace stratus
