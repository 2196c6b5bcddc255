#include "sketch_fit.h"

#include "kernels/vectors.h"

#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace stratus {
namespace {

double norm(const std::vector<double>& values) {
    return std::sqrt(std::inner_product(values.begin(), values.end(), values.begin(), 0.0));
}

/// Back substitution of all columns of Q^T W.
std::vector<std::vector<float>> inverted(std::vector<std::vector<double>>& q,
                                         const std::vector<std::vector<double>>& r,
                                         const std::vector<float>& weight) {
    for (std::size_t k = q.size(); k-- > 0;) {
        for (std::size_t later = k + 1; later < q.size(); ++later)
            for (std::size_t s = 0; s < weight.size(); ++s) q[k][s] -= r[later][k] * q[later][s];
        for (double& value : q[k]) value /= r[k][k];
    }
    std::vector<std::vector<float>> rows;
    for (const std::vector<double>& row : q) {
        rows.emplace_back();
        for (std::size_t s = 0; s < weight.size(); ++s)
            rows.back().push_back(static_cast<float>(row[s] * double{weight[s]}));
    }
    return rows;
}

}  // namespace

SketchFit::SketchFit(const std::vector<std::vector<float>>& function,
                     const std::vector<float>& weight) {
    std::vector<std::vector<double>> q, r;
    for (const std::vector<float>& column : function) {
        std::vector<double> left(weight.size()), shares(q.size(), 0.0);
        for (std::size_t s = 0; s < left.size(); ++s)
            left[s] = double{weight[s]} * double{column[s]};
        const double before = norm(left);
        for (int twice = 0; twice < 2; ++twice)
            for (std::size_t k = 0; k < q.size(); ++k) {
                const double share =
                    std::inner_product(left.begin(), left.end(), q[k].begin(), 0.0);
                shares[k] += share;
                for (std::size_t s = 0; s < left.size(); ++s) left[s] -= share * q[k][s];
            }
        const double after = norm(left);
        const bool depends = after <= 1e-9 * before;  // on those before: it gets no share
        for (double& value : left) value = depends ? 0 : value / after;
        shares.push_back(depends ? 1 : after);
        q.push_back(std::move(left));
        r.push_back(std::move(shares));
    }
    rows_ = inverted(q, r, weight);
}

std::vector<float> SketchFit::coefficients(const std::vector<float>& values) const {
    std::vector<float> found;
    for (const std::vector<float>& row : rows_) found.push_back(dot(row, values));
    return found;
}

}  // namespace stratus
