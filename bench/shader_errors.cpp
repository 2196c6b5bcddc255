// Prints how far shaders are from the C++ runtime for a table, the figures of docs/shaders.md:
//
//     shader_errors TABLE.stratus
//
// 10,000 random lookups on both sides, by the text as C++ and by headless Chromium, and with filtered
// textures by the latter, relative to no less than 1e-4. Then the layer of depth 1 and albedo 0.95, or what the
// table has nearest to it, bound and filtered, relative to no less than 1e-6.
#include "browser.h"
#include "filtered_as_cxx.h"
#include "lookups.h"
#include "texture_parts.h"

#include <algorithm>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

namespace stratus {
namespace {

std::ostream& operator<<(std::ostream& out, const test::Differences& of) {
    return out << "median " << of.median << ", 99.9 % " << of.usual << ", worst " << of.worst;
}

std::ostream& operator<<(std::ostream& out, const std::vector<ShaderTexture>& textures) {
    for (const ShaderTexture& of : textures)
        out << of.name << ": " << of.width << " x " << of.height << " x " << of.depth << ", "
            << static_cast<double>(of.bytes.size()) / 1e6 << " MB\n";
    return out;
}

void print_bound(const PackedTable& table, std::vector<test::Lookup> lookups) {
    const TableView view = table.view();
    const float albedo = std::clamp(0.95f, static_cast<float>(view.albedo.lowest),
                                    static_cast<float>(view.albedo.highest)),
                depth = view.optical_depth.count == 0
                            ? static_cast<float>(infinity)
                            : std::clamp(1.0f, static_cast<float>(view.optical_depth.lowest),
                                         static_cast<float>(view.optical_depth.highest));
    for (test::Lookup& at : lookups) at.albedo = albedo, at.optical_depth = depth;
    Medium<3> medium;
    for (int c = 0; c < 3; ++c) medium.albedo[c] = albedo, medium.optical_depth[c] = depth;
    const FilteredLight bound = filtered_layer(table, medium);
    shader::FilteredAsCxx text(bound);
    int most[4] = {};
    const auto count = [&](int k, const auto& call) {
        text.fetches = 0;
        call();
        most[k] = std::max(most[k], text.fetches);
    };
    for (const test::Lookup& at : lookups) {
        const shader::vec3 wi{std::sqrt((1 - at.mu_in) * (1 + at.mu_in)), 0, at.mu_in},
            wo{0, std::sqrt((1 - at.mu_out) * (1 + at.mu_out)), at.mu_out};
        count(0, [&] { text.stratus_layer_reflection(at.mu_in, at.mu_out, at.azimuth); });
        count(1, [&] { text.stratus_layer_transmission(at.mu_in, at.mu_out, at.azimuth); });
        count(2, [&] { text.stratus_layer_sample(wi, at.mu_out, at.azimuth / 7, 0.5f); });
        count(3, [&] { text.stratus_layer_pdf(wi, wo); });
    }
    std::cout << "bound:\n" << bound.textures << "fetches of R, T, _sample, _pdf:";
    for (const int fetches : most) std::cout << ' ' << fetches;
    std::cout << "\nfiltered C++: " << bound.median_error << ' ' << bound.usual_error << ' '
              << bound.worst_error << "\nfiltered GLSL: "
              << test::differences(test::by_browser(bound.textures, lookups, R"glsl(
        StratusColours r = stratus_layer_reflection(along.x, along.y, along.z);
        StratusColours t = stratus_layer_transmission(along.x, along.y, along.z);
        light = vec4(r.single.x, r.multiple.x, t.single.x, t.multiple.x);
)glsl",
                                                    &bound),
                                   test::by_runtime(table, lookups))
              << '\n';
}

}  // namespace
}  // namespace stratus

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
        std::cout << filtered.textures << "filtered C++: " << filtered.median_error << ' '
                  << filtered.usual_error << ' ' << filtered.worst_error << "\nfiltered GLSL: "
                  << test::differences(
                         test::by_browser(filtered.textures, lookups, test::both_sides, &filtered),
                         expected, 1e-4)
                  << '\n';
        print_bound(table, lookups);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "shader_errors: " << error.what() << '\n';
        return 1;
    }
}
