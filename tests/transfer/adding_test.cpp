// Identities of adding that hold for any symmetric R and R* and any T.

#include "layer.h"
#include "refusal.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <random>

namespace stratus {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int nodes = 5, extra = 3, size = nodes + extra;
constexpr double rounding = 1e-14;  // of numbers near 1

MatrixXd random_matrix(std::mt19937& random) {
    std::uniform_real_distribution<double> value(0, 0.09);  // rows sum to less than 1
    return MatrixXd::NullaryExpr(size, size, [&] { return value(random); });
}

MatrixXd random_symmetric(std::mt19937& random) {
    const MatrixXd matrix = random_matrix(random);
    return (matrix + matrix.transpose()) / 2;
}

LayerMode random_layer(std::mt19937& random) {
    std::uniform_real_distribution<double> beam(0.1, 0.9);
    return {random_symmetric(random), random_symmetric(random), random_matrix(random),
            VectorXd::NullaryExpr(size, [&] { return beam(random); })};
}

LayerMode opaque(const LayerMode& layer) { return {layer.reflection, {}, {}, {}}; }

LayerMode upside_down(const LayerMode& layer) {
    return {layer.reflection_below, layer.reflection, layer.transmission.transpose(), layer.beam};
}

double difference(const LayerMode& a, const LayerMode& b) {
    return std::max({(a.reflection - b.reflection).cwiseAbs().maxCoeff(),
                     (a.reflection_below - b.reflection_below).cwiseAbs().maxCoeff(),
                     (a.transmission - b.transmission).cwiseAbs().maxCoeff(),
                     (a.beam - b.beam).cwiseAbs().maxCoeff()});
}

TEST(Adding, IsAssociative) {
    std::mt19937 random(1);
    for (int n = 0; n < 20; ++n) {
        const LayerMode a = random_layer(random), b = random_layer(random),
                        c = random_layer(random);
        EXPECT_LE(difference(add(add(a, b, nodes), c, nodes), add(a, add(b, c, nodes), nodes)),
                  rounding);
        EXPECT_LE((add(add(a, b, nodes), opaque(c), nodes).reflection -
                   add(a, add(b, opaque(c), nodes), nodes).reflection)
                      .cwiseAbs()
                      .maxCoeff(),
                  rounding);
    }
}

TEST(Adding, OfInvertedLayersIsInverted) {
    std::mt19937 random(2);
    for (int n = 0; n < 20; ++n) {
        const LayerMode a = random_layer(random), b = random_layer(random);
        EXPECT_LE(
            difference(upside_down(add(a, b, nodes)), add(upside_down(b), upside_down(a), nodes)),
            rounding);
    }
}

TEST(Adding, EqualsTheSeriesOfInterreflections) {
    // Without extra directions, matrices that include the beam multiply directly.
    std::mt19937 random(3);
    const LayerMode a = random_layer(random), b = random_layer(random);
    auto with_beam = [](const LayerMode& layer) {
        MatrixXd T = layer.transmission;
        T.diagonal() += layer.beam;
        return T;
    };
    MatrixXd down = with_beam(a), falling = down, R = a.reflection;
    for (int bounce = 0; bounce < 400; ++bounce) {
        R += with_beam(a).transpose() * b.reflection * down;
        down = a.reflection_below * b.reflection * down;
        falling += down;
    }
    const LayerMode sum = add(a, b, size);
    EXPECT_LE((sum.reflection - R).cwiseAbs().maxCoeff(), rounding);
    EXPECT_LE((with_beam(sum) - with_beam(b) * falling).cwiseAbs().maxCoeff(), rounding);
}

TEST(Adding, OfAnEmptyLayerIsTheIdentity) {
    std::mt19937 random(4);
    const LayerMode layer = random_layer(random);
    const MatrixXd none = MatrixXd::Zero(size, size);
    const LayerMode empty{none, none, none, VectorXd::Ones(size)};
    EXPECT_LE(difference(add(layer, empty, nodes), layer), 1e-16);
    EXPECT_LE(difference(add(empty, layer, nodes), layer), 1e-16);
}

TEST(Adding, BalancesTheFluxAbsorbedBelow) {
    // Conservative layers: s = R s + T s, by rows and by columns.
    std::mt19937 random(5);
    const VectorXd s = VectorXd::NullaryExpr(
        size, [&] { return std::uniform_real_distribution<double>(0.2, 1)(random); });
    LayerMode layer = random_layer(random);
    const double ss = s.head(nodes).squaredNorm();
    layer.reflection *= 0.3;
    layer.reflection_below = layer.reflection;
    const VectorXd rest =
        s - layer.reflection.leftCols(nodes) * s.head(nodes) - layer.beam.cwiseProduct(s);
    const VectorXd a = rest / ss;
    layer.transmission = a * s.transpose() + s * a.transpose() -
                         s * s.transpose() * (a.head(nodes).dot(s.head(nodes)) / ss);
    ASSERT_LE((layer.transmission.leftCols(nodes) * s.head(nodes) - rest).cwiseAbs().maxCoeff(),
              rounding);
    const LayerMode ground = opaque(random_layer(random));
    const VectorXd entering = s - ground.reflection.leftCols(nodes) * s.head(nodes);
    const VectorXd taken = layer.beam.cwiseProduct(entering) +
                           diffuse_flux_between(layer, ground, entering, nodes).col(0);
    const VectorXd back = add(layer, ground, nodes).reflection.leftCols(nodes) * s.head(nodes);
    EXPECT_LE((s - back - taken).cwiseAbs().maxCoeff(), rounding);
}

TEST(Adding, RefusesAnOpaqueLayerAbove) {
    std::mt19937 random(6);
    const LayerMode layer = random_layer(random);
    expect_refusal([&] { add(opaque(layer), layer, nodes); },
                   "add: the layer above must be one that lets light through, got an opaque");
}

TEST(Adding, RefusesLayersOfDifferentSizes) {
    std::mt19937 random(7);
    const LayerMode layer = random_layer(random);
    LayerMode smaller = opaque(layer);
    smaller.reflection.conservativeResize(size - 1, size - 1);
    expect_refusal([&] { add(layer, smaller, nodes); },
                   "add: directions of the layer below must be 8, got 7");
}

TEST(Adding, RefusesMoreNodesThanDirections) {
    std::mt19937 random(8);
    const LayerMode layer = random_layer(random);
    expect_refusal([&] { add(layer, layer, size + 1); }, "add: nodes must be in [1, 8], got 9");
    expect_refusal([&] { add(layer, layer, 0); }, "add: nodes must be in [1, 8], got 0");
}

}  // namespace
}  // namespace stratus
