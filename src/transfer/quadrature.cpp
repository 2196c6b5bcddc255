#include <stratus/transfer/quadrature.h>

#include <stratus/base/number_text.h>

#include <boost/math/special_functions/legendre.hpp>

#include <cmath>
#include <mutex>

namespace stratus {

NodeMap choose_node_map(const std::vector<double>& moments, int nodes) {
    const auto N = size(nodes);
    const double chi = N < moments.size() ? std::abs(moments[N]) : 0;
    return chi > std::pow(10.0, -nodes / 4.0) ? NodeMap::forward : NodeMap::grazing;
}

namespace {

struct MappedNode {
    double mu, slope;
};

MappedNode mapped(double x, NodeMap map) {
    switch (map) {
        case NodeMap::forward: return {x * x * (2 - x), x * (4 - 3 * x)};
        case NodeMap::square: return {x * x, 2 * x};
        case NodeMap::grazing: break;
    }
    return {x * x * x, 3 * x * x};
}

Directions compute_gauss_nodes(int nodes, NodeMap map) {
    Directions directions{nodes, Eigen::VectorXd(nodes), Eigen::VectorXd(nodes), {}};
    // The non-negative zeros z of P_N, ascending, give x = (1 -+ z)/2; the small x do
    // not suffer from cancellation: 1 - z loses at most the 1e-16 by which z itself is uncertain.
    const std::vector<double> zeros = boost::math::legendre_p_zeros<double>(nodes);
    Eigen::Index low = nodes / 2 - 1, high = nodes / 2;
    for (double z : zeros) {
        const double slope = boost::math::legendre_p_prime(nodes, z);
        const double v = 1 / ((1 - z * z) * slope * slope);  // half the weight on (-1, 1)
        auto place = [&](Eigen::Index at, double x) {
            const auto [mu, slope] = mapped(x, map);
            directions.mu(at) = mu;
            directions.weight(at) = slope * v;
        };
        if (z == 0) {
            place(high++, 0.5);
            continue;
        }
        place(low--, (1 - z) / 2);
        place(high++, (1 + z) / 2);
    }
    directions.weight /= directions.weight.sum();
    directions.s = (2 * directions.mu.array() * directions.weight.array()).sqrt();
    return directions;
}

constexpr int max_nodes = 512;

/// Computed once for each count and map, by whichever thread asks first.
const Directions& gauss_nodes(int nodes, NodeMap map) {
    struct Kept {
        std::once_flag computed;
        Directions directions;
    };
    static Kept kept[3][max_nodes];
    Kept& of = kept[static_cast<int>(map)][nodes - 1];
    std::call_once(of.computed, [&] { of.directions = compute_gauss_nodes(nodes, map); });
    return of.directions;
}

}  // namespace

Directions gauss_directions(int nodes, NodeMap map, const std::vector<double>& extra) {
    require_in("[1, 512]", "gauss_directions", "nodes", nodes);
    const NumberRange cosines = "[1e-100, 1]";
    for (double mu : extra) require_in(cosines, "gauss_directions", "mu", mu);

    Directions directions = gauss_nodes(nodes, map);
    const auto size = nodes + std::ssize(extra);
    for (Eigen::VectorXd* vector : {&directions.mu, &directions.weight, &directions.s})
        vector->conservativeResize(size);
    for (Eigen::Index i = nodes; i < size; ++i) {
        directions.mu(i) = extra[static_cast<std::size_t>(i - nodes)];
        directions.weight(i) = 0;
        directions.s(i) = std::sqrt(2 * directions.mu(i));
    }
    return directions;
}

}  // namespace stratus
