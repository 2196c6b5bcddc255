#include <stratus/shader/shader.h>

#include <stratus/base/argument.h>

#include "shader_parts.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstring>
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
#ifdef STRATUS_FILTERED
layout(set = STRATUS_SET, binding = STRATUS_BINDING + 3) uniform sampler3D stratus_light;
layout(set = STRATUS_SET, binding = STRATUS_BINDING + 4) uniform sampler2D stratus_weights;
layout(set = STRATUS_SET, binding = STRATUS_BINDING + 5) uniform sampler2D stratus_path_functions;
layout(set = STRATUS_SET, binding = STRATUS_BINDING + 6) uniform sampler3D stratus_path_law;
#endif
#else
uniform sampler2D stratus_numbers;
uniform sampler2D stratus_functions;
#ifdef STRATUS_LAYER
uniform sampler2D stratus_layer;
#endif
#ifdef STRATUS_FILTERED
// Filtered linearly, clamped to their edges.
uniform highp sampler3D stratus_light, stratus_path_law;
uniform sampler2D stratus_weights, stratus_path_functions;
#endif
#endif

#ifdef STRATUS_FILTERED
vec4 stratus_light_at(vec3 place) { return textureLod(stratus_light, place, 0.0); }
vec4 stratus_weights_at(float x, float y) { return textureLod(stratus_weights, vec2(x, y), 0.0); }
#endif
#ifdef STRATUS_FILTERED_PATH
vec4 stratus_path_functions_at(float x, float y) {
    return textureLod(stratus_path_functions, vec2(x, y), 0.0);
}
vec4 stratus_path_law_at(vec3 place) { return textureLod(stratus_path_law, place, 0.0); }
#endif
vec4 stratus_number(int texel) {
#ifdef STRATUS_FILTERED
    if (texel < STRATUS_CONSTANT_NUMBERS) return stratus_constant_numbers[texel];
#endif
    return texelFetch(stratus_numbers, ivec2(texel % WIDTH, texel / WIDTH), 0);
}
vec4 stratus_function(int texel) {
    return texelFetch(stratus_functions, ivec2(texel % WIDTH, texel / WIDTH), 0);
}
#ifdef STRATUS_LAYER
vec4 stratus_layer_texel(int texel) {
#ifdef STRATUS_FILTERED
    if (texel < 8) return stratus_constant_layer[texel];
#endif
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
#ifdef STRATUS_FILTERED
Texture3D<float4> stratus_light, stratus_path_law;
Texture2D<float4> stratus_weights, stratus_path_functions;
SamplerState stratus_linear;  // filters linearly, clamped to the edges
#endif
#endif

#ifdef STRATUS_FILTERED
float4 stratus_light_at(float3 place) {
    return stratus_light.SampleLevel(stratus_linear, place, 0);
}
float4 stratus_weights_at(float x, float y) {
    return stratus_weights.SampleLevel(stratus_linear, float2(x, y), 0);
}
#endif
#ifdef STRATUS_FILTERED_PATH
float4 stratus_path_functions_at(float x, float y) {
    return stratus_path_functions.SampleLevel(stratus_linear, float2(x, y), 0);
}
float4 stratus_path_law_at(float3 place) {
    return stratus_path_law.SampleLevel(stratus_linear, place, 0);
}
#endif
float4 stratus_number(int texel) {
#ifdef STRATUS_FILTERED
    if (texel < STRATUS_CONSTANT_NUMBERS) return stratus_constant_numbers[texel];
#endif
    return stratus_numbers.Load(int3(texel % WIDTH, texel / WIDTH, 0));
}
float4 stratus_function(int texel) {
    return stratus_functions.Load(int3(texel % WIDTH, texel / WIDTH, 0));
}
#ifdef STRATUS_LAYER
float4 stratus_layer_texel(int texel) {
#ifdef STRATUS_FILTERED
    if (texel < 8) return stratus_constant_layer[texel];
#endif
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

std::string number(float x) {  // in any locale
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, std::clamp(x, -3.4e38f, 3.4e38f),
                                std::chars_format::scientific, 8)
                      .ptr};
}

/// An array of texels, `name`.
std::string constant_texels(ShaderLanguage language, const std::string& name,
                            const ShaderTexture& texture, int texels) {
    const std::string count = std::to_string(texels);
    const bool hlsl_text = language == ShaderLanguage::hlsl;
    std::string text = hlsl_text ? "static const float4 " + name + "[" + count + "] = {\n"
                                 : "const vec4 " + name + "[" + count + "] = vec4[](\n";
    for (int n = 0; n < texels; ++n) {
        float at[4];
        std::memcpy(at, texture.bytes.data() + static_cast<std::size_t>(n) * sizeof at, sizeof at);
        text += std::string(n == 0 ? "" : ",\n") + "    " + (hlsl_text ? "float4(" : "vec4(") +
                joined({number(at[0]), number(at[1]), number(at[2]), number(at[3])}) + ")";
    }
    return text + (hlsl_text ? "};\n\n" : ");\n\n");
}

/// The beginning of the C++ header.
constexpr const char* cpp =
    R"(// Stratus: lookups in packed tables (.stratus), and layers bound from them, in C++17 alone.
//
//   #include "stratus_lookup.h"
//   const stratus_lookup::Table table("saturn_rings.stratus");
//   const float r = table.reflection(albedo, optical_depth, mu_in, mu_out, azimuth).total();
//   const stratus_lookup::Layer layer(table, {1.5f, 1.5f, 1.5f}, {0.95f, 0.93f, 0.8f});
//   const stratus_lookup::Sample drawn = layer.sample(wo, u1, u2, u3);
//
// R = 1 is a white Lambert surface: BRDF = R / pi. Classes Table and Layer, at the end, say the rest.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <locale>
#include <map>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace stratus_lookup {

)";

constexpr const char* cpp_text = R"(
enum { STRATUS_REFLECTION, STRATUS_TRANSMISSION };
/// The text that is GLSL, HLSL and OSL as well: src/shader/*.shader of Stratus, where its comments are.
struct Text {
    const Texels* table;
    const std::vector<vec4>* layer;

    static vec4 texel(const std::vector<vec4>& of, int n) {
        return std::size_t(n) < of.size() ? of[std::size_t(n)] : vec4();
    }
    vec4 stratus_number(int n) { return texel(table->numbers, n); }
    vec4 stratus_function(int n) { return texel(table->functions, n); }
    vec4 stratus_layer_texel(int n) { return texel(*layer, n); }
    float stratus_power_of_two(int n) { return std::ldexp(1.0f, n); }
    int stratus_exponent(float x) { return (to_bits(x) >> 23) - 127; }

    struct StratusAttenuation {
        float transmitted, extinguished;  // exp(-x), 1 - exp(-x)
    };
    StratusAttenuation stratus_attenuation(float x) { return {std::exp(-x), -std::expm1(-x)}; }
    float stratus_transmitted(float x) { return std::exp(-x); }
    float stratus_extinguished(float x) { return -std::expm1(-x); }
    float stratus_log2(float x) { return std::log2(x); }
    float stratus_twice_arcsine(float z) { return 2 * std::asin(sqrt(z)); }
    float stratus_sine_squared(float x) { return std::pow(std::sin(x * 1.57079633f), 2.0f); }
    float stratus_clamp(float x, float low, float high) { return max(min(x, high), low); }

)";

/// The text without comments and conditions, elementary functions, which C++ has itself, and functions that
/// the header's classes do not call.
std::string cpp_header(std::string text) {
    const std::size_t elementary = text.find("// ---- elementary functions");
    text.erase(elementary, text.find("// ---- ", elementary + 1) - elementary);
    for (std::size_t at = 0; (at = text.find("#ifdef STRATUS_FILTERED")) != std::string::npos;) {
        const std::size_t other = text.find("#else\n", at);
        text.erase(text.find("#endif\n", other), 7);
        text.erase(at, other + 6 - at);
    }
    text = std::regex_replace(
        text, std::regex("(^|\\n)( *(//[^\\n]*|#(ifdef|endif|define)[^\\n]*)?\\n)+"), "$1");
    for (const char* const uncalled :
         {" stratus_reflection(", " stratus_transmission(", " stratus_single(", " stratus_phase(",
          " stratus_effective_depth(", " stratus_bsdf_rgb(", " stratus_filter(", " stratus_hapke(",
          " stratus_layer_reflection(", " stratus_layer_transmission("}) {
        const std::size_t line = text.rfind('\n', text.find(uncalled));
        text.erase(line, text.find("\n}\n", line) + 2 - line);
    }
    const std::string classes =
        std::string(vectors_h) + reader_h + cpp_text + text + "};\n" + lookup_h;
    return cpp + std::regex_replace(classes, std::regex("\n\n+"), "\n") +
           "}  // namespace stratus_lookup\n";
}

}  // namespace

const std::vector<std::string>& shader_language_names() {
    static const std::vector<std::string> names{"glsl", "hlsl", "osl", "cpp"};
    return names;
}

std::string shader_text(ShaderLanguage language, const FilteredLight* filtered) {
    const auto place = static_cast<std::size_t>(language);
    require(filtered == nullptr || language < ShaderLanguage::osl, "shader", "--filtered",
            "with glsl or hlsl", shader_language_names()[place]);
    const char* const own[] = {glsl, hlsl, osl};
    std::string text;
    for (const char* const part : {single_shader, multiple_shader, layer_shader}) text += part;
    if (language == ShaderLanguage::cpp) return cpp_header(text);
    if (language == ShaderLanguage::osl)  // numbers have no suffix there
        text = std::regex_replace(text, std::regex("([0-9])f\\b"), "$1");
    const std::size_t first_blank = text.find("\n\n") + 2;
    std::string before = text.substr(0, first_blank),
                own_text = std::regex_replace(own[place], std::regex("WIDTH"),
                                              std::to_string(shader_texture_width));
    if (filtered != nullptr) {
        if (filtered->bound)
            before +=
                "// This text has the light of the bound layer alone: call only stratus_layer_...\n"
                "#ifndef STRATUS_LAYER\n#define STRATUS_LAYER\n#endif\n";
        if (filtered->textures.size() > 3) before += "#define STRATUS_FILTERED_PATH\n";
        before += "#define STRATUS_FILTERED\n#define STRATUS_CONSTANT_NUMBERS " +
                  std::to_string(filtered->constant_numbers) + "\n\n";
        std::string constants = constant_texels(language, "stratus_constant_numbers",
                                                filtered->textures[0], filtered->constant_numbers);
        if (filtered->bound)
            constants += constant_texels(language, "stratus_constant_layer", filtered->textures[1],
                                         filtered_layer_constants);
        own_text.insert(own_text.find("\n\n") + 2, constants);  // after the precision
    }
    return "#ifndef STRATUS_INCLUDED\n#define STRATUS_INCLUDED\n" + before + own_text +
           text.substr(first_blank) + "\n#endif  // STRATUS_INCLUDED\n";
}

}  // namespace stratus
