// Properties of a layer from its observed brightness: the inversion of [Blinn82] 4.3.
//
// The observed quantity is I/F = mu_in R, or mu_in T for the unlit side. The unknowns are the
// albedos w1 and w2 of two kinds of scattering, w P = w1 P1 + w2 P2, and the optical depth; the
// model is a table with a mixture axis. Levenberg-Marquardt minimises chi-square within the table's
// range, starting from every local minimum of a scan over the optical depth.
#pragma once

#include <stratus/runtime/single_scattering.h>
#include <stratus/runtime/table.h>

#include <string>
#include <vector>

namespace stratus {

struct Observation {
    Geometry geometry;
    Side side;
    double brightness;  // I/F
    double sigma;       // its standard deviation
};

/// A fitted parameter and its standard deviation, from the model linearised at the best fit.
struct Estimate {
    double value, sigma;
};

struct Fit {
    Estimate w1, w2, optical_depth;
    double chi_square;
    int degrees_of_freedom;

    /// Caveats: a parameter that the geometries do not determine, one at the edge of the table,
    /// another layer that fits as well.
    std::vector<std::string> remarks;
};

/// I/F of a layer in the geometry of an observation.
double brightness(const TableView& table, double albedo, double optical_depth,
                  const Observation& observation) noexcept;

/// Fits w1, w2 and the optical depth.
///
/// Range    at least three observations; optical depths up to the largest finite sample.
/// Errors   std::invalid_argument for fewer, for an observation out of range or of a side that is
///          not in the table, and for a table without a mixture axis.
/// Threads  safe; the same bits every time.
Fit fit_layer(const TableView& table, const std::vector<Observation>& observations);

}  // namespace stratus
