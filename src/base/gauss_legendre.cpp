#include <stratus/base/gauss_legendre.h>

#include <stratus/base/constants.h>

#include <cmath>

namespace stratus {

GaussLegendre::GaussLegendre(std::size_t count) : x(count), weight(count) {
    const double N = static_cast<double>(count);
    for (std::size_t i = 0; i < (count + 1) / 2; ++i) {
        double c = std::cos(pi * (static_cast<double>(i) + 0.75) / (N + 0.5)), slope = 1;
        for (int step = 0; step < 5; ++step) {
            double before = 0, here = 1;
            for (std::size_t l = 0; l < count; ++l) {
                const double order = static_cast<double>(l);
                const double next = c * here + order / (order + 1) * (c * here - before);
                before = here;
                here = next;
            }
            slope = N * (before - c * here) / ((1 - c) * (1 + c));
            const double change = here / slope;
            c -= change;
            if (std::abs(change) < 1e-15) break;
        }
        x[i] = c;
        x[count - 1 - i] = -c;
        weight[i] = weight[count - 1 - i] = 2 / ((1 - c) * (1 + c) * slope * slope);
    }
    if (count % 2 == 1) x[count / 2] = 0;
}

std::vector<double> lagrange_weights(const std::vector<double>& x, double at) {
    std::vector<double> weights(x.size(), 1.0);
    for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t k = 0; k < x.size(); ++k)
            if (k != i) weights[i] *= (at - x[k]) / (x[i] - x[k]);
    return weights;
}

}  // namespace stratus
