// Scattering orders up to a limit, or one by one: closed forms of the truncated problem with a
// caller's weight on each order n.
//
// Truncation mixes the orders: light scattered into the peak counts as scattered, though the
// truncated problem treats it as unscattered.
//
// Orders of stacks: every matrix of a layer is a power series in its albedo (ordered_ladder.h); with
// z^n in place of the albedo's powers, z R_1 + z^2 R_2 + ... of layers that differ are added as their
// sums are [HT74], products being Cauchy products. A reflection by a Lambert surface counts as one
// scattering. No peak is truncated: orders would mix.
#pragma once

#include <stratus/transfer/stack.h>

namespace stratus {

/// 1, w, w^2, ...: the weights of all orders up to `highest`.
Eigen::VectorXd weights_of_orders(double albedo, int highest);

/// The weights of each order from 1 on by itself: all others are 0.
std::vector<Eigen::VectorXd> weights_of_each_order(double albedo, int highest);

/// sum_n weights(n) f^(n-1) n times path_weights of order n, from order `lowest` on: single
/// scattering of the truncated problem, order by order, per unit of phase function.
double sum_paths(Side side, const LayerSolution& layer, int lowest, double in, double out);

/// exp(-tau*/mu) - exp(-tau/mu) with orders n >= 1 weighted: diffuse light that truncation treats
/// as unscattered.
double truncated_beam(const LayerSolution& layer, double mu);

/// Orders of a stack: 0, the beam alone, to options.orders. Arguments have been checked; neighbours differ.
std::vector<StackSolution> solve_stack_orders(const StackLayers& layers,
                                              const LowerBoundary& boundary,
                                              const std::vector<double>& mu,
                                              const SolverOptions& options);

}  // namespace stratus
