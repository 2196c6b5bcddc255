// Lookup of the fluxes that a table holds beside R and T (diffuse_transmittance.h).
#pragma once

#include <stratus/table/table.h>

#include <vector>

namespace stratus {

/// t of all orders that a table holds, at each of its samples of mu_in; empty where the table has
/// no diffuse_transmittance.
///
/// Range    as lookups (lookup.h), but deeper than the deepest sample t follows diffusion.
std::vector<double> diffuse_transmittance(const TableView& table, double albedo,
                                          double optical_depth);

}  // namespace stratus
