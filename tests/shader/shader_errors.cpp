// Prints how far shaders are from the C++ runtime for a table, the figures of docs/shaders.md:
//
//     shader_errors TABLE.stratus
//
// 10,000 random lookups on both sides, by the text as C++ and by headless Chromium, and with filtered
// textures by the latter, relative to no less than 1e-4.
#include "as_cxx.h"
#include "browser.h"
#include "lookups.h"

#include <exception>
#include <iostream>
#include <string>
#include <vector>

int main(int argc, char** argv) {
    using namespace stratus;
    try {
        if (argc != 2) throw std::invalid_argument("one argument is needed: TABLE.stratus");
        const PackedTable table{std::string(argv[1])};
        const std::vector<ShaderTexture> textures = shader_textures(table);
        for (const ShaderTexture& of : textures)
            std::cout << of.name << ": " << shader_texture_width << " x " << of.height
                      << (of.halves ? " halves\n" : " floats\n");
        const std::vector<test::Lookup> lookups = test::random_lookups(table, 10000);
        const std::vector<test::Light> expected = test::by_runtime(table, lookups);
        shader::AsCxx shader(textures);
        std::vector<test::Light> found;
        for (const auto& [w, tau, mu_in, mu_out, azimuth] : lookups) {
            const auto r = shader.stratus_reflection(w, tau, mu_in, mu_out, azimuth),
                       t = shader.stratus_transmission(w, tau, mu_in, mu_out, azimuth);
            found.push_back({r.single, r.multiple, t.single, t.multiple});
        }
        std::cout << "C++: " << test::differences(found, expected) << '\n'
                  << "GLSL: " << test::differences(test::by_browser(textures, lookups), expected)
                  << '\n';
        if (table.view().is_stack()) return 0;
        const FilteredLight filtered = filtered_layers(table);
        for (const ShaderTexture& of : filtered.textures)
            std::cout << of.name << ": " << of.width << " x " << of.height << " x " << of.depth
                      << ", " << static_cast<double>(of.bytes.size()) / 1e6 << " MB\n";
        std::cout << "filtered C++: " << filtered.median_error << ' ' << filtered.usual_error << ' '
                  << filtered.worst_error << "\nfiltered GLSL: "
                  << test::differences(
                         test::by_browser(filtered.textures, lookups, test::both_sides, &filtered),
                         expected, 1e-4)
                  << '\n';
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "shader_errors: " << error.what() << '\n';
        return 1;
    }
}
