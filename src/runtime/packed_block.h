// A block of a textured table as its lookups read it (kernels/textured.h): functions of the
// directions as halves, finer along the cosines, and their coefficients.
#pragma once

#include <stratus/runtime/axis.h>

#include "kernels/textured.h"
#include "layer_basis.h"
#include "layer_shapes.h"

#include <algorithm>
#include <vector>

namespace stratus {

/// Samples of an axis of coefficients, never fewer than a cubic needs: short axes are sampled again
/// on the polynomial through all they have.
struct Resampling {
    int from, to;

    explicit Resampling(int count) : from(count), to(std::max(stencil_size, count)) {}

    double weight(int old_sample, int new_sample) const;
    TexturedAxis axis(const AxisView& view) const;
};

struct PackedBlock {
    std::vector<FunctionRow> function;
    std::vector<CoefficientRow> coefficient;
    int first_in[segments + 1], first_out[segments + 1];  // places (kernels/textured.h)
    int columns;                                          // of functions over mu_out
    int depths;                                           // of the coefficients, infinity included
};

/// Range    tolerance: that of the table.
PackedBlock packed_block(const LayerShapes& samples, const BlockLayers& layers,
                         const LayerBasis& basis, double tolerance);

}  // namespace stratus
