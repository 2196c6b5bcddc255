#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/table/packed_block.h>

#include "filtered_as_cxx.h"

#include <algorithm>
#include <array>
#include <random>

namespace stratus {
namespace {

using shader::vec3, shader::vec4;

constexpr int colours = 3;

/// How much finer than the table's samples a texture is, along cosines and along the azimuth, and of the path
/// law's angles how many steps are one: as little as keeps all but one in a thousand of R and T within 2e-3.
struct Fineness {
    int cosines, azimuths, angle_step;
};
constexpr Fineness any_layer[] = {{1, 1, 1}, {2, 1, 1}, {2, 2, 1}, {3, 2, 1},
                                  {3, 3, 1}, {4, 3, 1}, {5, 4, 1}},
                   one_layer[] = {{1, 2, 4}, {2, 2, 4}, {2, 3, 4}, {2, 4, 2},
                                  {3, 4, 1}, {3, 6, 1}, {4, 6, 1}};
constexpr double most_error = 1.75e-3;  // at the points of one choice, which leaves 2e-3 at others'

/// Values of the three colours over a grid, the first axis innermost.
struct Grid {
    int count[3];
    std::vector<vec4> value;

    std::size_t stride(int axis) const {
        std::size_t product = 1;
        for (int a = 0; a < axis; ++a) product *= size(count[a]);
        return product;
    }
};

/// Sums of a block's rows, from texel `first` of the layer on, by the text without a filter: along
/// cosines and along the azimuth this many times as fine as the table's samples.
Grid block_samples(shader::AsCxx& layer, int side, int first, int finer_cosines,
                   int finer_azimuths) {
    const bool held = layer.stratus_field(side, 14).x > 0;
    const auto last = [](float of, int finer) { return static_cast<int>(of) * finer; };
    Grid grid{{last(layer.stratus_field(side, 5).z, finer_cosines) + 1,
               last(layer.stratus_field(side, 6).z, finer_cosines) + 1,
               last(layer.stratus_field(side, 7).z - 1, finer_azimuths) + 1},
              {}};
    const auto place = [](int n, int finer) { return exactly(n) / exactly(finer); };
    for (int k = 0; k < grid.count[2]; ++k)
        for (int j = 0; j < grid.count[1]; ++j)
            for (int i = 0; i < grid.count[0]; ++i)
                grid.value.push_back(
                    held ? layer.stratus_sum_at(
                               side, 1, first, 1,
                               layer.stratus_directions(
                                   side, {place(i, finer_cosines), place(j, finer_cosines),
                                          place(k, finer_azimuths)}))
                         : vec4());
    return grid;
}

/// The coefficients of the cubic spline through at least four values, one more at either end, whose
/// third derivative is continuous at the second value and at the last but one.
std::vector<vec4> spline_through(const std::vector<vec4>& value) {
    const std::size_t last = value.size() - 1;
    const auto second_coefficient = [](vec4 first, vec4 second, vec4 third) {
        return (second * 8 + (first + third) * -1) * (1.0f / 6);
    };
    std::vector<vec4> c = value;
    c[1] = second_coefficient(value[0], value[1], value[2]);
    c[last - 1] = second_coefficient(value[last], value[last - 1], value[last - 2]);
    constexpr int rounds = 40;  // each leaves at most half of what is lacking
    for (int round = 0; round < rounds; ++round)
        for (std::size_t n = 2; n + 2 <= last; ++n)
            c[n] = (value[n] * 6 + (c[n - 1] + c[n + 1]) * -1) * 0.25f;
    // Before the second value come the first and the one beyond the end, and so at the other end.
    const auto before = [](vec4 value_here, vec4 here, vec4 next) {
        return value_here * 6 + here * -4 + next * -1;
    };
    c[0] = before(value[1], c[1], c[2]);
    c[last] = before(value[last - 1], c[last - 1], c[last - 2]);
    c.insert(c.begin(), before(value[0], c[0], c[1]));
    c.push_back(before(value[last], c[last + 1], c[last]));
    return c;
}

/// Replaces the values along an axis by the coefficients of the splines through them.
void make_splines(Grid& grid, int axis) {
    const auto count = size(grid.count[axis]);
    if (count < 2) return;
    Grid splines = grid;
    splines.count[axis] += 2;
    splines.value.resize(grid.value.size() / count * (count + 2));
    const std::size_t step = grid.stride(axis);
    std::vector<vec4> value(count);
    for (std::size_t line = 0; line < grid.value.size() / count; ++line) {
        const std::size_t outer = line / step * step, inner = line % step;
        for (std::size_t n = 0; n < count; ++n)
            value[n] = grid.value[outer * count + inner + n * step];
        const std::vector<vec4> c = spline_through(value);
        for (std::size_t n = 0; n < c.size(); ++n)
            splines.value[outer * c.size() + inner + n * step] = c[n];
    }
    grid = std::move(splines);
}

struct Light {
    float single, multiple;
};

/// R and T by a text at random directions: of a bound layer in three colours, else of random albedos
/// and depths of the table.
template <class Text>
std::vector<Light> random_light(Text& text, const TableView& table, bool bound) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> cosine(0.02f, 1), azimuth(0, static_cast<float>(pi)),
        share(0, 1);
    const auto between = [&](double low, double high) {
        return static_cast<float>(low) + static_cast<float>(high - low) * share(random);
    };
    const AxisView &albedos = table.albedo, &depths = table.optical_depth;
    const double deepest = depths.highest * (depths.ends_at_infinity ? 4 : 1);
    std::vector<Light> all;
    for (int n = 0; n < 5000; ++n) {
        const float mu_in = cosine(random), mu_out = cosine(random), turn = azimuth(random);
        if (!bound) {
            const float albedo = between(albedos.lowest, albedos.highest),
                        depth =
                            depths.count > 0
                                ? std::exp(between(std::log(depths.lowest / 2), std::log(deepest)))
                                : 1e30f;
            for (const auto& of : {text.stratus_reflection(albedo, depth, mu_in, mu_out, turn),
                                   text.stratus_transmission(albedo, depth, mu_in, mu_out, turn)})
                all.push_back({of.single, of.multiple});
            continue;
        }
        for (const auto& of : {text.stratus_layer_reflection(mu_in, mu_out, turn),
                               text.stratus_layer_transmission(mu_in, mu_out, turn)})
            all.insert(all.end(), {{of.single.x, of.multiple.x},
                                   {of.single.y, of.multiple.y},
                                   {of.single.z, of.multiple.z}});
    }
    return all;
}

/// Fills in the differences to the exact light.
void measure(const std::vector<Light>& exact, const TableView& table, FilteredLight& made) {
    shader::FilteredAsCxx filtered(made);
    const std::vector<Light> found = random_light(filtered, table, made.bound);
    std::vector<double> errors{0};
    for (std::size_t n = 0; n < exact.size(); ++n) {
        const double all = double{exact[n].single} + double{exact[n].multiple};
        if (all > 0)
            errors.push_back(std::abs(double{found[n].single} + double{found[n].multiple} - all) /
                             std::max(all, made.bound ? 1e-6 : double{least_filtered_light}));
    }
    std::sort(errors.begin(), errors.end());
    made.median_error = errors[errors.size() / 2];
    made.usual_error = errors[errors.size() * 999 / 1000];
    made.worst_error = errors.back();
}

void set_texel(ShaderTexture& texture, int texel, const vec4& to) {
    const float value[] = {to.x, to.y, to.z, to.w};
    std::memcpy(texture.bytes.data() + size(texel) * sizeof value, value, sizeof value);
}

/// A block of the light: the first texel of its rows in the layer.
struct LightBlock {
    int side, first;
};

/// Texels of `light`, whose shape is filled in, the words of a block `rows` texels apart: splines along so
/// many axes, values along the others.
std::vector<vec4> spline_texels(shader::AsCxx& layer, const std::vector<LightBlock>& blocks,
                                int words, std::size_t rows, const Fineness& fineness,
                                int spline_axes, ShaderTexture& light) {
    std::vector<vec4> texels;
    for (const LightBlock& block : blocks) {
        std::vector<Grid> of_word;
        for (int word = 0; word < words; ++word) {
            of_word.push_back(block_samples(layer, block.side,
                                            block.first + word * static_cast<int>(rows),
                                            fineness.cosines, fineness.azimuths));
            for (int axis = 0; axis < spline_axes; ++axis) make_splines(of_word.back(), axis);
        }
        const Grid& first = of_word.front();
        const auto plane = static_cast<std::ptrdiff_t>(first.stride(2));
        for (int k = 0; k < first.count[2]; ++k)
            for (const Grid& grid : of_word)
                texels.insert(texels.end(), grid.value.begin() + k * plane,
                              grid.value.begin() + (k + 1) * plane);
        light = {"stratus_light", words * first.count[1],           true, {},
                 first.count[0],  int_size(blocks) * first.count[2]};
    }
    return texels;
}

/// Tries finer and finer textures, which `fill` makes, until these suffice; where the next would be too large,
/// the coarsest are left that are nearly as good as the best.
template <std::size_t count, class Fill>
void refine(const TableView& table, const std::vector<Light>& exact, FilteredLight& made,
            const Fineness (&choices)[count], const Fill& fill) {
    // A spline goes through at least four values.
    const auto least = [](int samples) { return samples > 1 && samples < 4 ? 3 : 1; };
    const int cosines = least(std::min(table.mu_in.count, table.mu_out.count)),
              azimuths = least(table.azimuth.count);
    const auto make = [&](const Fineness& choice) {
        const auto& [along_cosines, along_azimuth, angle_step] = choice;
        fill({cosines * along_cosines, azimuths * along_azimuth, angle_step});
        measure(exact, table, made);
        return made.usual_error;
    };
    constexpr double nearly = 1.25, most_bytes = 128 << 20, most_texels = 2048;  // along an axis
    std::vector<double> errors;
    for (const Fineness& choice : choices) {
        if (!errors.empty()) {
            const Fineness& before = choices[errors.size() - 1];
            const ShaderTexture& light = made.light();
            const double per_cosine = 1.0 * choice.cosines / before.cosines,
                         per_azimuth = 1.0 * choice.azimuths / before.azimuths,
                         bytes = static_cast<double>(light.bytes.size()) * per_cosine * per_cosine *
                                 per_azimuth;
            if (bytes > most_bytes ||
                std::max(light.height * per_cosine, light.depth * per_azimuth) > most_texels)
                break;
        }
        errors.push_back(make(choice));
        if (errors.back() <= most_error) return;
    }
    if (errors.size() == count) return;
    const double most = nearly * *std::ranges::min_element(errors);
    const auto coarsest = std::ranges::find_if(errors, [&](double error) { return error <= most; });
    if (coarsest + 1 != errors.end()) make(choices[coarsest - errors.begin()]);
}

/// Tells the text of its textures, in the first texels of the filter, and puts these together.
void assemble(const vec4 (&told)[4], FilteredNumbers& numbers, const ShaderTexture& second,
              const ShaderTexture& light, const FilteredPath& path, FilteredLight& made) {
    for (int k = 0; k < 4; ++k) set_texel(numbers.texture, first_filter_texel + k, told[k]);
    made.constant_numbers = numbers.constants;
    made.textures = {numbers.texture, second, light};
    made.textures.insert(made.textures.end(), path.textures.begin(), path.textures.end());
}

/// `stratus_weights`: reflection above transmission.
ShaderTexture weights_texture(const SideBlocks (&sides)[2]) {
    const std::size_t rows = filtered_words *
                             std::max(sides[0].albedos.size(), sides[1].albedos.size()),
                      width = size(std::max(sides[0].columns, sides[1].columns));
    std::vector<vec4> texels(2 * rows * width);
    for (std::size_t side = 0; side < 2; ++side)
        for (std::size_t n = 0; n < sides[side].weights.size(); ++n) {
            const auto columns = size(sides[side].columns);
            texels[(side * rows + n / columns) * width + n % columns] = sides[side].weights[n];
        }
    return {"stratus_weights", static_cast<int>(2 * rows), true, as_halves(texels),
            static_cast<int>(width)};
}

}  // namespace

FilteredLight filtered_layer(const PackedTable& table, const Medium<3>& medium) {
    const TableView view = table.view();
    FilteredLight made{};
    made.bound = true;
    shader::AsCxx layer(shader_textures(table));
    ShaderTexture texture = bound_layer(table, medium, layer);
    layer.layer = shader::to_texels(texture);
    const std::vector<Light> exact = random_light(layer, view, true);
    FilteredNumbers numbers = filtered_numbers(table, true);
    const vec4 first = layer.stratus_layer_texel(3);
    FilteredPath path{};
    int path_step = 0;
    refine(view, exact, made, one_layer, [&](const Fineness& of) {
        ShaderTexture spline;
        std::vector<vec4> light = spline_texels(layer,
                                                {{STRATUS_REFLECTION, static_cast<int>(first.x)},
                                                 {STRATUS_TRANSMISSION, static_cast<int>(first.y)}},
                                                1, 0, of, 2, spline);
        float largest[colours] = {};
        constexpr float most = 1024;  // far from both ends of halves
        for (const vec4& at : light)
            for (int c = 0; c < colours; ++c)
                largest[c] =
                    std::max({largest[c], std::abs(layer.stratus_component(at, c)), 1e-30f});
        for (vec4& at : light)
            at = {at.x / largest[0] * most, at.y / largest[1] * most, at.z / largest[2] * most, 0};
        spline.bytes = as_halves(light);
        for (int c = 0; c < colours; ++c) {
            vec4 colour = layer.stratus_layer_texel(c);
            colour.w = largest[c] / most;
            set_texel(texture, c, colour);
        }
        if (view.path_law != nullptr && path_step != of.angle_step)
            path = bound_path(view, medium.albedo, path_step = of.angle_step);
        assemble({{exactly(of.cosines), exactly(of.azimuths), 1, 1},
                  {exactly(of.angle_step), 0, 0, 0},
                  {0, 0, path.lost_at_albedo_one, path.deepest},
                  path.grid},
                 numbers, texture, spline, path, made);
    });
    return made;
}

FilteredLight filtered_layers(const PackedTable& table) {
    const TableView view = table.view();
    require(!view.is_stack(), "shader", "TABLE", "of one layer, whose depth and albedo vary",
            "a stack");
    FilteredLight made{};
    shader::AsCxx exact(shader_textures(table));
    const std::vector<Light> expected = random_light(exact, view, false);
    FilteredNumbers numbers = filtered_numbers(table, false);
    shader::AsCxx factors({numbers.texture, {}});
    const std::size_t rows = FunctionLayout(view).rows();
    const bool may_jump = view.tolerance > most_error;
    const SideBlocks sides[2] = {side_blocks(exact, factors, rows, STRATUS_REFLECTION, may_jump),
                                 side_blocks(exact, factors, rows, STRATUS_TRANSMISSION, may_jump)};
    std::vector<LightBlock> blocks;
    for (int side = 0; side < 2; ++side) {
        const SideBlocks& of = sides[side];
        for (std::size_t block = 0; block < of.blocks.size(); ++block) {
            blocks.push_back(
                {side, static_cast<int>(exact.layer.size() + block * filtered_words * rows)});
            set_texel(
                numbers.texture,
                first_filter_texel + 4 + side * most_filtered_blocks + static_cast<int>(block),
                of.blocks[block]);
        }
        exact.layer.insert(exact.layer.end(), of.rows.begin(), of.rows.end());
    }
    const SideBlocks& any = sides[sides[0].blocks.empty() ? 1 : 0];
    const ShaderTexture weights = weights_texture(sides);
    FilteredPath path{};
    if (view.path_law != nullptr) path = filtered_path(view, any.albedos);
    refine(view, expected, made, any_layer, [&](const Fineness& of) {
        ShaderTexture spline;
        const std::vector<vec4> light =
            spline_texels(exact, blocks, filtered_words, rows, of, 3, spline);
        spline.bytes = as_halves(light);
        assemble({{exactly(of.cosines), exactly(of.azimuths), exactly(sides[0].blocks.size()),
                   exactly(sides[1].blocks.size())},
                  {any.offset, any.finer_albedos, exactly(weights.width), exactly(weights.height)},
                  {sides[0].unit, sides[1].unit, path.lost_at_albedo_one, path.deepest},
                  path.grid},
                 numbers, weights, spline, path, made);
    });
    return made;
}

}  // namespace stratus
