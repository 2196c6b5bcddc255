#include <stratus/table/packed_block.h>

#include <stratus/base/size.h>

#include "kernels/vectors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace stratus {
LayerBasis LayerBasis::first(std::size_t count) const {
    LayerBasis fewer(*this);
    fewer.pivot.resize(count);
    fewer.norm.resize(count);
    for (std::vector<float>& of_layer : fewer.coefficient) of_layer.resize(count);
    fewer.error.resize(count + 1);
    return fewer;
}

LayerBasis greedy_basis(const BlockLayers& layers, std::size_t room, double allowed) {
    const std::size_t count = layers.values.size(), columns = layers.values[0]->size();
    const VectorKernels& vectors = vector_kernels();
    LayerBasis basis{room, {}, {}, Vectors(count), {}};
    std::vector<float> remainders(count * columns);  // of all layers: one piece of memory
    std::vector<double> error(count);                // of each layer
    std::vector<float> weight(columns);              // of each direction
    const auto remainder = [&](std::size_t l) { return &remainders[l * columns]; };
    const auto measure = [&](std::size_t l) {
        error[l] =
            double{vectors.largest_product(remainder(l), layers.importance[l]->data(), columns)};
    };
    for (std::size_t l = 0; l < count; ++l) {
        std::copy(layers.values[l]->begin(), layers.values[l]->end(), remainder(l));
        measure(l);
        for (std::size_t k = 0; k < columns; ++k) {
            const float importance = (*layers.importance[l])[k];
            weight[k] += importance * importance / static_cast<float>(count);
        }
    }
    for (;;) {
        const auto worst = std::max_element(error.begin(), error.end());
        basis.error.push_back(*worst);
        if (*worst <= allowed || basis.pivot.size() == room) return basis;
        // The normalised remainder of the worst layer is the next function.
        const std::ptrdiff_t pivot = worst - error.begin();
        const float* const left = remainder(size(pivot));
        double square = 0;
        for (std::size_t k = 0; k < columns; ++k)
            square += double{weight[k]} * double{left[k]} * double{left[k]};
        const double norm = std::sqrt(square);
        std::vector<float> function(columns), weighted(columns);
        for (std::size_t k = 0; k < columns; ++k) {
            function[k] = static_cast<float>(double{left[k]} / norm);
            weighted[k] = weight[k] * function[k];
        }
        basis.pivot.push_back(static_cast<int>(pivot));
        basis.norm.push_back(norm);
        for (std::size_t l = 0; l < count; ++l) {
            basis.coefficient[l].push_back(vectors.dot(remainder(l), weighted.data(), columns));
            vectors.subtract(basis.coefficient[l].back(), function.data(), remainder(l), columns);
            measure(l);
        }
    }
}

}  // namespace stratus
