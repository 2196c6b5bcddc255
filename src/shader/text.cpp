#include <stratus/shader/shader.h>

#include "shader_parts.h"

#include <cstddef>
#include <regex>

namespace stratus {
namespace {

// Differences between the languages: types, how a texel is fetched, 2^n and the exponent of a float.

constexpr const char* glsl = R"(#ifdef GL_ES
precision highp float;
precision highp int;
precision highp sampler2D;
#endif

// Textures of WIDTH columns, to be fetched without filtering.
#ifdef VULKAN
#ifndef STRATUS_SET
#define STRATUS_SET 0
#endif
#ifndef STRATUS_BINDING
#define STRATUS_BINDING 0
#endif
layout(set = STRATUS_SET, binding = STRATUS_BINDING) uniform sampler2D stratus_numbers;
layout(set = STRATUS_SET, binding = STRATUS_BINDING + 1) uniform sampler2D stratus_functions;
#ifdef STRATUS_LAYER
layout(set = STRATUS_SET, binding = STRATUS_BINDING + 2) uniform sampler2D stratus_layer;
#endif
#else
uniform sampler2D stratus_numbers;
uniform sampler2D stratus_functions;
#ifdef STRATUS_LAYER
uniform sampler2D stratus_layer;
#endif
#endif

vec4 stratus_number(int texel) {
    return texelFetch(stratus_numbers, ivec2(texel % WIDTH, texel / WIDTH), 0);
}
vec4 stratus_function(int texel) {
    return texelFetch(stratus_functions, ivec2(texel % WIDTH, texel / WIDTH), 0);
}
#ifdef STRATUS_LAYER
vec4 stratus_layer_texel(int texel) {
    return texelFetch(stratus_layer, ivec2(texel % WIDTH, texel / WIDTH), 0);
}
#endif
float stratus_power_of_two(int n) { return intBitsToFloat((n + 127) << 23); }
int stratus_exponent(float x) { return (floatBitsToInt(x) >> 23) - 127; }

)";

constexpr const char* hlsl = R"(#define vec3 float3
#define vec4 float4

// Textures of WIDTH columns; declare them yourself where STRATUS_TEXTURES is defined.
#ifndef STRATUS_TEXTURES
Texture2D<float4> stratus_numbers;
Texture2D<float4> stratus_functions;
#ifdef STRATUS_LAYER
Texture2D<float4> stratus_layer;
#endif
#endif

float4 stratus_number(int texel) {
    return stratus_numbers.Load(int3(texel % WIDTH, texel / WIDTH, 0));
}
float4 stratus_function(int texel) {
    return stratus_functions.Load(int3(texel % WIDTH, texel / WIDTH, 0));
}
#ifdef STRATUS_LAYER
float4 stratus_layer_texel(int texel) {
    return stratus_layer.Load(int3(texel % WIDTH, texel / WIDTH, 0));
}
#endif
float stratus_power_of_two(int n) { return asfloat((n + 127) << 23); }
int stratus_exponent(float x) { return (asint(x) >> 23) - 127; }

)";

constexpr const char* osl = R"(#include "vector4.h"

#define vec3 vector
#define vec4 vector4
#define bool int

// Textures of WIDTH columns; their heights and paths come from stratus_textures.h, or from you.
#ifndef STRATUS_NUMBERS
#include "stratus_textures.h"
#endif

vector4 stratus_texel(string file, int texel, int height) {
    int row = texel / WIDTH;
    float a = 0.0;
    color rgb = texture(file, (float(texel - row * WIDTH) + 0.5) / float(WIDTH),
                        (float(row) + 0.5) / float(height), "interp", "closest", "wrap", "clamp",
                        "alpha", a);
    return vector4(rgb[0], rgb[1], rgb[2], a);
}
vector4 stratus_number(int texel) {
    return stratus_texel(STRATUS_NUMBERS, texel, STRATUS_NUMBERS_HEIGHT);
}
vector4 stratus_function(int texel) {
    return stratus_texel(STRATUS_FUNCTIONS, texel, STRATUS_FUNCTIONS_HEIGHT);
}
#ifdef STRATUS_LAYER
vector4 stratus_layer_texel(int texel) {
    return stratus_texel(STRATUS_LAYER_FILE, texel, STRATUS_LAYER_HEIGHT);
}
#endif
float stratus_power_of_two(int n) { return pow(2.0, float(n)); }
int stratus_exponent(float x) { return int(floor(log2(x))); }

)";

std::string with_width(std::string text) {
    const std::string from = "WIDTH";
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos;)
        text.replace(at, from.size(), std::to_string(shader_texture_width));
    return text;
}

}  // namespace

const std::vector<std::string>& shader_language_names() {
    static const std::vector<std::string> names{"glsl", "hlsl", "osl"};
    return names;
}

std::string shader_text(ShaderLanguage language) {
    const char* const own[] = {glsl, hlsl, osl};
    std::string text;
    for (const char* const part : shader_parts) text += part;
    if (language == ShaderLanguage::osl)  // numbers have no suffix there
        text = std::regex_replace(text, std::regex("([0-9])f\\b"), "$1");
    const std::size_t first_blank = text.find("\n\n") + 2;
    return "#ifndef STRATUS_INCLUDED\n#define STRATUS_INCLUDED\n" + text.substr(0, first_blank) +
           with_width(own[static_cast<int>(language)]) + text.substr(first_blank) +
           "\n#endif  // STRATUS_INCLUDED\n";
}

}  // namespace stratus
