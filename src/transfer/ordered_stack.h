// Neumann orders of stacks: layers and their lower boundary added order by order.
//
// Every matrix of a layer is a power series in its albedo (ordered_ladder.h); with z^n in place of
// the albedo's powers, z R_1 + z^2 R_2 + ... of layers that differ are added as their sums are
// [HT74], products being Cauchy products. A reflection by a Lambert surface counts as one
// scattering. No peak is truncated: orders would mix.
#pragma once

#include <stratus/transfer/stack.h>

#include <vector>

namespace stratus {

/// Orders 0, the beam alone, to options.orders. Arguments have been checked; neighbours differ.
std::vector<StackSolution> solve_stack_orders(const std::vector<StackLayer>& layers,
                                              const LowerBoundary& boundary,
                                              const std::vector<double>& mu,
                                              const SolverOptions& options);

}  // namespace stratus
