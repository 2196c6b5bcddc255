#include <stratus/scene/scene.h>

#include <stratus/picture/png.h>

#include "keyed_file.h"
#include "temporary_folder.h"
#include "small_scene.h"

#include <gtest/gtest.h>

#include <string>

namespace stratus::test {
namespace {

const KeyedFile slab({{"title", "'Clouds'"},
                      {"tolerance", "1e-2"},
                      {"effects", "['-multiple']"},
                      {"columns", "1"},
                      {"panels", "[{ title = 'first' }]"},
                      {"animation.frames", "1"},
                      {"animation.keys", "[{ frame = 0 }]"},
                      {"picture.width", "8"},
                      {"picture.height", "8"},
                      {"picture.samples", "1"},
                      {"picture.white", "1.0"},
                      {"camera.look_at", "[0, 0, 1]"},
                      {"camera.distance", "4"},
                      {"camera.elevation_deg", "30"},
                      {"camera.azimuth_deg", "30"},
                      {"camera.field_of_view_deg", "30"},
                      {"sun.elevation_deg", "30"},
                      {"sun.azimuth_deg", "30"},
                      {"sun.angular_diameter_deg", "1"},
                      {"sun.colour", "[1.0, 0.5, 0.25]"},
                      {"sun.visible", "false"},
                      {"background.colour", "0.5"},
                      {"layer.phase_function", "'isotropic'"},
                      {"layer.albedo", "0.5"},
                      {"layer.density", "0.1"},
                      {"layer.optical_depth.clouds", "true"},
                      {"layer.optical_depth.most", "4"},
                      {"layer.optical_depth.scale", "2"},
                      {"layer.optical_depth.coverage", "0.4"},
                      {"layer.optical_depth.seed", "3"},
                      {"layer.optical_depth.offset", "[0, 0, 1]"},
                      {"layer.opposition.law", "'hapke'"},
                      {"layer.opposition.amplitude", "0.5"},
                      {"layer.opposition.width", "0.1"},
                      {"slab.surface", "0.5"},
                      {"slab.height", "1"},
                      {"slab.size", "8"},
                      {"slab.image_size", "2"}});

const KeyedFile planet({{"camera.position", "[4, 0, 0]"},
                        {"camera.orthographic_width", "2"},
                        {"sun.phase_angle_deg", "30"},
                        {"background.image", "'grey.png'"},
                        {"background.encoding", "'data'"},
                        {"layer.phase_function",
                         "['mie:radius=0.2um,wavelength=0.6um', "
                         "'mie:radius=0.2um,wavelength=0.5um', 'mie:radius=0.2um,wavelength="
                         "0.4um']"},
                        {"layer.albedo", "'phase_function'"},
                        {"layer.density.number", "1e6"},
                        {"layer.density.radius", "3e-3"},
                        {"layer.extinction", "'phase_function'"},
                        {"layer.optical_depth.image", "'grey.png'"},
                        {"layer.optical_depth.encoding", "'srgb'"},
                        {"layer.optical_depth.most", "4"},
                        {"layer.opposition.law", "'blinn'"},
                        {"layer.opposition.density", "0.1"},
                        {"planet.surface.pattern", "'squares'"},
                        {"planet.surface.colour", "0.1"},
                        {"planet.surface.other", "0.6"},
                        {"planet.surface.scale", "4"},
                        {"planet.surface.seed", "2"}});

const KeyedFile painted = planet.with("planet.surface", "0.1")
                              .with("planet.surface.image", "'grey.png'")
                              .with("planet.surface.encoding", "'data'");

const KeyedFile sea = planet.with("planet.surface", "{}")
                          .with("planet.surface.wind", "5")
                          .with("planet.surface.index", "1.3")
                          .with("planet.surface.colour", "0.05");

const KeyedFile seen_planet({{"camera.position", "[4, 0, 0]"},
                             {"camera.orthographic_width", "2"},
                             {"sun.phase_angle_deg", "30"}});

const KeyedFile stacked =
    seen_planet.with({{"layer.stack", "'stack.toml'"}, {"planet.surface", "0.1"}});

const KeyedFile shelled = seen_planet.with({{"layer.phase_function", "'isotropic'"},
                                            {"layer.albedo", "0.5"},
                                            {"layer.optical_depth", "0.5"},
                                            {"planet.shell", "0.01"}});

const KeyedFile seen_rings({{"camera.position", "[4, 0, 1]"},
                            {"camera.orthographic_width", "2"},
                            {"sun.direction", "[1, 0, 1]"},
                            {"layer.components", "['isotropic', 'rayleigh']"},
                            {"rings.profile", "'rings.csv'"}});

const KeyedFile rings = seen_rings.with({{"rings.planet_radius", "1.0"},
                                         {"rings.inner", "1.25"},
                                         {"rings.outer", "1.5"},
                                         {"rings.surface", "0.5"},
                                         {"rings.flattening", "0.1"}});

const KeyedFile cloudy_rings = seen_rings.with(
    {{"planet.layer", "{ phase_function = 'isotropic', albedo = 0.5, optical_depth = 1.0 }"},
     {"planet.surface", "0.5"}});

const KeyedFile keyed_lobes({{"lobes.phase_function", "'isotropic'"},
                             {"lobes.incident_deg", "[30]"},
                             {"lobes.optical_depths", "[1]"},
                             {"lobes.albedos", "[1]"},
                             {"lobes.common_scale", "true"}});

const KeyedFile lambert({{"lambert.phase_function", "'isotropic'"},
                         {"lambert.albedo", "1"},
                         {"lambert.optical_depth", "inf"},
                         {"lambert.mu_in", "[0.5]"}});

TEST(SceneKeys, AreAllRead) {
    const TemporaryFolder folder;
    write_png(Image(2, 2), 1, {}, folder / "grey.png");
    set_content(folder / "rings.csv", "radius,optical_depth,w1,w2\n1.2,1,0.6,0.2\n1.6,3,0.2,0.2\n");
    set_content(folder / "stack.toml",
                "[[layers]]\nphase_function = 'isotropic'\nalbedo = 0.5\n"
                "optical_depth = 1.0\n");
    expect_keys_are_read(
        scene_keys(), "scene",
        {slab, planet, painted, sea, stacked, shelled, rings, cloudy_rings, keyed_lobes, lambert},
        [&](const std::string& text) { parse_scene(text, folder.path().string()); },
        [](const Key& key) {
            const std::string name = key.name;
            // keys of tables that follow one another are those of Film tests
            if (name.starts_with("animation.keys.")) return std::string{};
            return (name.starts_with("surface.") ? "planet." : "") + name;
        });
}

}  // namespace
}  // namespace stratus::test
