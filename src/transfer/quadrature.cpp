#include <stratus/transfer/quadrature.h>

#include <stratus/runtime/argument.h>

#include <boost/math/special_functions/legendre.hpp>

#include <cmath>

namespace stratus {

NodeMap choose_node_map(const std::vector<double>& moments, int nodes) {
    const auto N = static_cast<std::size_t>(nodes);
    const double chi = N < moments.size() ? std::abs(moments[N]) : 0;
    return chi > std::pow(10.0, -nodes / 4.0) ? NodeMap::forward : NodeMap::grazing;
}

Directions gauss_directions(int nodes, NodeMap map, const std::vector<double>& extra) {
    require(nodes >= 1 && nodes <= 512, "gauss_directions", "nodes", "in [1, 512]", nodes);
    for (double mu : extra)
        require(mu >= 1e-100 && mu <= 1, "gauss_directions", "mu", "in [1e-100, 1]", mu);

    const auto extra_count = static_cast<Eigen::Index>(extra.size());
    Directions directions{nodes,
                          Eigen::VectorXd(nodes + extra_count),
                          Eigen::VectorXd::Zero(nodes + extra_count),
                          {}};
    // The non-negative zeros z of P_N, ascending, give x = (1 -+ z)/2; the small x do
    // not suffer from cancellation: 1 - z loses at most the 1e-16 by which z itself is uncertain.
    const std::vector<double> zeros = boost::math::legendre_p_zeros<double>(nodes);
    Eigen::Index low = nodes / 2 - 1, high = nodes / 2;
    for (double z : zeros) {
        const double slope = boost::math::legendre_p_prime(nodes, z);
        const double v = 1 / ((1 - z * z) * slope * slope);  // half the weight on (-1, 1)
        auto place = [&](Eigen::Index at, double x) {
            const bool forward = map == NodeMap::forward;
            directions.mu(at) = forward ? x * x * (2 - x) : x * x * x;
            directions.weight(at) = (forward ? x * (4 - 3 * x) : 3 * x * x) * v;
        };
        if (z == 0) {
            place(high++, 0.5);
            continue;
        }
        place(low--, (1 - z) / 2);
        place(high++, (1 + z) / 2);
    }
    directions.weight.head(nodes) /= directions.weight.head(nodes).sum();
    directions.s.resize(directions.mu.size());
    for (Eigen::Index i = 0; i < directions.mu.size(); ++i) {
        if (i >= nodes) directions.mu(i) = extra[static_cast<std::size_t>(i - nodes)];
        directions.s(i) =
            std::sqrt(2 * directions.mu(i) * (i < nodes ? directions.weight(i) : 1.0));
    }
    return directions;
}

}  // namespace stratus
