// Closed forms along paths: straight back and forth in one layer, then through the layers of a stack.
//
// The line law: what a narrow backward peak scatters more than once, in closed form.
//
// Derived here. Light that is scattered straight back, again and again, runs to and fro along one
// line. Each Legendre moment of its directions by itself obeys a two-stream equation in optical
// depth t along a line of cosine mu, with b = w (-1)^l chi_l,
//
//     mu dD/dt = -D + b U      -mu dU/dt = -U + b D      k = sqrt(1 - b^2)   r = b / (1 + k)
//
// D downward, U upward. Lit from above, with K = k tau / mu,
//
//     D(t) = (e^(-k t/mu) - r^2 e^(k t/mu - 2 K)) / (1 - r^2 e^(-2 K))
//     U(t) = r (e^(-k t/mu) - e^(k t/mu - 2 K)) / (1 - r^2 e^(-2 K))
//
// Between two cosines light turns from one line (0) to another (1) at any of its n scatterings, at
// each as likely as at any other, as in path_law.h. The n-th term of a power series in b becomes
// 1/n of itself by integration:
//
//     R_l = (-1)^l / (4 mu mu0)  int_0^b db int_0^tau dt [D0(t) D1(t) + U0(t) U1(t)]
//     T_l =      1 / (4 mu mu0)  int_0^b db int_0^tau dt [D0(t) U1(tau - t) + U0(t) D1(tau - t)]
//
// Odd orders leave in R, even ones in T; order 1 is single scattering, exact. Nodes hold a series
// that ends smoothly (truncation.h), with moments c_l: orders n >= 2 are its modes, and the law of
// chi_l less that of c_l.
#pragma once

#include <stratus/layer/stack_layers.h>
#include <stratus/transfer/solver_options.h>
#include <stratus/transfer/truncation.h>

namespace stratus {

class BackwardPath {
  public:
    /// All moments of a phase function as far as they matter, and those that the nodes hold.
    BackwardPath(std::vector<double> moments, std::vector<double> kept);

    /// Legendre coefficients, 2l + 1 included, of what is added to the modes and to single
    /// scattering of R (T). Of infinite depth there is no T.
    ///
    /// Accuracy 1e-9 of the largest coefficient.
    std::vector<double> legendre(Side side, double albedo, double optical_depth, double mu_in,
                                 double mu_out) const;

  private:
    std::vector<double> back_, kept_;  // (-1)^l chi_l and (-1)^l c_l
    std::size_t first_ = 0;            // l from which on they differ
    double largest_ = 0;               // of |back_| from there on
};

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

/// How each layer of a stack is truncated, and whether any layer's peak is left to the path law.
struct StackTruncation {
    std::vector<Truncation> layers;
    bool follows_paths = false;

    /// `has_line_law`: backward peaks are left to the line law, which is that of a single layer.
    StackTruncation(const StackLayers& stack, const SolverOptions& options, bool has_line_law);
};

class StackPath {
  public:
    /// Layers as they are, and how each was truncated.
    StackPath(const StackLayers& layers, const std::vector<Truncation>& truncations);

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
