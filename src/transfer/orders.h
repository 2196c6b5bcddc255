// Scattering orders up to a limit, or one by one: closed forms of the truncated problem in which
// order n is weighted by what the caller asks for.
//
// Truncation mixes the orders: light that meets the peak counts as scattered, though the truncated
// problem takes it for unscattered.
#pragma once

#include <stratus/transfer/forward_peak.h>
#include <stratus/transfer/solution.h>

#include <Eigen/Core>

namespace stratus {

/// 1, w, w^2, ...: the weights of all orders up to `highest`.
Eigen::VectorXd weights_of_orders(double albedo, int highest);

/// sum_n weights(n) f^(n-1) path(n) from order `lowest` on: what truncation makes of single
/// scattering, order by order, per unit of phase function.
double sum_paths(OrderPath path, const LayerSolution& layer, Eigen::Index lowest, double in,
                 double out);

/// exp(-tau*/mu) - exp(-tau/mu), the orders n >= 1 weighted: diffuse light that truncation takes for
/// unscattered.
double truncated_beam(const LayerSolution& layer, double mu);

}  // namespace stratus
