#include <stratus/table/packed_block.h>

#include <stratus/base/size.h>

#include "kernels/vectors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace stratus {
namespace {

class GreedySearch {
  public:
    explicit GreedySearch(const BlockLayers& layers)
        : layers_(layers),
          columns_(layers.values[0]->size()),
          remainder_(size(layers.count())),
          error_(size(layers.count())),
          weight_(columns_) {
        basis_.coefficient.resize(size(layers.count()));
    }

    LayerBasis basis(std::size_t room, double allowed) {
        basis_.room = room;
        for (int l = 0; l < layers_.count(); ++l) {
            remainder_[size(l)] = *layers_.values[size(l)];
            error_[size(l)] = remaining_error(l);
            add_weight(l);
        }
        for (;;) {
            const auto worst = std::max_element(error_.begin(), error_.end());
            basis_.error.push_back(*worst);
            if (*worst <= allowed || basis_.pivot.size() == room) break;
            add_function(static_cast<int>(worst - error_.begin()));
            for (int l = 0; l < layers_.count(); ++l) {
                subtract(l, function_.size() - 1);
                error_[size(l)] = remaining_error(l);
            }
        }
        return std::move(basis_);
    }

  private:
    void add_weight(int l) {
        for (std::size_t k = 0; k < columns_; ++k) {
            const float importance = (*layers_.importance[size(l)])[k];
            weight_[k] += importance * importance / static_cast<float>(layers_.count());
        }
    }

    double remaining_error(int l) const {
        return double{largest_product(remainder_[size(l)], *layers_.importance[size(l)])};
    }

    /// Adds the normalised remainder of a layer to the functions.
    void add_function(int pivot) {
        const std::vector<float>& left = remainder_[size(pivot)];
        double square = 0;
        for (std::size_t k = 0; k < columns_; ++k)
            square += double{weight_[k]} * double{left[k]} * double{left[k]};
        const double norm = std::sqrt(square);
        function_.emplace_back(columns_);
        weighted_.emplace_back(columns_);
        for (std::size_t k = 0; k < columns_; ++k) {
            function_.back()[k] = static_cast<float>(double{left[k]} / norm);
            weighted_.back()[k] = weight_[k] * function_.back()[k];
        }
        basis_.pivot.push_back(pivot);
        basis_.norm.push_back(norm);
    }

    /// Subtracts function f from what is left of layer l.
    void subtract(int l, std::size_t f) {
        const float share = dot(remainder_[size(l)], weighted_[f]);
        basis_.coefficient[size(l)].push_back(share);
        stratus::subtract(share, function_[f], remainder_[size(l)]);
    }

    const BlockLayers& layers_;
    std::size_t columns_;                        // directions
    std::vector<std::vector<float>> remainder_;  // of each layer
    std::vector<double> error_;                  // of each layer
    std::vector<float> weight_;                  // of each direction
    std::vector<std::vector<float>> function_, weighted_;
    LayerBasis basis_;
};

}  // namespace

LayerBasis LayerBasis::first(std::size_t count) const {
    LayerBasis fewer(*this);
    fewer.pivot.resize(count);
    fewer.norm.resize(count);
    for (std::vector<float>& of_layer : fewer.coefficient) of_layer.resize(count);
    fewer.error.resize(count + 1);
    return fewer;
}

LayerBasis greedy_basis(const BlockLayers& layers, std::size_t room, double allowed) {
    return GreedySearch(layers).basis(room, allowed);
}

}  // namespace stratus
