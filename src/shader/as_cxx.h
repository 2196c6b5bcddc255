// src/shader/*.shader compiled as C++, on textures in memory.
#pragma once

#include <stratus/base/half.h>
#include <stratus/shader/shader.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <vector>

namespace stratus::shader {

#include "cpp/vectors.h.in"

using std::abs, std::floor, std::max, std::min, std::sqrt;

inline std::vector<vec4> to_texels(const std::vector<char>& bytes, bool halves) {
    const std::size_t width = halves ? sizeof(Half) : sizeof(float);
    const auto number = [&](std::size_t n) {
        float value = 0;
        Half half{};
        if (halves)
            std::memcpy(&half, bytes.data() + n * width, width);
        else
            std::memcpy(&value, bytes.data() + n * width, width);
        return halves ? to_float(half) : value;
    };
    std::vector<vec4> texels;
    for (std::size_t n = 0; n < bytes.size() / width; n += 4)
        texels.emplace_back(number(n), number(n + 1), number(n + 2), number(n + 3));
    return texels;
}

#define STRATUS_LAYER

/// The textures that the functions read, and what a language has of its own.
struct Language {
    std::vector<vec4> numbers, functions, layer;

    explicit Language(const std::vector<ShaderTexture>& textures)
        : numbers(to_texels(textures[0].bytes, textures[0].halves)),
          functions(to_texels(textures[1].bytes, textures[1].halves)) {
        if (textures.size() > 2) layer = to_texels(textures[2].bytes, textures[2].halves);
    }

    vec4 stratus_number(int texel) { return numbers.at(static_cast<std::size_t>(texel)); }
    vec4 stratus_function(int texel) { return functions.at(static_cast<std::size_t>(texel)); }
    vec4 stratus_layer_texel(int texel) { return layer.at(static_cast<std::size_t>(texel)); }
    float stratus_power_of_two(int n) { return std::ldexp(1.0f, n); }
    int stratus_exponent(float x) { return std::ilogb(x); }
};

/// The functions.
struct AsCxx : Language {
    using Language::Language;

    // clang-format off
#include "single.shader"
#include "multiple.shader"
#include "layer.shader"
    // clang-format on
};

}  // namespace stratus::shader
