#include "filtered_blocks.h"

#include <stratus/base/constants.h>
#include <stratus/table/packed_block.h>

#include "bound_layer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <random>
#include <utility>
#include <vector>

namespace stratus {
namespace {

using shader::vec4;
using Text = shader::AsCxx;

constexpr int depth_steps = filtered_depth_steps, albedo_steps = 64, sketch_directions = 600;
constexpr int least_steps = depth_steps / most_filtered_blocks;
constexpr double most_left = 1e-3;
constexpr float full_scale = 2048;  // of weights and functions: small ones keep their digits

std::size_t index(int n) { return static_cast<std::size_t>(n); }

/// Layers evenly in the coordinates that their weights are read by.
struct LayerGrid {
    vec4 albedo_axis;
    int finer = 0, albedos;     // finer than the table's albedos, of which there may be one
    float offset, first, last;  // of log2(tau / (tau + offset))

    LayerGrid(Text& exact, int side) : albedo_axis(exact.stratus_field(side, 3)) {
        const vec4 range = exact.stratus_field(side, 9);
        if (albedo_axis.y > 0) finer = static_cast<int>(std::ceil(albedo_steps / albedo_axis.z));
        albedos = static_cast<int>(albedo_axis.z) * finer + 1;
        offset = range.w > 0 ? range.w : 1;
        first = coordinate(std::max(range.z, 1e-30f));
        last = coordinate(exact.stratus_field(side, 10).x);
    }
    float coordinate(float depth) const { return std::log2(depth / (depth + offset)); }
    float albedo(int a) const {
        const float step = finer > 0 ? 1 / (albedo_axis.y * static_cast<float>(finer)) : 0,
                    root = albedo_axis.x + static_cast<float>(a) * step, square = root * root;
        return std::clamp(1 - (albedo_axis.w > 0 ? square * square : square), 0.0f, 1.0f);
    }
    float depth(int d) const {
        const float share =
            std::exp2(first + (last - first) * static_cast<float>(d) / float{depth_steps});
        return share < 1 ? std::min(offset * share / (1 - share), 1e30f) : 1e30f;
    }
    std::size_t number(int a, int d) const { return index(a * (depth_steps + 1) + d); }
};

/// A side's layers in random directions.
class Sketch {
  public:
    /// Over the grid's layers.
    std::vector<std::vector<float>> values, importance;
    std::vector<float> scale;  // of the table's functions, whose factor is another

    Sketch(Text& exact, Text& numbers, int side, const LayerGrid& grid) {
        std::mt19937 random(2);
        std::uniform_real_distribution<float> cosine(0.02f, 1), azimuth(0, static_cast<float>(pi));
        for (int n = 0; n < sketch_directions; ++n) {
            const float mu_in = cosine(random), mu_out = cosine(random);
            paths_.push_back(exact.stratus_path(side, mu_in, mu_out, azimuth(random)));
            phases_.push_back(exact.stratus_phases(side, paths_.back()));
        }
        for (int a = 0; a < grid.albedos; ++a)
            for (int d = 0; d <= depth_steps; ++d)
                add_layer(exact, numbers, side, grid.albedo(a), grid.depth(d));
    }

  private:
    std::vector<Text::StratusPath> paths_;
    std::vector<vec4> phases_;
    std::map<int, std::vector<vec4>> functions_;  // of a block of the table's, by its first texel

    /// A block's functions over (direction, word).
    const std::vector<vec4>& functions_at(Text& exact, int side, int block) {
        std::vector<vec4>& all = functions_[block];
        if (all.empty())
            for (const Text::StratusPath& path : paths_) {
                const auto at = exact.stratus_directions(side, exact.stratus_places(side, path));
                for (int word = 0; word < 4; ++word)
                    all.push_back(exact.stratus_sum_at(side, 0, block + word, 4, at));
            }
        return all;
    }

    void add_layer(Text& exact, Text& numbers, int side, float albedo, float depth) {
        const auto of = exact.stratus_coefficients(side, albedo, depth);
        const std::vector<vec4>& function = functions_at(exact, side, of.functions);
        const auto factor = [&](Text& text, std::size_t k) {
            return text.stratus_factor(side, albedo, depth, of.exponent, paths_[k]);
        };
        const float here = factor(numbers, 0);
        scale.push_back(here > 0 ? factor(exact, 0) / here : 1);
        std::vector<float>&value = values.emplace_back(), &weight = importance.emplace_back();
        for (std::size_t k = 0; k < paths_.size(); ++k) {
            float sum = 0;
            for (std::size_t word = 0; word < 4; ++word)
                sum += dot(of.word[word], function[4 * k + word]);
            value.push_back(sum * scale.back());
            const float of_light = factor(numbers, k),
                        once = numbers.stratus_single_scattering(side, phases_[k], albedo, depth,
                                                                 paths_[k]),
                        along = numbers.stratus_along_path(side, albedo, depth, paths_[k]);
            weight.push_back(of_light / std::max(std::abs(once) + std::abs(along) +
                                                     std::abs(value.back()) * of_light,
                                                 least_filtered_light));
        }
    }
};

/// Between two steps of the depth.
struct Block {
    int first, last;
    LayerBasis basis;
};

Block block_between(const Sketch& sketch, const LayerGrid& grid, int first, int last) {
    BlockLayers layers{};
    for (int a = 0; a < grid.albedos; ++a)
        for (int d = first; d <= last; ++d) {
            layers.values.push_back(&sketch.values[grid.number(a, d)]);
            layers.importance.push_back(&sketch.importance[grid.number(a, d)]);
        }
    const LayerBasis basis = greedy_basis(layers, most_left / 10);
    return {first, last, basis.first(std::min(basis.pivot.size(), index(4 * filtered_words)))};
}

/// Blocks from the thinnest on, each as deep as twelve functions suffice for.
std::vector<Block> find_blocks(const Sketch& sketch, const LayerGrid& grid) {
    std::vector<Block> blocks;
    for (int first = 0; first < depth_steps; first = blocks.back().last) {
        Block found = block_between(sketch, grid, first, first + least_steps);
        // The last that is known to do, in units of the least, and the first that is not.
        int low = 1, high = (depth_steps - first) / least_steps + 1;
        while (high - low > 1) {
            const int middle = (low + high) / 2;
            Block tried = block_between(sketch, grid, first, first + middle * least_steps);
            if (tried.basis.error.back() <= most_left) {
                low = middle;
                found = std::move(tried);
            } else {
                high = middle;
            }
        }
        blocks.push_back(std::move(found));
    }
    return blocks;
}

}  // namespace

SideBlocks side_blocks(Text& exact, Text& numbers, std::size_t rows, int side) {
    if (!(exact.stratus_field(side, 14).x > 0)) return {};
    const LayerGrid grid(exact, side);
    const Sketch sketch(exact, numbers, side, grid);
    const std::vector<Block> blocks = find_blocks(sketch, grid);

    SideBlocks made;
    made.blocks = static_cast<int>(blocks.size());
    made.albedos = grid.albedos;
    made.columns = depth_steps + made.blocks;
    made.offset = grid.offset;
    made.finer_albedos = static_cast<float>(grid.finer);
    made.first = grid.first;
    made.steps_per_unit =
        grid.last > grid.first ? float{depth_steps} / (grid.last - grid.first) : 0;
    made.rows.resize(index(made.blocks * filtered_words) * rows);
    made.weights.resize(index(filtered_words * made.albedos * made.columns));
    for (int b = 0; b < made.blocks; ++b) {
        const auto& [first, last, basis] = blocks[index(b)];
        made.last_step.push_back(static_cast<float>(last));
        const int depths = last - first + 1;
        std::vector<std::vector<float>> functions;
        for (std::size_t f = 0; f < basis.pivot.size(); ++f) {
            const int pivot = basis.pivot[f], a = pivot / depths, d = first + pivot % depths;
            std::vector<float> function =
                orders_of_layer(exact, rows, static_cast<Side>(side), double{grid.albedo(a)},
                                double{grid.depth(d)})
                    .sum;
            for (float& value : function) value *= sketch.scale[grid.number(a, d)];
            for (std::size_t g = 0; g < f; ++g)
                for (std::size_t row = 0; row < rows; ++row)
                    function[row] -= basis.coefficient[index(pivot)][g] * functions[g][row];
            float largest = 1e-30f;
            for (float& value : function) {
                value /= static_cast<float>(basis.norm[f]);
                largest = std::max(largest, std::abs(value));
            }
            const int word = static_cast<int>(f) / 4, slot = static_cast<int>(f) % 4;
            vec4* const to = &made.rows[index(b * filtered_words + word) * rows];
            for (std::size_t row = 0; row < rows; ++row)
                component(to[row], slot) = function[row] / largest * full_scale;
            for (int layer = 0; layer < depths * grid.albedos; ++layer) {
                const int column = first + b + layer % depths,
                          row = word * made.albedos + layer / depths;
                component(made.weights[index(row * made.columns + column)], slot) =
                    basis.coefficient[index(layer)][f] * largest;
            }
            functions.push_back(std::move(function));
        }
    }
    float largest = 1e-30f;
    for (vec4& texel : made.weights)
        for (int slot = 0; slot < 4; ++slot)
            largest = std::max(largest, std::abs(component(texel, slot)));
    for (vec4& texel : made.weights) texel = texel * (full_scale / largest);
    made.unit = largest / (full_scale * full_scale);
    return made;
}

}  // namespace stratus
