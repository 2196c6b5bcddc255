// diag(d) + K over all directions: the unscattered beam on a diagonal of its own, never mixed with
// the diffuse light in K. Products sum over the Gauss nodes alone.
#pragma once

#include <Eigen/Core>

namespace stratus {

struct BeamMatrix {
    Eigen::VectorXd d;
    Eigen::MatrixXd K;
};

/// F G; the first `nodes` directions are the Gauss nodes.
BeamMatrix product(const BeamMatrix& F, const BeamMatrix& G, int nodes);

/// F^-1.
BeamMatrix inverse(const BeamMatrix& F, int nodes);

}  // namespace stratus
