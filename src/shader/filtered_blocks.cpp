#include "texture_parts.h"

#include <stratus/base/constants.h>
#include <stratus/table/packed_block.h>

#include <map>
#include <random>
#include <utility>

namespace stratus {
namespace {

using shader::vec4;
using Text = shader::AsCxx;

constexpr int depth_units = 16, unit_steps = 12;  // of the depths; a block is a unit at least
constexpr int albedo_steps = 64, sketch_directions = 600;
constexpr double most_left = 1e-3;
constexpr float thinnest_share = 0.0625f;  // of the table's first depth, as in the text

/// Layers evenly in the coordinates that their weights are read by.
struct LayerGrid {
    int finer = 0;                     // than the table's albedos, of which there may be one
    float offset;                      // of the coordinate of the depth, log2(tau / (tau + offset))
    std::vector<float> albedo, depth;  // before the table's depths one by extrapolation
    std::vector<int> range;  // where the depths that no block spans begin, and where they end

    LayerGrid(Text& exact, int side, bool may_jump) {
        const vec4 albedo_axis = exact.stratus_field(side, 3), ends = exact.stratus_field(side, 9);
        if (albedo_axis.y > 0) finer = static_cast<int>(std::ceil(albedo_steps / albedo_axis.z));
        const float step = finer > 0 ? 1 / (albedo_axis.y * exactly(finer)) : 0;
        for (int a = 0; a <= static_cast<int>(albedo_axis.z) * finer; ++a) {
            const float root = albedo_axis.x + exactly(a) * step, square = root * root;
            albedo.push_back(
                std::clamp(1 - (albedo_axis.w > 0 ? square * square : square), 0.0f, 1.0f));
        }
        offset = ends.w > 0 ? ends.w : 1;
        std::vector<float> part{coordinate(std::max(ends.z, 1e-30f)),
                                coordinate(exact.stratus_field(side, 10).x)};
        if (may_jump) {
            const std::vector<float> jumps = table_jumps(exact, side);
            part.insert(part.begin() + 1, jumps.begin(), jumps.end());
        }
        depth.push_back(depth_at(part.front()) * thinnest_share);
        const float units = depth_units / std::max(part.back() - part.front(), 1e-6f);
        for (std::size_t p = 0; p + 1 < part.size(); ++p) {
            constexpr float inside = 1e-6f;  // of the range, so that it is the range's own block
            const float first = part[p] + (p > 0 ? inside : 0),
                        last = part[p + 1] - (p + 2 < part.size() ? inside : 0);
            const int steps =
                unit_steps * std::max(1, static_cast<int>((last - first) * units + 0.01f));
            range.push_back(int_size(depth));
            for (int d = 0; d <= steps; ++d)
                depth.push_back(depth_at(first + (last - first) * exactly(d) / exactly(steps)));
        }
        range.push_back(int_size(depth));
    }
    float coordinate(float at) const { return std::log2(at / (at + offset)); }
    std::size_t number(std::size_t a, int d) const { return a * depth.size() + size(d); }

  private:
    float depth_at(float coordinate) const {
        const float share = std::exp2(coordinate);
        return share < 1 ? std::min(offset * share / (1 - share), 1e30f) : 1e30f;
    }

    /// Coordinates of the depths at which one of the table's blocks ends and the next begins.
    std::vector<float> table_jumps(Text& exact, int side) const {
        constexpr std::size_t most = 8;
        const vec4 axis = exact.stratus_field(side, 4);
        const int cells = static_cast<int>(exact.stratus_field(side, 13).y),
                  depths = static_cast<int>(axis.z) + 1,
                  albedos = static_cast<int>(exact.stratus_field(side, 3).z) + 1;
        std::vector<float> jumps;
        for (int d = 1; d < depths && jumps.size() < most; ++d) {
            bool jump = false;
            for (int a = 0; a < albedos; ++a) {
                const int cell = cells + a * depths + d;
                jump |= exact.stratus_number(cell).x != exact.stratus_number(cell - 1).x;
            }
            if (jump) jumps.push_back(coordinate(std::exp2(axis.x + exactly(d) / axis.y)));
        }
        return jumps;
    }
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
        for (const float albedo : grid.albedo)
            for (const float depth : grid.depth) add_layer(exact, numbers, side, albedo, depth);
    }

  private:
    std::vector<Text::StratusPath> paths_;
    std::vector<vec4> phases_;
    std::map<int, std::vector<vec4>> functions_;  // of a block of the table's, by its first texel

    /// A block's functions over (direction, word).
    const std::vector<vec4>& functions_at(Text& exact, int side, int block, int words) {
        std::vector<vec4>& all = functions_[block];
        if (all.empty())
            for (const Text::StratusPath& path : paths_) {
                const auto at = exact.stratus_directions(side, exact.stratus_places(side, path));
                for (int word = 0; word < words; ++word)
                    all.push_back(exact.stratus_sum_at(side, 0, block + word, words, at));
            }
        return all;
    }

    void add_layer(Text& exact, Text& numbers, int side, float albedo, float depth) {
        const auto of = exact.stratus_coefficients(side, albedo, depth);
        const std::vector<vec4>& function = functions_at(exact, side, of.functions, of.words);
        std::vector<vec4> coefficient;
        for (int word = 0; word < of.words; ++word)
            coefficient.push_back(exact.stratus_coefficients_of_word(of, word));
        const auto factor = [&](Text& text, std::size_t k) {
            return text.stratus_factor(side, albedo, depth, of.exponent, paths_[k]);
        };
        const float here = factor(numbers, 0);
        scale.push_back(here > 0 ? factor(exact, 0) / here : 1);
        std::vector<float>&value = values.emplace_back(), &weight = importance.emplace_back();
        for (std::size_t k = 0; k < paths_.size(); ++k) {
            float sum = 0;
            for (std::size_t word = 0; word < coefficient.size(); ++word)
                sum += dot(coefficient[word], function[coefficient.size() * k + word]);
            value.push_back(sum * scale.back());
            const float of_light = factor(numbers, k),
                        once = numbers.stratus_single_scattering(side, phases_[k], albedo, depth,
                                                                 paths_[k]),
                        along = exact.stratus_along_path(side, albedo, depth, paths_[k]);
            weight.push_back(of_light / std::max(std::abs(once) + std::abs(along) +
                                                     std::abs(value.back()) * of_light,
                                                 least_filtered_light));
        }
    }
};

/// Between two of the grid's depths; the first block has the extrapolated one, too.
struct Block {
    int first, last;
    LayerBasis basis;

    int first_layer() const { return first == 1 ? 0 : first; }
};

Block block_between(const Sketch& sketch, const LayerGrid& grid, int first, int last) {
    Block block{first, last, {}};
    BlockLayers layers{};
    for (std::size_t a = 0; a < grid.albedo.size(); ++a)
        for (int d = block.first_layer(); d <= last; ++d) {
            layers.values.push_back(&sketch.values[grid.number(a, d)]);
            layers.importance.push_back(&sketch.importance[grid.number(a, d)]);
        }
    block.basis = greedy_basis(layers, 4 * filtered_words, most_left / 10);
    return block;
}

/// Adds the blocks of a range from the thinnest on, each as deep as twelve functions suffice for.
void add_blocks(const Sketch& sketch, const LayerGrid& grid, int first, int end,
                std::vector<Block>& blocks) {
    for (; first < end; first = blocks.back().last) {
        Block found = block_between(sketch, grid, first, first + unit_steps);
        // The last that is known to do, in units, and the first that is not.
        int low = 1, high = (end - first) / unit_steps + 1;
        while (high - low > 1) {
            const int middle = (low + high) / 2;
            Block tried = block_between(sketch, grid, first, first + middle * unit_steps);
            if (tried.basis.error.back() <= most_left) {
                low = middle;
                found = std::move(tried);
            } else {
                high = middle;
            }
        }
        blocks.push_back(std::move(found));
    }
}

}  // namespace

float scale_to_halves(std::vector<vec4>& texels) {
    float largest = 1e-30f;
    for (vec4& texel : texels)
        for (int slot = 0; slot < 4; ++slot)
            largest = std::max(largest, std::abs(component(texel, slot)));
    for (vec4& texel : texels) texel = texel * (full_scale / largest);
    return largest / full_scale;
}

std::vector<char> as_halves(const std::vector<vec4>& texels) {
    std::vector<Half> halves;
    for (const vec4& at : texels)
        for (const float value : {at.x, at.y, at.z, at.w}) halves.push_back(to_half(value));
    std::vector<char> bytes(halves.size() * sizeof(Half));
    std::memcpy(bytes.data(), halves.data(), bytes.size());
    return bytes;
}

SideBlocks side_blocks(Text& exact, Text& numbers, std::size_t rows, int side, bool may_jump) {
    if (!(exact.stratus_field(side, 14).x > 0)) return {};
    const LayerGrid grid(exact, side, may_jump);
    const Sketch sketch(exact, numbers, side, grid);
    std::vector<Block> blocks;
    for (std::size_t r = 0; r + 1 < grid.range.size(); ++r)
        add_blocks(sketch, grid, grid.range[r], grid.range[r + 1] - 1, blocks);

    SideBlocks made;
    made.albedos = grid.albedo;
    made.offset = grid.offset;
    made.finer_albedos = exactly(grid.finer);
    for (const Block& block : blocks) {
        const float first = grid.coordinate(grid.depth[size(block.first)]),
                    last = grid.coordinate(grid.depth[size(block.last)]);
        const int steps = block.last - block.first, before = block.first - block.first_layer();
        const float per_unit = last > first ? exactly(steps) / (last - first) : 0;
        made.blocks.emplace_back(last, exactly(made.columns + before) + 0.5f - first * per_unit,
                                 per_unit, 0.0f);
        made.columns += before + steps + 1;
    }
    const std::size_t columns = size(made.columns), words = filtered_words;
    made.rows.resize(blocks.size() * words * rows);
    made.weights.resize(words * grid.albedo.size() * columns);
    std::size_t column = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        const LayerBasis& basis = blocks[b].basis;
        const int first = blocks[b].first_layer(), depths = blocks[b].last - first + 1;
        std::vector<std::vector<float>> functions;
        for (std::size_t f = 0; f < basis.pivot.size(); ++f) {
            const int pivot = basis.pivot[f], d = first + pivot % depths;
            const std::size_t a = size(pivot / depths);
            std::vector<float> function =
                orders_of_layer(exact, rows, static_cast<Side>(side), double{grid.albedo[a]},
                                double{grid.depth[size(d)]})
                    .sum;
            for (float& value : function) value *= sketch.scale[grid.number(a, d)];
            for (std::size_t g = 0; g < f; ++g)
                for (std::size_t row = 0; row < rows; ++row)
                    function[row] -= basis.coefficient[size(pivot)][g] * functions[g][row];
            float largest = 1e-30f;
            for (float& value : function) {
                value /= static_cast<float>(basis.norm[f]);
                largest = std::max(largest, std::abs(value));
            }
            const int slot = static_cast<int>(f % 4);
            vec4* const to = &made.rows[(b * words + f / 4) * rows];
            for (std::size_t row = 0; row < rows; ++row)
                component(to[row], slot) = function[row] / largest * full_scale;
            for (std::size_t layer = 0; layer < basis.coefficient.size(); ++layer) {
                const std::size_t row = f / 4 * grid.albedo.size() + layer / size(depths);
                component(made.weights[row * columns + column + layer % size(depths)], slot) =
                    basis.coefficient[layer][f] * largest;
            }
            functions.push_back(std::move(function));
        }
        column += size(depths);
    }
    made.unit = scale_to_halves(made.weights) / full_scale;
    return made;
}

}  // namespace stratus
