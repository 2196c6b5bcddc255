// What a layer is made of, from how bright it was seen to be: the inversion of [Blinn82] 4.3.
//
// Observed is I/F = mu_in R, or mu_in T where the layer is seen from the side that is not lit. What
// is sought are the albedos w1 and w2 of two kinds of scattering, w P = w1 P1 + w2 P2, and the
// optical depth; the model is a table with a mixture axis. Levenberg-Marquardt goes downhill within
// the table's range from several starts: the depths that fit better than those beside them.
#pragma once

#include <stratus/runtime/single_scattering.h>
#include <stratus/runtime/table.h>

#include <string>
#include <vector>

namespace stratus {

struct Observation {
    Geometry geometry;
    bool transmitted;   // seen from the side that is not lit
    double brightness;  // I/F
    double sigma;       // its standard deviation
};

/// A number sought, and its standard deviation: that of the model made linear where it fits best.
struct Estimate {
    double value, sigma;
};

struct Fit {
    Estimate w1, w2, optical_depth;
    double chi_square;
    int degrees_of_freedom;

    /// What a reader of the numbers must know, a sentence each: a parameter that the geometries do
    /// not determine, one at the edge of the table, another layer that fits as well.
    std::vector<std::string> remarks;
};

/// I/F of a layer, as an observer would see it.
double brightness(const TableView& table, double albedo, double optical_depth,
                  const Observation& observation) noexcept;

/// Fits w1, w2 and the optical depth.
///
/// Range    three observations at least; optical depths up to the deepest finite sample.
/// Errors   std::invalid_argument for fewer, for an observation out of range or of a side that the
///          table does not hold, and for a table without a mixture axis.
/// Threads  safe; the same bits every time.
Fit fit_layer(const TableView& table, const std::vector<Observation>& observations);

}  // namespace stratus
