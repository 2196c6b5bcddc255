// Neumann orders one by one.
#include <stratus/base/constants.h>
#include <stratus/transfer/solve.h>
#include <stratus/transfer/stack.h>

#include "refusal.h"
#include "usual_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace stratus {
namespace {

const std::vector<double> order_cosines{1e-4, 0.02, 0.3, 0.8, 1};
const std::vector<double> order_azimuths{0, 1.1, 3.14};

SolverOptions up_to_order(int nodes, int orders) {
    SolverOptions options = with_nodes(nodes);
    options.orders = orders;
    return options;
}

/// Order n times the n-th power of a factor.
template <class Solution>
Eigen::ArrayXd sum_of(const std::vector<Solution>& orders, double factor = 1,
                      const std::vector<double>& at = order_azimuths) {
    Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(all_values(orders[0], at).size());
    double share = 1;
    for (const Solution& order : orders) sum += (share *= factor) * all_values(order, at);
    return sum;
}

struct Case {
    const char* phase;
    int nodes;
    double albedo, optical_depth;
    int orders;  // enough for an error below 1e-12
};

class NeumannOrders : public testing::TestWithParam<Case> {};

TEST_P(NeumannOrders, SumToTheLayer) {
    const Case& of = GetParam();
    const PhaseFunction phase_function = parse_phase_function(of.phase);
    const Eigen::ArrayXd expected =
        all_values(solve_layer(phase_function, of.albedo, of.optical_depth, order_cosines,
                               with_nodes(of.nodes)),
                   order_azimuths);
    const std::vector<LayerSolution> orders =
        solve_orders(phase_function, of.albedo, of.optical_depth, order_cosines,
                     up_to_order(of.nodes, of.orders));
    ASSERT_EQ(std::ssize(orders), of.orders);
    Eigen::ArrayXd tolerance = 1e-10 * expected;
    // Matrices carry R and T times 2 sqrt(mu mu0): rounding beside the beam. Of either side there are
    // 25 pairs of cosines at 3 azimuths.
    for (std::size_t k = 0; k < 150; ++k)
        tolerance(static_cast<Eigen::Index>(k)) +=
            1e-16 / std::sqrt(order_cosines[k / 15 % 5] * order_cosines[k / 3 % 5]);
    tolerance.tail(10) = 1e-10;  // of fluxes
    expect_near(sum_of(orders), expected, tolerance);
}

INSTANTIATE_TEST_SUITE_P(Layer, NeumannOrders,
                         testing::ValuesIn<Case>({{"isotropic", 16, 0.9, 1, 60},
                                                  {"isotropic", 16, 0.3, infinity, 30},
                                                  {"isotropic", 8, 1, 0.5, 50},
                                                  {"rayleigh", 16, 1, 1e-6, 4},
                                                  {"henyey_greenstein:g=0.5", 20, 0.1, 2, 16},
                                                  // truncated, delta-M and smooth
                                                  {"henyey_greenstein:g=0.75", 20, 0.1, 1, 16},
                                                  {"henyey_greenstein:g=0.95", 12, 0.1, 1, 16},
                                                  {"henyey_greenstein:g=0.95", 12, 0.1, infinity,
                                                   16}}));

TEST(NeumannOrders, StartWithTheClosedForm) {
    for (const char* text : {"rayleigh", "henyey_greenstein:g=0.95"}) {
        const PhaseFunction phase_function = parse_phase_function(text);
        const LayerSolution first =
            solve_orders(phase_function, 0.9, 0.7, order_cosines, up_to_order(12, 1))[0];
        for (const Way& way : ways(5, order_azimuths)) {
            if (way.out != 2) continue;
            const Geometry at = way.geometry(first);
            const double expected =
                single_scattering(way.side, phase_function(cos_scattering_angle(way.side, at)), 0.9,
                                  0.7, at.mu_in, 0.3);
            // subtracting single scattering from the modes leaves rounding
            EXPECT_NEAR(way.of(first).total, expected, 1e-13 * (expected + 1));
        }
    }
}

TEST(NeumannOrders, HaveTheSecondOfTheSemiInfiniteIsotropicLayer) {
    // R = (w/4) H H0 / (mu + mu0) with H = 1 + w (mu/2) log(1 + 1/mu) + O(w^2)  [C60]
    const LayerSolution second =
        solve_orders(isotropic, 0.5, infinity, {0.02, 0.3, 0.8, 1}, up_to_order(24, 2))[1];
    const auto h = [](double mu) { return mu / 2 * std::log1p(1 / mu); };
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            const double x = second.mu(i), y = second.mu(j);
            EXPECT_NEAR(second.reflection(i, j, 0).total, 0.25 / 4 * (h(x) + h(y)) / (x + y),
                        1e-10);
            EXPECT_EQ(second.reflection(i, j, 0).single, 0);
        }
}

TEST(NeumannOrders, AreTheSameForEveryAlbedo) {
    const PhaseFunction phase_function = PhaseFunction::henyey_greenstein(0.8);
    const auto strong = solve_orders(phase_function, 1, 3, order_cosines, up_to_order(12, 5));
    const auto weak = solve_orders(phase_function, 1e-3, 3, order_cosines, up_to_order(12, 5));
    for (std::size_t n = 0; n < 5; ++n) {
        const double expected = strong[n].reflection(2, 3, 1).total;
        EXPECT_NEAR(weak[n].reflection(2, 3, 1).total * std::pow(1e3, static_cast<double>(n + 1)),
                    expected, 1e-12 * expected);
    }
}

TEST(NeumannOrders, KeepRelativeAccuracyWhenWeak) {
    // In a thin layer every order is some tau log(1/tau) times the one before; adding two halves of
    // it must give the same.
    const auto orders = solve_orders(isotropic, 1, 1e-9, {0.3, 0.8}, up_to_order(8, 8));
    for (std::size_t n = 1; n < orders.size(); ++n) {
        const double ratio = orders[n].plane_albedo(0) / orders[n - 1].plane_albedo(0);
        EXPECT_GT(ratio, 1e-9);
        EXPECT_LT(ratio, 1e-7);
    }
}

TEST(SolveLayer, StopsAtTheRequestedOrder) {
    const PhaseFunction phase_function = PhaseFunction::henyey_greenstein(0.9);
    for (const double tau : {0.0, 1e-290, 0.5, infinity}) {
        const LayerSolution stopped =
            solve_layer(phase_function, 0.9, tau, order_cosines, up_to_order(10, 3));
        const auto orders =
            solve_orders(phase_function, 0.9, tau, order_cosines, up_to_order(10, 3));
        for (const Way& way : ways(5, order_azimuths)) {
            if (way.in != 1 || way.out != 3) continue;
            double sum = 0;
            for (const LayerSolution& order : orders) sum += way.of(order).total;
            EXPECT_NEAR(way.of(stopped).total, sum, 1e-14 * sum);
        }
        EXPECT_LT(stopped.spherical_albedo + stopped.total_transmittance, 1 + 1e-15);
    }
}

struct OrderedStack {
    std::vector<StackLayer> layers;
    LowerBoundary boundary;
};

/// Albedos, that of the boundary included, times a factor.
OrderedStack dimmed(OrderedStack stack, double factor) {
    for (StackLayer& layer : stack.layers) layer.albedo *= factor;
    stack.boundary.albedo *= factor;
    return stack;
}

std::vector<OrderedStack> ordered_stacks() {
    const PhaseFunction lobe = PhaseFunction::henyey_greenstein(0.6);
    const std::vector<StackLayer> two{{rayleigh, 1, 0.4}, {lobe, 0.9, 2}};
    return {{two, {}},
            {two, LowerBoundary::surface(0.7)},
            {two, LowerBoundary::layer(lobe, 0.8)},
            {{{lobe, 0.95, 1}}, LowerBoundary::surface(1)},
            {{{rayleigh, 1, 0.4}, {lobe, 0.9, 1e-290}, {lobe, 0.7, infinity}}, {}}};
}

// Order n goes with the n-th power of all albedos: the sum of what is left of them is the stack of
// lower albedos, which is solved without orders.
TEST(OrdersOfStacks, SumToStacksOfAnyAlbedo) {
    const std::vector<double> mu{0.02, 0.3, 0.8, 1};
    for (const OrderedStack& stack : ordered_stacks()) {
        const std::vector<StackSolution> orders =
            solve_orders(stack.layers, stack.boundary, mu, up_to_order(12, 20));
        ASSERT_EQ(orders.size(), 20u);
        for (const double factor : {0.3, 0.1}) {
            const OrderedStack dim = dimmed(stack, factor);
            const Eigen::ArrayXd expected = all_values(
                solve_stack(dim.layers, dim.boundary, mu, with_nodes(12, Truncate::nothing)),
                order_azimuths);
            Eigen::ArrayXd tolerance = 1e-10 * expected;
            tolerance.tail(8) = 1e-11;  // of fluxes
            expect_near(sum_of(orders, factor), expected, tolerance);
        }
    }
}

TEST(OrdersOfStacks, AreLeftOutOfItsSolution) {
    const std::vector<double> mu{0.1, 0.7};
    for (const OrderedStack& stack : ordered_stacks()) {
        const StackSolution sum = solve_stack(stack.layers, stack.boundary, mu, up_to_order(16, 3));
        const std::vector<StackSolution> orders =
            solve_orders(stack.layers, stack.boundary, mu, up_to_order(16, 3));
        EXPECT_LE((all_values(sum, {1}) - sum_of(orders, 1, {1})).abs().maxCoeff(), 1e-14);
        double albedo = 0, ground = 0;
        for (const StackSolution& order : orders) {
            albedo += order.spherical_albedo;
            ground += order.spherical_ground_absorptance;
        }
        EXPECT_DOUBLE_EQ(sum.reflection(0, 1, 1).single, orders[0].reflection(0, 1, 1).single);
        EXPECT_NEAR(sum.spherical_albedo, albedo, 1e-14);
        EXPECT_GE(sum.spherical_ground_absorptance, ground);  // the beam's, too
        EXPECT_EQ(orders[1].reflection(0, 1, 1).single, 0);
    }
}

TEST(SolveLayer, RefusesOrdersOutsideTheirRange) {
    expect_refusal([] { solve_layer(isotropic, 1, 1, {}, up_to_order(8, 201)); },
                   "orders must be in [0, 200], got 201");
    expect_refusal([] { solve_orders(isotropic, 1, 1, {}, up_to_order(8, 0)); },
                   "solve_orders: orders must be in [1, 200");
    SolverOptions options = up_to_order(8, 2);
    options.scheme = Scheme::classic;
    expect_refusal([&] { solve_layer(isotropic, 1, 1, {}, options); },
                   "scheme must be harmonic where orders are counted, got classic");
}

}  // namespace
}  // namespace stratus
