#include "ordered_ladder.h"

#include <stratus/base/size.h>

#include <algorithm>
#include <cmath>

namespace stratus {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

Pack* packs(double* memory) { return reinterpret_cast<Pack*>(memory); }

std::vector<DoublingTask> conservative_tasks(std::span<const int> modes, double thin_depth) {
    std::vector<DoublingTask> tasks;
    for (const int mode : modes) tasks.push_back({mode, 1, 0, thin_depth});
    return tasks;
}

/// One lane of a kernel.
MatrixXd lane_matrix(const SimdLayer<Pack>& layer, const Pack* K, int lane) {
    MatrixXd matrix(layer.directions, layer.directions);
    for (int i = 0; i < layer.directions; ++i)
        for (int j = 0; j < layer.directions; ++j) matrix(j, i) = K[i * layer.stride + j][lane];
    return matrix;
}

}  // namespace

// ---- series ------------------------------------------------------------------------------------

OrderedLadder::Series OrderedLadder::nothing() const {
    Series series;
    series.d.resize(highest_order_ + 1);
    series.K.resize(highest_order_ + 1);
    return series;
}

/// The kernel of one order, created as zeros if empty.
Pack* OrderedLadder::kernel(Series& of, std::size_t order) const {
    PackMemory& K = of.K[order];
    if (K.get() != nullptr) return packs(K.get());
    const SimdLayer<Pack>& layer = start_.layer();
    const std::size_t count = size(layer.directions) * size(layer.stride) * lane_count;
    K = PackMemory(count);
    std::fill_n(K.get(), count, 0.0);
    return packs(K.get());
}

/// Adds factor F_i G_j at order i + j; F is symmetric.
void OrderedLadder::add_product(Series& sum, double factor, const Series& F, std::size_t i,
                                const Series& G, std::size_t j) const {
    const VectorXd &d = F.d[i], &e = G.d[j];
    if (d.size() && e.size()) {
        VectorXd& into = sum.d[i + j];
        if (!into.size()) into = VectorXd::Zero(d.size());
        into += factor * d.cwiseProduct(e);
    }
    const ProductFactors<Pack> of{d.size() ? d.data() : nullptr, e.size() ? e.data() : nullptr,
                                  packs(F.K[i].get()), packs(G.K[j].get())};
    if ((of.F && (of.G || of.G_diagonal)) || (of.F_diagonal && of.G))
        steps_.add_product(start_.layer(), factor, of, kernel(sum, i + j));
}

void OrderedLadder::add(Series& sum, double factor, const Series& F) const {
    Series one = nothing();
    one.d[0] = VectorXd::Ones(directions_.size());
    for (std::size_t k = 0; k <= highest_order_; ++k) add_product(sum, factor, one, 0, F, k);
}

OrderedLadder::Series OrderedLadder::sum(double x, const Series& F, double y,
                                         const Series& G) const {
    Series result = nothing();
    add(result, x, F);
    if (y != 0) add(result, y, G);
    return result;
}

OrderedLadder::Series OrderedLadder::product(const Series& F, const Series& G) const {
    Series result = nothing();
    for (std::size_t i = 0; i <= highest_order_; ++i)
        for (std::size_t j = 0; i + j <= highest_order_; ++j) add_product(result, 1, F, i, G, j);
    return result;
}

/// F^-1 where F_0 is diagonal: G_0 = 1/F_0, G_k = -G_0 sum_{j=1..k} F_j G_{k-j}.
OrderedLadder::Series OrderedLadder::inverse(const Series& F) const {
    Series G = nothing();
    G.d[0] = F.d[0].cwiseInverse();
    for (std::size_t k = 1; k <= highest_order_; ++k) {
        Series rest = nothing();
        for (std::size_t j = 1; j <= k; ++j) add_product(rest, -1, F, j, G, k - j);
        add_product(G, 1, G, 0, rest, k);
    }
    return G;
}

/// P : Q = P - P (P + Q)^-1 P.
OrderedLadder::Series OrderedLadder::parallel_sum(const Series& P, const Series& Q) const {
    return sum(1, P, -1, product(P, product(inverse(sum(1, P, 1, Q)), P)));
}

// ---- layers ------------------------------------------------------------------------------------

/// depth times (diag((1 - w f)/mu) - w (1 - f) kernel).
OrderedLadder::Series OrderedLadder::scattered(double depth, const Pack* kernel_of_order_1) const {
    Series one = nothing(), result = nothing();
    one.d[0] = VectorXd::Ones(directions_.size());
    result.d[0] = depth * directions_.mu.cwiseInverse();
    if (truncated_ > 0) result.d[1] = -truncated_ * result.d[0];
    steps_.add_product(start_.layer(), -depth * (1 - truncated_),
                       {one.d[0].data(), nullptr, nullptr, kernel_of_order_1}, kernel(result, 1));
    return result;
}

OrderedLadder::OrderedLadder(const Directions& directions, const std::vector<double>& moments,
                             double truncated, std::span<const int> modes, int highest_order,
                             double thin_depth)
    : directions_(directions),
      steps_(chosen_functions<DoublingSteps<Pack>>()),
      truncated_(truncated),
      highest_order_(size(highest_order)),
      optical_depth_(thin_depth),
      start_(directions, moments, conservative_tasks(modes, thin_depth)),
      reflection_(nothing()),
      transmission_(nothing()) {
    // The thin start of simd/doubling.cpp, b = h B and W = (h A)^-1.
    const Series b = scattered(thin_depth / 2, start_.layer().scatter_even.K);
    const Series W = inverse(scattered(thin_depth / 2, start_.layer().scatter_odd.K));
    const auto times = [this](double x, const Series& F) { return sum(x, F, 0, F); };
    Series Y = parallel_sum(times(1.0 / 9, b), times(11, W));
    Y = parallel_sum(times(1.0 / 5, b), sum(7, W, 1, Y));
    Y = parallel_sum(b, sum(3, W, 1, Y));
    Series Z = parallel_sum(times(1.0 / 7, b), sum(9, W, 1.0 / 11, b));
    Z = sum(1, W, 1, parallel_sum(times(1.0 / 3, b), sum(5, W, 1, Z)));
    Y.d[0].array() += 1;
    Z.d[0].array() += 1;
    const Series even = inverse(Y), odd = inverse(Z);  // R + T = 2 (I + Y)^-1 - I, R - T with Z
    reflection_ = sum(1, even, 1, odd);
    for (VectorXd& diagonal : reflection_.d) diagonal.resize(0);  // that of I
    transmission_ = sum(1, even, -1, odd);
    set_beam();
}

void OrderedLadder::double_depth() {
    // R' = R + T U,  T' = T D of the light between the halves, U = R D and D = T + R U.  [HT74]
    Series down = sum(1, transmission_, 0, transmission_), up = nothing();
    for (std::size_t k = 1; k <= highest_order_; ++k)
        for (std::size_t j = 1; j <= k; ++j) {
            add_product(up, 1, reflection_, j, down, k - j);
            add_product(down, 1, reflection_, j, up, k - j);
        }
    add(reflection_, 1, product(transmission_, up));
    transmission_ = product(transmission_, down);
    optical_depth_ *= 2;
    set_beam();
}

/// exp(-(1 - w f) tau / mu), order by order.
void OrderedLadder::set_beam() {
    const VectorXd slant = optical_depth_ * directions_.mu.cwiseInverse();
    VectorXd term = slant.unaryExpr([](double x) { return std::exp(-x); });
    for (std::size_t k = 0; k <= highest_order_; ++k) {
        transmission_.d[k] = truncated_ > 0 || k == 0 ? term : VectorXd();
        term = (term.cwiseProduct(slant) * (truncated_ / static_cast<double>(k + 1))).eval();
    }
}

bool OrderedLadder::is_converged() const {
    const SimdLayer<Pack>& layer = start_.layer();
    for (std::size_t k = 1; k <= highest_order_; ++k)
        for (int i = 0; i < layer.directions; ++i)
            for (int j = 0; j < layer.directions; ++j)
                for (int lane = 0; lane < lane_count; ++lane)
                    if (std::abs(packs(transmission_.K[k].get())[i * layer.stride + j][lane]) >
                        1e-17 * directions_.s(i) * directions_.s(j))
                        return false;
    return true;
}

ModeMatrices OrderedLadder::matrices(int lane, const VectorXd& weights) const {
    const int n = directions_.size();
    ModeMatrices sums{MatrixXd::Zero(n, n), MatrixXd::Zero(n, n)};
    for (std::size_t k = 1; k <= highest_order_; ++k) {
        const double weight = weights(static_cast<Eigen::Index>(k));
        if (weight == 0) continue;
        sums.reflection +=
            weight * lane_matrix(start_.layer(), packs(reflection_.K[k].get()), lane);
        sums.transmission +=
            weight * lane_matrix(start_.layer(), packs(transmission_.K[k].get()), lane);
    }
    return sums;
}

}  // namespace stratus
