// The text of filtered light compiled as C++, with the linear filter of a GPU.
#pragma once

#include "texture_parts.h"

#include <utility>

namespace stratus::shader {

#define STRATUS_FILTERED
#define STRATUS_FILTERED_PATH

struct FilteredAsCxx : Language {
    FilteredLight filtered;
    std::vector<std::vector<vec4>> texels;  // of its textures
    int fetches = 0;                        // since it was made

    explicit FilteredAsCxx(FilteredLight filtered_)
        : Language({filtered_.textures[0], {}, filtered_.textures[1]}),
          filtered(std::move(filtered_)) {
        for (const ShaderTexture& of : filtered.textures) texels.push_back(to_texels(of));
    }

    vec4 stratus_number(int texel) {
        fetches += texel >= filtered.constant_numbers;
        return Language::stratus_number(texel);
    }
    vec4 stratus_layer_texel(int texel) {
        fetches += texel >= filtered_layer_constants;
        return Language::stratus_layer_texel(texel);
    }
    vec4 stratus_light_at(vec3 place) { return filtered_at(2, place); }
    vec4 stratus_weights_at(float x, float y) { return filtered_at(1, {x, y, 0.5f}); }
    vec4 stratus_path_functions_at(float x, float y) { return filtered_at(3, {x, y, 0.5f}); }
    vec4 stratus_path_law_at(vec3 place) { return filtered_at(filtered.bound ? 3 : 4, place); }

    /// Filters with weights of 8 bits, as GPUs do.
    vec4 filtered_at(std::size_t texture, vec3 place) {
        const ShaderTexture& of = filtered.textures[texture];
        const int count[] = {of.width, of.height, std::max(of.depth, 1)};
        const float share[] = {place.x, place.y, place.z};
        ++fetches;
        int low[3], high[3];
        float weight[3];
        for (std::size_t a = 0; a < 3; ++a) {
            const float at = share[a] * exactly(count[a]) - 0.5f, cell = floor(at);
            low[a] = std::clamp(static_cast<int>(cell), 0, count[a] - 1);
            high[a] = std::clamp(static_cast<int>(cell) + 1, 0, count[a] - 1);
            weight[a] = std::round((at - cell) * 256) / 256;
        }
        vec4 sum;
        for (int corner = 0; corner < 8; ++corner) {
            int texel = 0;
            float product = 1;
            for (std::size_t a = 3; a-- > 0;) {
                const bool upper = (corner >> a & 1) != 0;
                texel = texel * count[a] + (upper ? high[a] : low[a]);
                product *= upper ? weight[a] : 1 - weight[a];
            }
            sum = sum + texels[texture][size(texel)] * product;
        }
        return sum;
    }

    // clang-format off
#include "single.shader"
#include "multiple.shader"
#include "layer.shader"
    // clang-format on
};

#undef STRATUS_FILTERED
#undef STRATUS_FILTERED_PATH

}  // namespace stratus::shader
