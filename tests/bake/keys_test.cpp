#include <stratus/bake/toml_section.h>

#include <stratus/bake/recipe.h>
#include <stratus/bake/stack_file.h>

#include "keyed_file.h"
#include "refusal.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace stratus::test {
namespace {

/// Lines of keys that recipes and stacks share.
const KeyedFile::Lines shared_lines{{"mu_in.min", "0.25"},
                                    {"mu_in.max", "0.5"},
                                    {"mu_out.min", "0.25"},
                                    {"mu_out.max", "0.5"},
                                    {"azimuth_deg.min", "30"},
                                    {"azimuth_deg.max", "60"},
                                    {"sides", "['reflection', 'transmission']"},
                                    {"discretisation.nodes", "8"},
                                    {"discretisation.modes", "8"},
                                    {"discretisation.mu_samples", "8"},
                                    {"discretisation.azimuth_samples", "8"},
                                    {"discretisation.azimuth_scale", "'linear'"}};

/// A file over a surface, and over each other ground.
std::vector<KeyedFile> over_grounds(const KeyedFile& file) {
    return {file.with("below.lambert_albedo", "0.3"),
            file.with("below.phase_function", "'rayleigh'").with("below.albedo", "0.5"),
            file.with("below.ground", "'ocean:wind=5'")};
}

TEST(RecipeKeys, AreAllRead) {
    const KeyedFile layer =
        KeyedFile({{"title", "'Rings'"},
                   {"phase_function", "'isotropic'"},
                   {"second_phase_function", "'rayleigh'"},
                   {"mixture.min", "0.25"},
                   {"mixture.max", "0.5"},
                   {"tolerance", "1e-3"},
                   {"optical_depth.min", "0.5"},
                   {"optical_depth.max", "inf"},
                   {"albedo.min", "0.5"},
                   {"albedo.max", "1.0"},
                   {"orders", "3"},
                   {"discretisation.optical_depth_samples_per_octave", "2"},
                   {"discretisation.deepest_optical_depth", "8"},
                   {"discretisation.albedo_samples", "8"},
                   {"discretisation.albedo_scale", "'square_root_of_complement'"},
                   {"discretisation.mixture_samples", "8"},
                   {"discretisation.scheme", "'harmonic'"}})
            .with(shared_lines);
    const KeyedFile ground({{"phase_function", "'isotropic'"},
                            {"tolerance", "1e-3"},
                            {"optical_depth.min", "0.5"},
                            {"optical_depth.max", "inf"},
                            {"albedo.min", "0.5"},
                            {"albedo.max", "1.0"}});
    const KeyedFile two = ground.with("phase_function", "'henyey_greenstein:g=0.5'")
                              .with("second_phase_function", "'isotropic'");
    const KeyedFile droplets = ground.with("phase_function", "'mie:radius=1um'");
    const KeyedFile lobe = two.with("family.mixture", "[0.25, 0.5]")
                               .with("family.g", "[0.25, 0.5]")
                               .with("discretisation.g_samples", "4");
    const KeyedFile lobes =
        two.with("family.mixture.values", "[0.25, 0.5]").with("family.g.values", "[0.25, 0.5]");
    const KeyedFile cloud = droplets.with("family.radius", "['1um', '2um']")
                                .with("family.wavelength", "['500nm', '0.6um']")
                                .with("discretisation.radius_samples", "4")
                                .with("discretisation.wavelength_samples", "4");
    const KeyedFile clouds = droplets.with("family.radius.values", "['1um', '2um']")
                                 .with("family.wavelength.values", "['500nm', '0.6um']");
    const KeyedFile spread = droplets.with("family.variance", "[0.05, 0.1]")
                                 .with("discretisation.variance_samples", "4");
    const KeyedFile spreads = droplets.with("family.variance.values", "[0.05, 0.1]");
    std::vector<KeyedFile> files = over_grounds(ground);
    files.insert(files.end(), {layer, lobe, lobes, cloud, clouds, spread, spreads});
    expect_keys_are_read(
        recipe_keys(), "recipe", files, [](const std::string& text) { parse_recipe(text); },
        &Key::name);
}

TEST(StackKeys, OfLayersAreAllRead) {
    const KeyedFile::Lines layer{
        {"phase_function", "'isotropic'"}, {"albedo", "0.5"}, {"optical_depth", "1"}};
    for (const Key& key : stack_keys()) {
        if (!std::string(key.name).starts_with("layers.")) continue;
        const std::string dated = KeyedFile(layer).with(key.own_name(), "1979-05-27").text();
        expect_refusal([&] { parse_stack("[[layers]]\n" + dated); },
                       {"stack: line 4: layer 1." + key.own_name() + " must be "});
    }
}

TEST(StackKeys, AreAllRead) {
    // The tables [[layers]] have a test of their own; the first lines here end them.
    const std::pair<std::string, std::string> layers{
        "layers", "[{ phase_function = 'isotropic', albedo = 0.5, optical_depth = 1.0 }]"};
    const KeyedFile stack =
        KeyedFile({{"title", "'Haze'"}, layers, {"tolerance", "1e-2"}}).with(shared_lines);
    std::vector<KeyedFile> files = over_grounds(KeyedFile({layers}));
    files.push_back(stack);
    expect_keys_are_read(
        stack_keys(), "recipe", files, [](const std::string& text) { parse_recipe(text); },
        [](const Key& key) {
            const std::string name = key.name;
            return name.starts_with("layers.") ? "" : name;
        });
}

TEST(KeyColumns, AreSeparatedByTwoBlanks) {
    const Key keys[] = {{"long_name", "number", "-", "[0, 1]", "1", "first"},
                        {"camera.x", "table", "-", "-", "(none)", "second one"}};
    EXPECT_EQ(key_columns(keys),
              "key        form    unit  range   default  meaning\n"
              "long_name  number  -     [0, 1]  1        first\n"
              "camera.x   table   -     -       (none)   second one\n");
}

}  // namespace
}  // namespace stratus::test
