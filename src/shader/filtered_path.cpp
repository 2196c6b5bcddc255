#include "texture_parts.h"

#include <utility>

namespace stratus {
namespace {

using shader::vec4;

constexpr int words = 2;            // of four functions; of reflection the first alone
constexpr int octave_rows = 9;      // of 2 + slant depth
constexpr int slices = 18;          // the last is reflection's
constexpr double excess_scale = 4;  // of the slices

/// The slant depth of a row of the texture; 0 is left out, for which cosines have no ratio.
double slant_depth(int row) {
    const int octave = row / octave_rows, step = row % octave_rows;
    return std::max(std::exp2(1 + octave + step / double{octave_rows - 1}) - 2, 1e-6);
}

int first_slice(int side) { return side == STRATUS_REFLECTION ? slices - 1 : 0; }
int last_slice(int side) { return side == STRATUS_REFLECTION ? slices - 1 : slices - 2; }

/// Weights of the orders at a row and a slice of the texture, but for albedos, of R times the sum of the
/// cosines, T times the larger one: all times `scale`, which grows as thin layers lose light.
struct PlaceOrders {
    PathWeights weights;
    double scale;
};
PlaceOrders orders_at(int row, int slice, int count) {
    const bool reflected = slice == slices - 1;
    const double slant = slant_depth(row), share = slice / double{slices - 2},
                 excess = reflected ? 0 : excess_scale * share / std::max(1 - share, 1e-9),
                 longer = slant + excess, between = slant + excess / 2;
    PlaceOrders at{reflected ? path_weights(Side::reflection, count, slant / 2, 1, 1)
                             : path_weights(Side::transmission, count, slant, 1, slant / longer),
                   (1 + 1 / longer) * (1 + 1 / between)};
    for (int n = 0; n < at.weights.count; ++n)
        at.weights.of_order[n] *= (reflected ? 2 : 1) * at.scale;
    return at;
}

/// x + offset at an angle (path_law.h), by which its samples are multiplied.
double offset_angle(const PathOrders& law, int angle) {
    constexpr int steps = 1 << PathOrders::angle_bits;
    const int n = angle % law.angle_count();
    return std::ldexp(double{law.offset()} * (1 + n % steps / double{steps}), n / steps);
}

/// The law's sum over orders n >= 2 at an angle, divided by the square of the albedo.
double along(const PathOrders& law, int angle, const PathWeights& weights, double albedo) {
    const float* const f = law.of_angle(angle);
    double sum = 0;
    for (int n = weights.count - 1; n >= 2; --n)
        sum = sum * albedo + weights.of_order[n] * double{f[n - 2]};
    return sum;
}

/// Functions of the angle, each 1 at an angle of its own and 0 at those of the functions before it. Were it
/// 0 at those of all others, sums would be small differences of large terms, whose halves are too short.
struct Basis {
    std::vector<std::vector<double>> function;
    std::vector<int> angle;

    double largest(int f) const {
        const std::vector<double>& all = function[size(f)];
        const auto [low, high] = std::minmax_element(all.begin(), all.end());
        return std::max(-*low, *high);
    }

    /// The multiples of the functions whose sum is `value(angle)` at all of their angles.
    template <class Value>
    std::vector<double> weights(const Value& value) const {
        std::vector<double> all;
        for (const int at : angle) {
            double left = value(at);
            for (std::size_t f = 0; f < all.size(); ++f) left -= all[f] * function[f][size(at)];
            all.push_back(left);
        }
        return all;
    }
};

/// The law along light paths over (path, angle), and what its errors are multiplied by to be shares of light.
struct PathSketch {
    std::vector<std::vector<double>> values, importance;
};

PathSketch make_sketch(const TableView& table, int count, int side, int octave,
                       const std::vector<float>& albedos) {
    const PathOrders& law = *table.path_law;
    const int angles = 2 * law.angle_count();
    std::vector<double> scale, phase;
    for (int angle = 0; angle < angles; ++angle) {
        scale.push_back(offset_angle(law, angle));
        const double x = scale.back() - double{law.offset()};
        phase.push_back(table.phase(angle < law.angle_count() ? 1 - x : x - 1));
    }
    PathSketch sketch;
    for (int slice = first_slice(side); slice <= last_slice(side); slice += 4)
        for (int row = octave * octave_rows; row < (octave + 1) * octave_rows; row += 4)
            for (std::size_t a = 0; a < albedos.size(); a += albedos.size() / 4 + 1) {
                const auto [weights, thinner] = orders_at(row, slice, count);
                const double albedo = double{albedos[a]};
                std::vector<double>&value = sketch.values.emplace_back(),
                &importance = sketch.importance.emplace_back();
                for (int angle = 0; angle < angles; ++angle) {
                    const std::size_t k = size(angle);
                    value.push_back(albedo * albedo * along(law, angle, weights, albedo));
                    importance.push_back(
                        1 / (std::abs(value[k]) + (albedo * weights.of_order[1] * phase[k] +
                                                   double{least_filtered_light} * thinner) *
                                                      scale[k]));
                }
            }
    return sketch;
}

/// Empirical interpolation: takes what is left of the light path, at the angle, where most is.
Basis find_basis(PathSketch sketch, std::size_t functions) {
    constexpr double negligible = 1e-5;  // of the light
    Basis basis;
    while (basis.angle.size() < functions) {
        std::size_t path = 0, angle = 0;
        double most = negligible;
        for (std::size_t p = 0; p < sketch.values.size(); ++p)
            for (std::size_t k = 0; k < sketch.values[p].size(); ++k) {
                const double left = std::abs(sketch.values[p][k]) * sketch.importance[p][k];
                if (left > most) most = left, path = p, angle = k;
            }
        if (most == negligible) break;
        std::vector<double> function = sketch.values[path];
        const double pivot = function[angle];
        for (double& value : function) value /= pivot;
        const auto subtract = [&](std::vector<double>& from) {
            const double share = from[angle];
            for (std::size_t k = 0; k < from.size(); ++k) from[k] -= share * function[k];
        };
        for (std::vector<double>& value : sketch.values) subtract(value);
        basis.function.push_back(std::move(function));
        basis.angle.push_back(static_cast<int>(angle));
    }
    return basis;
}

/// The law, its orders of a table, and rows of a texture of it.
struct LawRows {
    const PathOrders& law;
    int count, octaves;
    double lost_at_one;  // what a unit of slant depth takes at albedo 1

    explicit LawRows(const TableView& table)
        : law(*table.path_law),
          count(table.highest_order > 0 ? std::min(law.order_count(), table.highest_order + 1)
                                        : law.order_count()),
          octaves(static_cast<int>(std::ceil(std::log2(1 + law.deepest() / 2)))),
          lost_at_one(14 / law.deepest()) {}

    int rows() const { return octaves * octave_rows; }

    /// The law at an angle, without the text's stratus_path_share.
    double value(int angle, int row, int slice, const PathWeights& weights, double albedo) const {
        const double lost =
            slice == slices - 1 ? 0 : slant_depth(row) * (1 - albedo + albedo * lost_at_one);
        return std::exp(lost) * along(law, angle, weights, albedo);
    }

    FilteredPath textures(std::vector<ShaderTexture> made, float unit) const {
        return {std::move(made),
                static_cast<float>(lost_at_one),
                static_cast<float>(slant_depth(rows() - 1)),
                {octave_rows, exactly(octaves), slices, unit}};
    }
};

}  // namespace

FilteredPath filtered_path(const TableView& table, const std::vector<float>& albedos) {
    const LawRows of(table);
    const int rows = of.rows(), angles = 2 * of.law.angle_count(), columns = int_size(albedos);
    std::vector<vec4> function(size(2 * of.octaves * words * angles)),
        weight(size(words * slices * rows * columns));
    for (int octave = 0; octave < of.octaves; ++octave)
        for (int side = 0; side < 2; ++side) {
            const Basis basis = find_basis(make_sketch(table, of.count, side, octave, albedos),
                                           side == STRATUS_REFLECTION ? 4 : 8);
            const int functions = int_size(basis.angle);
            for (int f = 0; f < functions; ++f) {
                const int word = (2 * octave + side) * words + f / 4;
                for (int angle = 0; angle < angles; ++angle)
                    component(function[size(word * angles + angle)], f % 4) =
                        static_cast<float>(basis.function[size(f)][size(angle)] / basis.largest(f) *
                                           double{full_scale});
            }
            for (int slice = first_slice(side); slice <= last_slice(side); ++slice)
                for (int row = octave * octave_rows; row < (octave + 1) * octave_rows; ++row) {
                    const PathWeights weights = orders_at(row, slice, of.count).weights;
                    for (int column = 0; column < columns; ++column) {
                        const std::vector<double> law = basis.weights([&](int angle) {
                            return of.value(angle, row, slice, weights,
                                            double{albedos[size(column)]});
                        });
                        for (int f = 0; f < functions; ++f) {
                            const int line = (slice * words + f / 4) * rows + row;
                            component(weight[size(line * columns + column)], f % 4) =
                                static_cast<float>(law[size(f)] * basis.largest(f));
                        }
                    }
                }
        }
    const float unit = scale_to_halves(weight) / full_scale;
    return of.textures(
        {{"stratus_path_functions", 2 * of.octaves * words, true, as_halves(function), angles},
         {"stratus_path_law", words * rows, true, as_halves(weight), columns, slices}},
        unit);
}

FilteredPath bound_path(const TableView& table, const double (&albedo)[3], int angle_step) {
    const LawRows of(table);
    const int angles = of.law.angle_count(), columns = (angles - 2) / angle_step + 2;
    std::vector<vec4> light;
    for (int slice = 0; slice < slices; ++slice)
        for (int row = 0; row < of.rows(); ++row) {
            const PathWeights weights = orders_at(row, slice, of.count).weights;
            for (int n = 0; n < 2 * columns; ++n) {
                const int angle =
                    n / columns * angles + std::min(n % columns * angle_step, angles - 1);
                vec4& texel = light.emplace_back();
                for (int c = 0; c < 3; ++c)
                    component(texel, c) =
                        static_cast<float>(of.value(angle, row, slice, weights, albedo[c]));
            }
        }
    const float unit = scale_to_halves(light);
    return of.textures(
        {{"stratus_path_law", of.rows(), true, as_halves(light), 2 * columns, slices}}, unit);
}

}  // namespace stratus
