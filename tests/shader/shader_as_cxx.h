// src/shader/lookup.shader compiled as C++, on textures in memory.
#pragma once

#include <stratus/shader/shader.h>

#include <stratus/runtime/half.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace stratus::shader {

struct vec3 {
    float x, y, z;
};

struct vec4 {
    float x, y, z, w;

    vec4() : vec4(0, 0, 0, 0) {}
    vec4(float x_, float y_, float z_, float w_) : x(x_), y(y_), z(z_), w(w_) {}
};
inline vec4 operator+(vec4 a, vec4 b) { return {a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w}; }
inline vec4 operator*(vec4 a, float b) { return {a.x * b, a.y * b, a.z * b, a.w * b}; }
inline float dot(vec4 a, vec4 b) { return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w; }

/// The textures that functions read.
struct Textures {
    std::vector<vec4> numbers, functions;

    static std::vector<vec4> texels_of(const ShaderTexture& texture) {
        const std::size_t bytes = texture.halves ? sizeof(Half) : sizeof(float);
        const auto number = [&](std::size_t n) {
            float value;
            Half half;
            if (texture.halves)
                std::memcpy(&half, texture.bytes.data() + n * bytes, bytes);
            else
                std::memcpy(&value, texture.bytes.data() + n * bytes, bytes);
            return texture.halves ? to_float(half) : value;
        };
        std::vector<vec4> texels;
        for (std::size_t n = 0; n < texture.bytes.size() / bytes; n += 4)
            texels.emplace_back(number(n), number(n + 1), number(n + 2), number(n + 3));
        return texels;
    }

    explicit Textures(const std::vector<ShaderTexture>& textures)
        : numbers(texels_of(textures[0])), functions(texels_of(textures[1])) {}
};

inline const Textures* bound = nullptr;

inline vec4 stratus_number(int texel) { return bound->numbers.at(static_cast<std::size_t>(texel)); }
inline vec4 stratus_function(int texel) {
    return bound->functions.at(static_cast<std::size_t>(texel));
}
inline float stratus_power_of_two(int n) { return std::ldexp(1.0f, n); }
inline int stratus_exponent(float x) { return std::ilogb(x); }

using std::abs, std::floor, std::max, std::min, std::sqrt;

#include "../../src/shader/lookup.shader"

}  // namespace stratus::shader
