// Directions of the solver: Gauss nodes, followed by the requested directions.
//
// With x_i, v_i the Gauss-Legendre nodes and weights on (0, 1), mu_i = mu(x_i) and weight_i =
// mu'(x_i) v_i. Multiply scattered light has a logarithm in mu at grazing angles, so mu(x) starts
// as a power of x; which one is chosen by what limits the accuracy, thin layers (fine structure at
// grazing angles) or the forward peak (fine structure near mu = 1). The requested directions are
// extra nodes of weight zero: they do not change the quadrature, and R and T at exactly those
// directions have its accuracy.
#pragma once

#include <stratus/base/size.h>

#include <Eigen/Core>

#include <vector>

namespace stratus {

enum class NodeMap {
    grazing,  // mu = x^3: nodes crowd towards grazing angles
    forward,  // mu = x^2 (2 - x): spacing halved near mu = 1
    square,   // mu = x^2: for narrow peaks at grazing angles (src/transfer/climb.h)
};

/// The map for a phase function: `forward` when its moments fall off so slowly that chi_N >
/// 10^(-N/4), the error that thin layers leave with N nodes; `grazing` otherwise.
///
/// Accuracy against independent references, worst over R and T at depths 0.01 to 1024, mu, mu0 in
///          [0.02, 1]: 24 nodes, isotropic to double HG 0.5: 7e-9 (x^2 alone: 3e-8); HG 0.75: 9e-7
///          (3e-5); 48 nodes, HG 0.85: 2e-8 (1e-5).
NodeMap choose_node_map(const std::vector<double>& moments, int nodes);

/// Cosines of all directions, the `nodes` Gauss nodes first (ascending), then the extra ones as
/// given.
struct Directions {
    int nodes;
    Eigen::VectorXd mu;
    Eigen::VectorXd weight;  // sums to 1 over the Gauss nodes; 0 for the extra directions
    Eigen::VectorXd
        s;  // sqrt(2 mu weight), with weight 1 for the extra directions: the scaling of layer.h

    int size() const { return int_size(mu); }
};

/// Range    nodes [1, 512]; every extra cosine in [1e-100, 1].
/// Errors   std::invalid_argument naming the range and the value met.
Directions gauss_directions(int nodes, NodeMap map, const std::vector<double>& extra = {});

}  // namespace stratus
