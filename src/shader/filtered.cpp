#include <stratus/shader/shader.h>

#include <stratus/base/constants.h>
#include <stratus/base/half.h>

#include "bound_layer.h"
#include "filtered_as_cxx.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <random>
#include <vector>

namespace stratus {
namespace {

using shader::vec3, shader::vec4;

constexpr int colours = 3, record_texels = 32, texels_of_stacked_layer = 4;

/// How much finer than the table's samples a texture is, along cosines and along the azimuth: as little
/// as keeps all but one in a thousand of R and T within `target`.
constexpr int finer[][2] = {{1, 1}, {2, 1}, {2, 2}, {3, 2}, {3, 3}};
constexpr double target = 2e-3;

/// Values of the three colours over a grid, the first axis innermost.
struct Grid {
    int count[3];
    std::vector<vec4> value;

    std::size_t stride(int axis) const {
        std::size_t product = 1;
        for (int a = 0; a < axis; ++a) product *= static_cast<std::size_t>(count[a]);
        return product;
    }
};

/// Orders n >= 2 of a side by the text without a filter: along cosines and along the azimuth this many
/// times as fine as the table's samples.
Grid samples_of(shader::AsCxx& layer, int side, int finer_cosines, int finer_azimuths) {
    const vec4 first = layer.stratus_layer_texel(3);
    const int block = static_cast<int>(side == STRATUS_REFLECTION ? first.x : first.y);
    const bool held = layer.stratus_field(side, 14).x > 0;
    const auto last = [](float of, int finer) { return static_cast<int>(of) * finer; };
    Grid grid{{last(layer.stratus_field(side, 5).z, finer_cosines) + 1,
               last(layer.stratus_field(side, 6).z, finer_cosines) + 1,
               last(layer.stratus_field(side, 7).z - 1, finer_azimuths) + 1},
              {}};
    const auto place = [](int n, int finer) {
        return static_cast<float>(n) / static_cast<float>(finer);
    };
    for (int k = 0; k < grid.count[2]; ++k)
        for (int j = 0; j < grid.count[1]; ++j)
            for (int i = 0; i < grid.count[0]; ++i)
                grid.value.push_back(
                    held ? layer.stratus_sum_at(
                               side, 1, block, 1,
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
    const auto second_of = [](vec4 first, vec4 second, vec4 third) {
        return (second * 8 + (first + third) * -1) * (1.0f / 6);
    };
    std::vector<vec4> c = value;
    c[1] = second_of(value[0], value[1], value[2]);
    c[last - 1] = second_of(value[last], value[last - 1], value[last - 2]);
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
    const auto count = static_cast<std::size_t>(grid.count[axis]);
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

/// A random direction, and R and T of the colours there by the text without a filter.
struct ExactLight {
    float mu_in, mu_out, azimuth;
    shader::AsCxx::StratusColours reflection, transmission;
};

std::vector<ExactLight> exact_light(shader::AsCxx& layer) {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> cosine(0.02f, 1), azimuth(0, static_cast<float>(pi));
    std::vector<ExactLight> all(2000);
    for (ExactLight& at : all) {
        at.mu_in = cosine(random);
        at.mu_out = cosine(random);
        at.azimuth = azimuth(random);
        at.reflection = layer.stratus_layer_reflection(at.mu_in, at.mu_out, at.azimuth);
        at.transmission = layer.stratus_layer_transmission(at.mu_in, at.mu_out, at.azimuth);
    }
    return all;
}

/// Fills in the differences to the exact light.
void measure(const std::vector<ExactLight>& exact, FilteredLayer& made) {
    shader::FilteredAsCxx filtered(made);
    std::vector<double> errors{0};
    const auto compare = [&](const auto& found, const auto& expected) {
        const auto add = [&](float off, float all) {
            if (all > 0) errors.push_back(double{std::abs(off)} / std::max(double{all}, 1e-6));
        };
        add(found.multiple.x - expected.multiple.x, expected.single.x + expected.multiple.x);
        add(found.multiple.y - expected.multiple.y, expected.single.y + expected.multiple.y);
        add(found.multiple.z - expected.multiple.z, expected.single.z + expected.multiple.z);
    };
    for (const ExactLight& at : exact) {
        compare(filtered.stratus_layer_reflection(at.mu_in, at.mu_out, at.azimuth), at.reflection);
        compare(filtered.stratus_layer_transmission(at.mu_in, at.mu_out, at.azimuth),
                at.transmission);
    }
    std::sort(errors.begin(), errors.end());
    made.median_error = errors[errors.size() / 2];
    made.usual_error = errors[errors.size() * 999 / 1000];
    made.worst_error = errors.back();
}

/// Fills in the texture.
void fill(FilteredLayer& made, shader::AsCxx& layer, int finer_cosines, int finer_azimuths) {
    std::vector<vec4> light;
    for (const int side : {STRATUS_REFLECTION, STRATUS_TRANSMISSION}) {
        Grid grid = samples_of(layer, side, finer_cosines, finer_azimuths);
        for (int axis = 0; axis < 3; ++axis) make_splines(grid, axis);
        light.insert(light.end(), grid.value.begin(), grid.value.end());
        made.width = grid.count[0];
        made.height = grid.count[1];
        made.depth = 2 * grid.count[2];
    }

    float largest[colours] = {};
    for (const vec4& at : light)
        for (int c = 0; c < colours; ++c)
            largest[c] = std::max(largest[c], std::abs(layer.stratus_component(at, c)));
    std::vector<Half> halves;
    constexpr float most = 1024;  // far from both ends of halves
    for (const vec4& at : light) {
        for (int c = 0; c < colours; ++c)
            halves.push_back(
                to_half(largest[c] > 0 ? layer.stratus_component(at, c) / largest[c] * most : 0));
        halves.push_back(to_half(0));
    }
    made.bytes.resize(halves.size() * sizeof(Half));
    std::memcpy(made.bytes.data(), halves.data(), made.bytes.size());

    const auto set = [&](std::size_t texel, std::size_t component, float value) {
        std::memcpy(made.layer.bytes.data() + (4 * texel + component) * sizeof value, &value,
                    sizeof value);
    };
    for (std::size_t c = 0; c < colours; ++c) set(c, 3, largest[c] / most);
    set(5, 2, static_cast<float>(finer_cosines));
    set(5, 3, static_cast<float>(finer_azimuths));
}

}  // namespace

FilteredLayer filtered_layer(const PackedTable& table, const Medium<3>& medium) {
    const TableView view = table.view();
    FilteredLayer made{};
    shader::AsCxx layer(shader_textures(table));
    made.layer = bound_layer(table, medium, layer);
    layer.layer = shader::texels_of(made.layer.bytes, made.layer.halves);
    const std::vector<ExactLight> exact = exact_light(layer);
    PathSheet path;
    if (view.path_law != nullptr)
        path = PathSheet(*view.path_law, medium.albedo, colours, view.highest_order);
    made.numbers = bound_numbers(table, path);
    made.constant_numbers =
        record_texels +
        texels_of_stacked_layer * (view.is_stack() ? static_cast<int>(view.layers->size()) : 0);
    // A spline goes through at least four values.
    const auto least = [](int samples) { return samples > 1 && samples < 4 ? 3 : 1; };
    const int cosines = least(std::min(view.mu_in.count, view.mu_out.count)),
              azimuths = least(view.azimuth.count);
    for (const auto& [along_cosines, along_azimuth] : finer) {
        fill(made, layer, cosines * along_cosines, azimuths * along_azimuth);
        measure(exact, made);
        if (made.usual_error <= target) break;
    }
    return made;
}

}  // namespace stratus
