#include <stratus/base/constants.h>
#include <stratus/scene/scene.h>

#include "indices.h"
#include "refusal.h"
#include "small_scene.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <stdexcept>

namespace stratus::test {
namespace {

const std::string cloud =
    "title = 'Clouds'\n"
    "tolerance = 1e-2\n"
    "effects = ['-multiple', '-shadows']\n"
    "[picture]\n"
    "width = 64\n"
    "height = 32\n"
    "samples = 3\n"
    "white = 0.5\n"
    "[camera]\n"
    "position = [3.0, 4, 1]\n"
    "look_at = [0, 0, 1]\n"
    "field_of_view_deg = 60.0\n"
    "[sun]\n"
    "direction = [0.0, 0.0, 2.0]\n"
    "angular_diameter_deg = 9.0\n"
    "[background]\n"
    "colour = [0.25, 0.5, 4.0]\n"
    "[layer]\n"
    "phase_function = 'henyey_greenstein:g=0.5'\n"
    "albedo = [0.9, 0.8, 0.7]\n"
    "optical_depth = { clouds = true, most = 6.0, coverage = 0.4, seed = 3 }\n"
    "density = 0.2\n"
    "opposition = { law = 'hapke', amplitude = 0.5, width = 0.1 }\n"
    "[slab]\n"
    "surface = { pattern = 'squares', scale = 4.0 }\n"
    "height = 2.0\n"
    "size = 6.0\n";

/// The scene above with the line that begins so replaced.
std::string cloud_but(const std::string& line, const std::string& instead) {
    std::string text = cloud;
    const std::size_t begin = text.find(line);
    if (begin == std::string::npos) throw std::logic_error("no line " + line);
    return text.replace(begin, text.find('\n', begin) - begin, instead);
}

void expect_scene_refusal(const std::string& text, const Fragments& fragments) {
    SCOPED_TRACE(text);
    expect_refusal([&] { parse_scene(text); }, fragments);
}

TEST(SceneFile, HoldsTheValuesOfItsText) {
    const SceneFile file = parse_scene(cloud);
    EXPECT_EQ(file.title, "Clouds");
    EXPECT_EQ(file.text, cloud);
    ASSERT_EQ(file.panels.size(), 1u);
    const Scene& scene = file.panels[0];
    EXPECT_EQ(scene.tolerance, 1e-2);
    EXPECT_TRUE(scene.effects.single);
    EXPECT_FALSE(scene.effects.multiple);
    EXPECT_FALSE(scene.effects.shadows);
    EXPECT_EQ(scene.width, 64);
    EXPECT_EQ(scene.height, 32);
    EXPECT_EQ(scene.samples, 3);
    EXPECT_EQ(scene.white, 0.5);
    EXPECT_EQ(scene.camera.position.y, 4);
    EXPECT_EQ(scene.camera.look_at.z, 1);
    EXPECT_FALSE(scene.camera.orthographic);
    EXPECT_DOUBLE_EQ(scene.camera.width, pi / 3);
    EXPECT_EQ(scene.to_sun.z, 1);
    EXPECT_DOUBLE_EQ(scene.sun_diameter, radians(9));
    EXPECT_EQ(scene.background.colour.b, 4);
    EXPECT_DOUBLE_EQ(scene.layer.components.at(0).asymmetry(), 0.5);
    EXPECT_EQ(scene.layer.albedo[1], 0.8);
    EXPECT_EQ(scene.layer.optical_depth.pattern, DepthMap::Pattern::clouds);
    EXPECT_EQ(scene.layer.optical_depth.max, 6);
    EXPECT_EQ(scene.layer.optical_depth.coverage, 0.4);
    EXPECT_EQ(scene.layer.optical_depth.seed, 3u);
    EXPECT_EQ(scene.layer.density, 0.2);
    EXPECT_EQ(scene.layer.opposition.law, Opposition::Law::hapke);
    EXPECT_EQ(scene.layer.opposition.width, 0.1);
    const Slab& slab = the_slab(scene);
    EXPECT_EQ(slab.surface->pattern, Texture::Pattern::squares);
    EXPECT_EQ(slab.surface->scale, 4);
    EXPECT_EQ(slab.height, 2);
    EXPECT_EQ(slab.half_size, 3) << "half a side";
}

TEST(SceneFile, TakesADensityFromNumberAndRadiusOfParticles) {
    const auto layer = [](const std::string& density, const std::string& opposition) {
        std::string text = cloud_but("density", density);
        const std::size_t begin = text.find("opposition");
        text.replace(begin, text.find('\n', begin) - begin, opposition);
        return parse_scene(text).panels[0].layer;
    };
    const std::string particles = "density = { number = 0.1, radius = 0.5 }";
    const double density = volume_fraction(0.1, 0.5);
    const SceneLayer hapke = layer(particles, "opposition = { law = 'hapke', amplitude = 1.0 }");
    EXPECT_EQ(hapke.density, density);
    EXPECT_EQ(hapke.opposition.width, Opposition::width_of_density(density));
    const SceneLayer blinn = layer(particles, "opposition = { law = 'blinn' }");
    EXPECT_EQ(blinn.opposition.width, Opposition::radius_in_free_paths(density));
    const SceneLayer given = layer(particles, "opposition = { law = 'blinn', density = 0.2 }");
    EXPECT_EQ(given.opposition.width, Opposition::radius_in_free_paths(0.2));
    expect_refusal([&] { layer("", "opposition = { law = 'blinn' }"); },
                   {"layer.opposition.density", "no density"});
    expect_refusal([&] { layer("", "opposition = { law = 'hapke', amplitude = 1.0 }"); },
                   {"layer.opposition.width", "no density"});
    expect_refusal([&] { layer("density = { number = 1.0, radius = 1.0 }", ""); },
                   {"layer.density", "radius^3", "[0, 1)", "got 4.18"});
    expect_refusal([&] { layer("density = { number = 1.0 }", ""); }, "layer.density.radius");
}

TEST(SceneFile, RefusesUnknownKeysWithTheNearestKnown) {
    expect_scene_refusal(cloud_but("tolerance", "tolerence = 1"), {"tolerence", "'tolerance'"});
    expect_scene_refusal(cloud_but("width", "with = 1"), {"'picture.with'", "'picture.width'"});
    expect_scene_refusal(cloud_but("look_at", "lookat = 1"), "'camera.look_at'");
    expect_scene_refusal(cloud_but("albedo", "albedos = 1"), "'layer.albedo'");
    expect_scene_refusal(cloud_but("surface", "surface = { image = 'x.png', seeds = 1 }"),
                         "'slab.surface.seed'");
    expect_scene_refusal(cloud_but("optical_depth", "optical_depth = { cloud = true }"),
                         "'layer.optical_depth.clouds'");
    expect_scene_refusal(cloud_but("effects", "effects = ['multipel']"),
                         {"unknown effect 'multipel'", "'multiple'"});
    expect_scene_refusal(cloud_but("[slab]", "[slap]"), {"unknown key 'slap'", "'slab'"});
}

TEST(SceneFile, RefusesValuesOutOfRange) {
    const std::vector<std::vector<const char*>> cases{
        {"position", "position = [1.0, 2.0]", "camera.position", "three", "got 2"},
        {"position", "position = [0, 0, 1]", "camera.position", "another point", "the same"},
        {"field_of_view_deg", "", "field_of_view_deg", "orthographic_width", "neither"},
        {"direction", "direction = [0, 0, 0]", "sun.direction", "longer than 0"},
        {"direction", "direction = [0, 0, 1]\nphase_angle_deg = 3.0", "sun must be given by",
         "several"},
        {"phase_function", "phase_function = 'henyey_greenstein:g=1'", "g must be", "(-1, 1)"},
        {"phase_function", "phase_function = ['isotropic', 'rayleigh']", "layer.phase_function",
         "list of three", "got 2"},
        {"phase_function", "phase_function = ['isotropic', 'rayleigh', 2]", "layer.phase_function",
         "list of three"},
        {"albedo", "albedo = 'phase_function'", "layer.albedo", "droplets",
         "got \"phase_function\""},
        {"albedo", "albedo = [0.5, 0.5]", "layer.albedo", "three numbers", "got 2"},
        {"optical_depth", "optical_depth = { most = 1.0 }", "layer.optical_depth", "neither"},
        {"optical_depth", "optical_depth = { clouds = false, most = 1.0 }", "clouds must be true;",
         "a number as its optical_depth", "got false"},
        {"opposition", "opposition = { law = 'moon' }", "opposition.law", "hapke", "got moon"},
        {"surface", "surface = { pattern = 'dots' }", "slab.surface.pattern", "got dots"},
        {"surface", "surface = { image = 'a.jpg' }", ".png or .exr", "a.jpg"},
        {"position", "position = [1.0, 0.0, -2.0]", "camera.position", "above the ground", "-2"},
        {"direction", "direction = [0, 0, 1]\nvisible = 'yes'", "sun.visible", "true or false"},
        {"angular_diameter_deg", "visible = true", "sun.visible", "false where"},
        {"optical_depth", "optical_depth = [1.0, 2.0]", "layer.optical_depth", "three numbers"},
        {"optical_depth", "optical_depth = [1, 2, -3]", "layer.optical_depth", "[0, inf]", "-3"},
        {"optical_depth", "optical_depth = [1, 2, inf]", "layer.optical_depth", "finite", "inf"},
        {"optical_depth", "optical_depth = [1, 2, 3]\nextinction = 'phase_function'",
         "layer.extinction"},
        {"[slab]", "[planet]\n[slab]", "of one kind", "[planet] and [slab]"},
    };
    for (const auto& one : cases)
        expect_scene_refusal(cloud_but(one[0], one[1]), {one.begin() + 2, one.end()});
    expect_refusal<std::runtime_error>(
        [] { parse_scene(cloud_but("surface", "surface = { image = 'absent.png' }")); },
        "absent.png");
}

TEST(SceneFile, TakesThreeOpticalDepths) {
    const auto layer_of = [](const std::string& optical_depth) {
        return parse_scene(cloud_but("optical_depth", optical_depth)).panels[0].layer;
    };
    const std::array<double, 3> share{0.25, 0.5, 1};
    const SceneLayer plain = layer_of("optical_depth = [1.0, 2.0, 4.0]");
    EXPECT_TRUE(plain.optical_depth.is_plain());
    EXPECT_EQ(plain.optical_depth.max, 4);
    EXPECT_EQ(plain.extinction, share);
    const SceneLayer clouds = layer_of("optical_depth = { clouds = true, most = [1.0, 2.0, 4.0] }");
    EXPECT_EQ(clouds.optical_depth.max, 4);
    EXPECT_EQ(clouds.extinction, share);
    const SceneLayer none = layer_of("optical_depth = [0, 0, 0]");
    EXPECT_EQ(none.optical_depth.max, 0);
}

TEST(SceneFile, TakesAColouredSunAndItsDisk) {
    const Scene scene = parse_scene(cloud_but("direction",
                                              "direction = [0, 0, 1]\ncolour = [1.0, 0.5, 0.25]\n"
                                              "visible = true"))
                            .panels[0];
    EXPECT_EQ(scene.sun_colour, (std::array<double, 3>{1, 0.5, 0.25}));
    EXPECT_TRUE(scene.sun_visible);
    EXPECT_FALSE(parse_scene(cloud).panels[0].sun_visible);
}

TEST(SceneFile, TakesTheAlbedosOfDropletsForThreeColours) {
    std::string text = cloud_but("albedo", "albedo = 'phase_function'");
    const std::string lobe = "henyey_greenstein:g=0.5";
    text.replace(text.find(lobe), lobe.size(), "mie:radius=20um");
    const std::array<double, 3> albedo = parse_scene(text).panels[0].layer.albedo;
    EXPECT_GT(albedo[0], 0.999);
    EXPECT_LT(albedo[0], albedo[1]);  // water absorbs more in the red
    EXPECT_LT(albedo[1], albedo[2]);
    EXPECT_LT(albedo[2], 1);
}

TEST(SceneFile, TakesDirectionsOfAnyLength) {
    for (const char* direction :
         {"[3e-320, 0, 4e-320]", "[3e-200, 0, 4e-200]", "[3e11, 0, 4e11]"}) {
        const Vector3 to_sun =
            parse_scene(cloud_but("direction", std::string("direction = ") + direction))
                .panels[0]
                .to_sun;
        EXPECT_NEAR(to_sun.x, 0.6, 1e-3) << direction;
        EXPECT_NEAR(to_sun.z, 0.8, 1e-3) << direction;
        EXPECT_NEAR(length(to_sun), 1, 1e-14) << direction;
    }
}

TEST(SceneFile, TakesTheAlbedoOfOnePhaseFunctionAtItsOwnWavelength) {
    const std::string lobe = "'henyey_greenstein:g=0.5'",
                      droplets = "mie:radius=8um,wavelength=3um";
    std::string text = cloud_but("albedo", "albedo = 'phase_function'");
    text.replace(text.find(lobe), lobe.size(), "'" + droplets + "'");
    const double own = *parse_phase_function(droplets).albedo();
    EXPECT_LT(own, 0.7);
    EXPECT_EQ(parse_scene(text).panels[0].layer.albedo, (Rgb3{own, own, own}));
}

TEST(SceneFile, TakesAPhaseFunctionForEachChannel) {
    const std::string blue = "'henyey_greenstein:g=0.5'";
    const auto three = [&](const std::string& list) {
        std::string text = cloud_but("albedo", "albedo = 'phase_function'");
        return text.replace(text.find(blue), blue.size(), list);
    };
    const SceneLayer layer =
        parse_scene(three("['mie:radius=8um,wavelength=2um', 'mie:radius=8um,wavelength=1um', "
                          "'mie:radius=8um,wavelength=0.5um']"))
            .panels[0]
            .layer;
    ASSERT_EQ(layer.channels.size(), 3u);
    for (const auto c : three_channels) {
        const PhaseFunction own = parse_phase_function(std::string("mie:radius=8um,wavelength=") +
                                                       std::array{"2um", "1um", "0.5um"}[c]);
        EXPECT_EQ(layer.channels[c].text(), own.text());
        EXPECT_DOUBLE_EQ(layer.albedo[c], std::get<Mie>(own.terms()[0].second).albedo());
    }
    EXPECT_LT(layer.albedo[0], 0.999);
    EXPECT_EQ(layer.extinction, (std::array<double, 3>{1, 1, 1}));
    expect_scene_refusal(three("['mie:radius=8um', 'isotropic', 'mie:radius=8um']"),
                         {"layer.albedo", "droplets", "got \"phase_function\""});
}

TEST(SceneFile, TakesTheExtinctionOfDropletsForThreeColours) {
    const auto with = [&](const std::string& phase_functions) {
        return cloud_but("phase_function",
                         "extinction = 'phase_function'\nphase_function = " + phase_functions);
    };
    const SceneLayer layer = parse_scene(with("['mie:radius=0.2um,wavelength=0.65um', "
                                              "'mie:radius=0.2um,wavelength=0.55um', "
                                              "'mie:radius=0.2um,wavelength=0.45um']"))
                                 .panels[0]
                                 .layer;
    EXPECT_GT(layer.extinction[2], 1.2);  // small droplets redden
    EXPECT_EQ(layer.extinction[1], 1);
    EXPECT_LT(layer.extinction[0], 0.85);
    expect_scene_refusal(with("'mie:radius=8um'"), {"layer.extinction", "a list"});
    expect_scene_refusal(with("['mie:radius=8um', 'mie:radius=8um', 'isotropic']"),
                         {"layer.extinction", "droplets"});
    expect_scene_refusal(with("['mie:radius=8um', 'mie:radius=8um', 'mie:radius=7um']"),
                         {"layer.extinction", "same sizes", "radius=7um"});
    expect_scene_refusal(cloud_but("density", "extinction = 1.0"),
                         {"layer.extinction", "\"phase_function\""});
}

TEST(SceneFile, PanelsOverrideKeysOfTheScene) {
    const SceneFile file =
        parse_scene("columns = 2\n" + cloud +
                    "[[panels]]\ntitle = 'first'\nslab.height = 1.0\neffects = 'all'\n"
                    "[[panels]]\nlayer.albedo = 0.25\n[[panels]]\nlayer.optical_depth = inf\n");
    EXPECT_EQ(file.columns, 2);
    ASSERT_EQ(file.panels.size(), 3u);
    EXPECT_EQ(file.panels[0].title, "first");
    EXPECT_EQ(file.panels[1].title, "");
    EXPECT_TRUE(file.panels[0].effects.multiple);
    EXPECT_FALSE(file.panels[1].effects.multiple);
    EXPECT_EQ(the_slab(file.panels[0]).height, 1);
    EXPECT_EQ(the_slab(file.panels[0]).half_size, 3);
    EXPECT_EQ(the_slab(file.panels[1]).height, 2);
    EXPECT_EQ(file.panels[1].layer.albedo[2], 0.25);
    EXPECT_EQ(file.panels[2].layer.albedo[2], 0.7);
    EXPECT_EQ(file.panels[2].layer.optical_depth.max, infinity);
    expect_scene_refusal(cloud + "[[panels]]\n[[panels]]\npicture.width = 65\n",
                         {"panels", "one size"});
    expect_scene_refusal(cloud + "[[panels]]\nslab.hight = 1.0\n", "'slab.height'");
    expect_scene_refusal("panels = 3\n" + cloud, {"panels", "tables"});
}

/// The number of `text`'s line that begins so.
std::string line_of(const std::string& text, const std::string& start) {
    const std::size_t begin = text.find("\n" + start);
    if (begin == std::string::npos) throw std::logic_error("no line " + start);
    return "line " +
           std::to_string(std::count(text.begin(),
                                     text.begin() + static_cast<std::ptrdiff_t>(begin) + 1, '\n') +
                          1);
}

TEST(SceneFile, NamesTheLineOfAnErrorInPanels) {
    const auto expect_line = [](const std::string& text, const std::string& start) {
        expect_scene_refusal(text, {line_of(text, start).c_str()});
    };
    const std::string panels = "[[panels]]\ntitle = 'first'\n[[panels]]\ntitle = 'second'\n";
    expect_line(cloud + panels + "[panels.slab]\nhight = 1.0\n", "hight");
    expect_line(cloud + panels + "slab.height = 'high'\n", "slab.height");
    expect_line(cloud + panels + "camara.distance = 1.0\n", "camara");
    expect_line(cloud_but("height", "hight = 32") + panels, "hight");
    expect_line(cloud_but("samples", "samples = 'two'") + panels, "samples");
    expect_line(cloud_but("albedo", "albedos = 0.5") + panels + "layer.density = 0.1\n", "albedos");
}

/// A file of rings with two panels; the second one's keys are to be replaced.
class RingsFile : public ::testing::Test {
  protected:
    RingsFile() {
        set_content(folder / "good.csv", "radius,optical_depth,w1,w2\n1.2,1,0.6,0.2\n2,1,0,0\n");
        set_content(folder / "bent.csv", "radius,optical_depth,w1,w2\n1.2,1,0,0\n1.1,1,0,0\n");
        set_content(folder / "text.csv", "radius,optical_depth,w1,w2\n1.2,thin,0,0\n");
        Image bright(2, 1);
        bright.rgb.back() = 2;
        write_exr_image(bright, {}, folder / "bright.exr");
    }

    /// Refused with "scene: FILE, line LINE: " and then `text`, in the scene or in a panel.
    template <class Error = std::invalid_argument>
    void expect_place(const std::string& line, const std::string& text) {
        const std::string head =
            "[camera]\ndistance = 5.0\nfield_of_view_deg = 30.0\n[sun]\nelevation_deg = 20.0\n";
        const std::string rest =
            "layer.components = ['isotropic', 'rayleigh']\nrings.profile = 'good.csv'\n";
        const std::string key = line.substr(0, line.find(' '));
        std::string alone = rest;
        if (const std::size_t begin = alone.find(key); begin != std::string::npos)
            alone.erase(begin, alone.find('\n', begin) + 1 - begin);
        SCOPED_TRACE(line);
        expect_file<Error>(line + "\n" + alone + head, 1, text);
        expect_file<Error>(rest + head + "[[panels]]\ntitle = 'first'\n[[panels]]\n" + line + "\n",
                           11, text);
    }

    template <class Error>
    void expect_file(const std::string& content, int line, const std::string& text) {
        const std::string name = (folder / "rings.toml").string();
        set_content(name, content);
        const std::string start = "scene: " + name + ", line " + std::to_string(line) + ": " + text;
        expect_refusal<Error>([&] { read_film(name); }, {start.c_str()});
    }

    TemporaryFolder folder;
};

TEST_F(RingsFile, IsRefusedByFileAndLine) {
    const std::string at = folder.path().string() + "/";
    expect_place("rings.inward = 1.0", "unknown key 'rings.inward'; did you mean 'rings.inner'?");
    expect_place("rings.flattening = 1.0", "rings.flattening must be a number in [0, 0.9], got 1");
    expect_place("rings.inner = 3.0", "rings.inner must be within the profile, [1.2, 2], got 3");
    expect_place("rings.profile = 'bent.csv'", "rings.profile: " + at +
                                                   "bent.csv, line 3: radius must be above the one "
                                                   "before, got 1.1");
    expect_place("rings.profile = 'text.csv'",
                 "rings.profile: " + at + "text.csv, line 2: column 'optical_depth' must");
    expect_place<std::runtime_error>("rings.profile = 'absent.csv'",
                                     "rings.profile: " + at + "absent.csv: cannot be opened");
    expect_place<std::runtime_error>("rings.surface.image = 'absent.png'", "rings.surface.image: ");
    expect_place("rings.surface.image = 'grey.jpg'",
                 "rings.surface.image must be a .png or .exr file, got " + at + "grey.jpg");
    expect_place("rings.surface.image = 'bright.exr'",
                 "rings.surface.image must be of numbers in [0, 1], got 2");
    expect_place("rings.surface = { image = 'grey.exr', encoding = 'srgb' }",
                 "rings.surface.encoding must be absent beside an .exr file");
    expect_place("rings.surface = { pattern = 'bands', encoding = 'srgb' }",
                 "rings.surface.encoding must be absent without an image");
    expect_place("layer.components = ['isotropic', 'round']", "layer.components: ");
    expect_place("layer.components = ['isotropic']", "layer.components must be a list of two");
    expect_place("layer.optical_depth = 1.0", "layer.optical_depth must be absent where there are");
    expect_place(
        "layer.phase_function = 'isotropic'",
        "layer.phase_function must be absent where there are [rings]: components has those "
        "of the profile's w1 and w2, got one");
    expect_place("planet.surface = 0.5", "planet.layer must be present beside [rings]");
    expect_place("effects = ['-shadow']", "effects: unknown effect 'shadow'");
    expect_place("background.colour = [1.0, 2.0]", "background.colour must be a number or three");
}

TEST(SceneCamera, IsPlacedByAnglesAndPlacesTheSunByPhaseAngle) {
    const std::string text =
        "[camera]\ndistance = 5.0\nelevation_deg = 30.0\nazimuth_deg = 60.0\n"
        "look_at = [1.0, 0.0, 0.0]\northographic_width = 3.0\n"
        "[sun]\nphase_angle_deg = 40.0\n"
        "[layer]\nphase_function = 'isotropic'\nalbedo = 0.5\noptical_depth = 1.0\n[planet]\n";
    const Scene scene = parse_scene(text).panels[0];
    EXPECT_NEAR(scene.camera.position.x, 1 + 5 * std::cos(pi / 6) * std::cos(pi / 3), 1e-14);
    EXPECT_NEAR(scene.camera.position.y, 5 * std::cos(pi / 6) * std::sin(pi / 3), 1e-14);
    EXPECT_NEAR(scene.camera.position.z, 5 * std::sin(pi / 6), 1e-14);
    EXPECT_NEAR(dot(scene.to_sun, -scene.camera.forward()), std::cos(radians(40)), 1e-14);
    EXPECT_GT(dot(scene.to_sun, scene.camera.right()), 0) << "to the right";
    EXPECT_NEAR(length(scene.to_sun), 1, 1e-14);

    const PictureRays rays(scene.camera, 300, 100);
    const Ray left = rays.through(0, 50), top = rays.through(150, 0);
    EXPECT_NEAR(dot(left.origin - scene.camera.position, scene.camera.right()), -1.5, 1e-14);
    EXPECT_NEAR(dot(top.origin - scene.camera.position, scene.camera.up()), 0.5, 1e-14);
    EXPECT_GT(scene.camera.up().z, 0);
}

TEST(SceneCamera, IsOutsideThePlanet) {
    const auto refuse = [](const std::string& position, const Fragments& fragments) {
        expect_scene_refusal(
            "[camera]\n" + position +
                "\nfield_of_view_deg = 30.0\n[sun]\nphase_angle_deg = 40.0\n[layer]\n"
                "phase_function = 'isotropic'\nalbedo = 0.5\noptical_depth = 1.0\n[planet]\n",
            fragments);
    };
    refuse("distance = 0.5", {"line 1: camera.position must be outside the planet", "got 0.5 of"});
    refuse("position = [0, 0, 1]", {"line 2: camera.position must be outside", "got 1 of"});
}

TEST(SceneCamera, SpansItsFieldOfView) {
    Camera camera;
    camera.position = {0, 0, 4};
    camera.look_at = {0, 0, 0};  // along z, where another direction must be up
    camera.width = radians(50);
    const PictureRays rays(camera, 200, 100);
    const Ray left = rays.through(0, 50), right = rays.through(200, 50);
    EXPECT_NEAR(std::acos(dot(left.direction, right.direction)), radians(50), 1e-14);
    EXPECT_NEAR(camera.up().y, 1, 1e-14);
}

TEST(SceneEffects, AreParsedFromNames) {
    const SceneEffects all = parse_scene_effects({"all"});
    for (const auto& [name, member] : scene_effects()) EXPECT_TRUE(all.*member) << name;
    const SceneEffects two = parse_scene_effects({"single", "shadows"});
    EXPECT_TRUE(two.single && two.shadows);
    EXPECT_FALSE(two.multiple || two.background || two.reflection);
    const SceneEffects but_two = parse_scene_effects({"all", "-single", "-density"});
    EXPECT_FALSE(but_two.single || but_two.density);
    EXPECT_TRUE(but_two.multiple && but_two.sun_size);
    EXPECT_EQ(scene_effect_names(but_two),
              (std::vector<std::string>{"all", "-single", "-density"}));
    EXPECT_EQ(scene_effect_names(all), std::vector<std::string>{"all"});
}

class RingProfileFile : public ::testing::Test {
  protected:
    SceneFile read(const std::string& csv, const std::string& keys = "") const {
        set_content(folder / "profile.csv", csv);
        return parse_scene(
            "[camera]\ndistance = 5.0\nfield_of_view_deg = 30.0\n[sun]\nelevation_deg = 20.0\n"
            "[layer]\ncomponents = ['lambert_sphere', 'isotropic']\nalbedo = [1.0, 0.5, 0.25]\n"
            "[rings]\nprofile = 'profile.csv'\nplanet_radius = 100.0\n" +
                keys,
            folder.path().string());
    }
    TemporaryFolder folder;
    const std::string head = "radius,optical_depth,w1,w2\n";
};

TEST_F(RingProfileFile, IsLinearBetweenRowsAndEmptyOutside) {
    const Scene scene = read(head + "120,1,0.6,0.2\n140,3,0.2,0.2\n200,0,0.1,0\n").panels[0];
    const RingProfile& profile = the_rings(scene).profile;
    EXPECT_EQ(profile.inner(), 1.2);
    EXPECT_EQ(profile.outer(), 2);
    const Matter middle = profile.at(1.3, scene.layer.albedo);
    EXPECT_DOUBLE_EQ(middle.optical_depth, 2);
    EXPECT_DOUBLE_EQ(middle.albedo[0], 0.6);
    EXPECT_DOUBLE_EQ(middle.albedo[2], 0.15) << "of its colour";
    EXPECT_DOUBLE_EQ(middle.mixture, 0.4 / 0.6);
    EXPECT_EQ(profile.at(1.19, {1, 1, 1}).optical_depth, 0);
    EXPECT_EQ(profile.at(2.01, {1, 1, 1}).optical_depth, 0);
    EXPECT_EQ(profile.at(1.2, {1, 1, 1}).optical_depth, 1);
}

TEST_F(RingProfileFile, IsTrimmedToItsInnerAndOuterRadius) {
    const Scene scene =
        read(head + "120,1,0.6,0.2\n140,3,0.2,0.2\n200,0,0.1,0\n", "inner = 1.3\nouter = 1.7\n")
            .panels[0];
    const RingProfile& profile = the_rings(scene).profile;
    EXPECT_EQ(profile.radius, (std::vector<double>{1.3, 1.4, 1.7}));
    EXPECT_DOUBLE_EQ(profile.at(1.3, {1, 1, 1}).optical_depth, 2);
    EXPECT_NEAR(profile.at(1.7, {1, 1, 1}).optical_depth, 1.5, 1e-14);
    EXPECT_EQ(profile.at(1.71, {1, 1, 1}).optical_depth, 0);
}

TEST_F(RingProfileFile, MayBeOfAPlanetWithALayerOfItsOwn) {
    const std::string rows = head + "120,1,0.6,0.2\n140,3,0.2,0.2\n",
                      layer =
                          "[planet.layer]\nphase_function = 'rayleigh'\nalbedo = 0.5\n"
                          "density = 0.1\noptical_depth = { clouds = true, most = 3.0, seed = 4 "
                          "}\n";
    const Scene scene = read(rows, "[planet]\nsurface = 0.25\n" + layer).panels[0];
    const Rings& rings = the_rings(scene);
    ASSERT_TRUE(rings.planet_layer.has_value());
    EXPECT_EQ(rings.planet_layer->components[0].text(), "rayleigh");
    EXPECT_EQ(rings.planet_layer->optical_depth.max, 3);
    EXPECT_EQ(rings.planet_layer->optical_depth.seed, 4u);
    EXPECT_EQ(rings.surface.colour.g, 0.25f);
    EXPECT_EQ(scene.layer.components.size(), 2u);
    EXPECT_EQ(scene.named, std::vector{&SceneEffects::density}) << "which the planet's layer has";
    const auto refuse = [&](const std::string& keys, const Fragments& fragments) {
        SCOPED_TRACE(keys);
        expect_refusal([&] { read(rows, keys); }, fragments);
    };
    refuse("surface = 0.5\n" + layer, {"rings.surface", "absent beside [planet]"});
    refuse("[planet]\nsurface = { wind = 5 }\n" + layer, {"planet.surface", "no ocean"});
    refuse("[planet]\nshell = 0.01\n" + layer, {"planet.shell", "absent beside [rings]"});
    refuse(layer + "mist = 1\n", {"line 17", "unknown key 'planet.layer.mist'"});
    refuse(layer + "components = ['isotropic', 'rayleigh']\n",
           {"planet.layer.components", "absent"});
    std::string thin = layer;
    refuse(thin.replace(thin.find("3.0"), 3, "-1 "),
           {"planet.layer.optical_depth.most", "[0, 1e4]", "got -1"});
    expect_scene_refusal(
        "[camera]\ndistance = 5.0\nfield_of_view_deg = 30.0\n[sun]\n"
        "elevation_deg = 20.0\n[layer]\nphase_function = 'rayleigh'\n"
        "albedo = 1\noptical_depth = 1\n" +
            layer,
        {"planet.layer", "absent without [rings]"});
}

TEST(SceneFile, SharesOceansBetweenPanelsAndKeepsTheirColours) {
    const std::vector<Scene> panels = parse_scene(R"(
[camera]
distance = 3
field_of_view_deg = 10
[sun]
phase_angle_deg = 30
[layer]
phase_function = "isotropic"
albedo = 0
optical_depth = 0
[planet]
surface = { wind = 4, colour = [0.01, 0.02, 0.04] }
[[panels]]
[[panels]]
planet.surface = { wind = 4, colour = [0.04, 0.02, 0.03] }
[[panels]]
planet.surface = { wind = 9, colour = 0.04 }
)")
                                          .panels;
    const auto ocean = [&](std::size_t panel) -> const Texture& {
        return the_planet(panels[panel]).surface;
    };
    EXPECT_EQ(ocean(0).mirror, ocean(1).mirror);
    EXPECT_NE(ocean(0).mirror, ocean(2).mirror);
    const auto facets = read_ground_law("ocean:wind=4");
    const double mirrored = facets->spherical_albedo();
    const Rgb colour = ocean(1).colour;
    const double channels[] = {double{colour.r}, double{colour.g}, double{colour.b}};
    const double given[] = {0.04, 0.02, 0.03};
    for (const auto c : three_channels) EXPECT_NEAR(channels[c] - mirrored, given[c], 1e-7) << c;
    const Geometry glint{0.6, 0.6, 0};
    EXPECT_NEAR((*ocean(1).mirror)(glint)-ocean(1).mirror_albedo, (*facets)(glint)-mirrored, 1e-9);
}

TEST(SceneFile, RefusesShellsBeyondTheirRange) {
    const auto planet = [](const std::string& layer, const std::string& shell) {
        return "[camera]\ndistance = 1.04\northographic_width = 1.0\n[sun]\nelevation_deg = 20.0\n"
               "[layer]\nphase_function = 'isotropic'\nalbedo = 0.5\noptical_depth = 2\n" +
               layer + "[planet]\nshell = " + shell + "\n";
    };
    EXPECT_EQ(the_planet(parse_scene(planet("", "0.02")).panels[0]).shell, 0.02);
    expect_scene_refusal(planet("", "0.03"),
                         {"line 11: planet.shell", "0.05 over", "0.025", "0.03"});
    expect_scene_refusal(planet("opposition = { law = 'blinn', density = 0.1 }\n", "0.01"),
                         {"planet.shell", "0 where the layer is a stack or has an opposition"});
    std::string close = planet("", "0.02");
    expect_scene_refusal(close.replace(close.find("1.04"), 4, "1.01"),
                         {"outside the planet", "its shell, which ends at 1.02", "got 1.01 of"});
}

TEST_F(RingProfileFile, NamesTheLineOfABadRow) {
    const auto refuse = [&](const std::string& rows, const Fragments& fragments) {
        SCOPED_TRACE(rows);
        expect_refusal([&] { read(head + rows); }, fragments);
    };
    refuse("120,1,0.6,0.5\n140,3,0.2,0.2\n", {"line 2", "w1 + w2", "[0, 1]", "1.1"});
    refuse("120,1,0.6,0.2\n140,-3,0.2,0.2\n", {"line 3", "optical_depth", "got -3"});
    refuse("120,1,0.6,0.2\n110,1,0.2,0.2\n", {"line 3", "radius", "above", "got 110"});
    refuse("120,1,0.6,0.2\n", {"at least 2 rows", "got 1"});
    refuse("90,1,0.6,0.2\n120,1,0.6,0.2\n", {"rings.inner", "planet's radius", "got 0.9"});
    expect_refusal([&] { read("radius,optical_depth,w1\n120,1,0.5\n"); }, "w2");
}

TEST(SceneFile, OfTheGalleryIsReadable) {
    int count = 0;
    for (const auto& entry :
         std::filesystem::directory_iterator(STRATUS_REFERENCE_FOLDER "/../../tables/scenes")) {
        if (entry.path().extension() != ".toml") continue;
        SCOPED_TRACE(entry.path().string());
        const SceneFile file = read_film(entry.path())[0];
        EXPECT_FALSE(file.title.empty());
        EXPECT_TRUE(file.figure.has_value() != !file.panels.empty());
        ++count;
    }
    EXPECT_GE(count, 6);
}

TEST(SceneFile, OfAFigureHoldsTheFigureAlone) {
    const std::string text =
        "[lobes]\nphase_function = 'isotropic'\nincident_deg = [36.0, 144.0]\n"
        "optical_depths = [2.0, inf]\nalbedos = [1.0]\n";
    const SceneFile file = parse_scene(text);
    ASSERT_TRUE(file.figure.has_value());
    EXPECT_TRUE(file.panels.empty());
    EXPECT_DOUBLE_EQ(std::get<LobeFigure>(*file.figure).incident[1], radians(144));
    expect_scene_refusal(text + "[camera]\n", {"line 6: camera", "absent from a figure"});
    expect_scene_refusal(
        "[lobes]\nphase_function = 'isotropic'\nincident_deg = [90.0]\noptical_depths = [2.0]\n"
        "albedos = [1.0]\n",
        {"lobes.incident_deg", "not along the layer", "90"});
    expect_scene_refusal(
        "[lambert]\nphase_function = 'isotropic'\nalbedo = 1.0\noptical_depth = 1.0\nmu_in = []\n",
        {"lambert.mu_in", "1 to 8", "an empty list"});
    const std::string dark = "[lambert]\nphase_function = 'isotropic'\nmu_in = [1.0]\nalbedo = ";
    expect_scene_refusal(dark + "1.0\noptical_depth = 0.0\n",
                         {"lambert.optical_depth", "(0, inf]"});
    expect_scene_refusal(dark + "0.0\noptical_depth = 1.0\n", {"lambert.albedo", "(0, 1]"});
}

const std::string moving = cloud_but("[slab]",
                                     "[animation]\n"
                                     "frames = 9\n"
                                     "[[animation.keys]]\n"
                                     "frame = 2\n"
                                     "camera.position = [3.0, 4, 1]\n"
                                     "layer.optical_depth.seed = 3\n"
                                     "effects = 'all'\n"
                                     "[[animation.keys]]\n"
                                     "frame = 4\n"
                                     "slab.height = 4\n"
                                     "layer.optical_depth.offset = [1, 2, 3]\n"
                                     "[[animation.keys]]\n"
                                     "frame = 6\n"
                                     "camera.position = [7.0, 0, 1]\n"
                                     "layer.optical_depth.seed = 8\n"
                                     "effects = ['-multiple']\n"
                                     "[slab]");

TEST(Film, ChangesNumbersLinearlyBetweenKeysAndAllElseAtThem) {
    const std::vector<SceneFile> film = parse_film(moving);
    ASSERT_EQ(film.size(), 9u);
    EXPECT_EQ(parse_scene(moving).frames, 9);
    const double x[] = {3, 3, 3, 4, 5, 6, 7, 7, 7};
    for (const auto k : indices(film)) {
        const Scene& scene = film[k].panels.at(0);
        EXPECT_DOUBLE_EQ(scene.camera.position.x, x[k]) << k;
        EXPECT_DOUBLE_EQ(scene.camera.position.y, 7 - x[k]) << k;
        EXPECT_EQ(scene.layer.optical_depth.seed, k < 6 ? 3u : 8u) << k;
        EXPECT_EQ(scene.effects.multiple, k < 6) << k;
        EXPECT_EQ(the_slab(scene).height, 4) << "of the only key";
        EXPECT_EQ(scene.layer.optical_depth.offset.y, 2);
        EXPECT_EQ(scene.layer.optical_depth.coverage, 0.4) << "as without keys";
    }
    EXPECT_EQ(all_panels(film).size(), 9u);
    const std::vector<SceneFile> still = parse_film(cloud);
    ASSERT_EQ(still.size(), 1u);
    EXPECT_EQ(still[0].panels[0].camera.position.x, 3);
}

// picture.width and picture.height, which share their names, are whole numbers.
TEST(Film, ChangesHeightsAndWidthsLinearly) {
    const Scene scene = parse_film(cloud +
                                   "[animation]\nframes = 5\n"
                                   "[[animation.keys]]\nframe = 0\nslab.height = 1.0\n"
                                   "layer.opposition.width = 0.25\n"
                                   "[[animation.keys]]\nframe = 4\nslab.height = 2.0\n"
                                   "layer.opposition.width = 0.75\n")[3]
                            .panels.at(0);
    EXPECT_DOUBLE_EQ(the_slab(scene).height, 1.75);
    EXPECT_DOUBLE_EQ(scene.layer.opposition.width, 0.625);
}

TEST(Film, GivesPanelsTheirOwnKeysInEveryFrame) {
    const std::vector<SceneFile> film =
        parse_film(moving + "[[panels]]\ntitle = 'a'\n[[panels]]\nslab.height = 5\n");
    for (const SceneFile& frame : film) {
        ASSERT_EQ(frame.panels.size(), 2u);
        EXPECT_EQ(frame.panels[1].camera.position.x, frame.panels[0].camera.position.x);
        EXPECT_EQ(the_slab(frame.panels[0]).height, 4);
        EXPECT_EQ(the_slab(frame.panels[1]).height, 5);
    }
}

TEST(Film, RefusesWhatNoFramesCanBeMadeOf) {
    const auto refused = [&](const std::string& line, const std::string& instead,
                             const Fragments& fragments) {
        std::string text = moving;
        text.replace(text.find(line), line.size(), instead);
        expect_refusal([&] { parse_film(text); }, fragments);
    };
    refused("frames = 9", "frames = 0", {"line 25: animation.frames", "[1, 10000]", "got 0"});
    refused("frames = 9", "", {"animation.frames", "present"});
    refused("frame = 6", "frame = 9", {"line 36: animation.keys.frame", "below", "9", "got 9"});
    refused("frame = 6", "frame = 4", {"animation.keys", "ascending", "4 after 4"});
    refused("frame = 6", "frame = 4.5", {"animation.keys.frame", "whole number"});
    refused("frame = 6\n", "", {"animation.keys.frame", "present"});
    refused("seed = 8", "sead = 8", {"frame", "unknown key 'layer.optical_depth.sead'"});
    refused("seed = 8", "seed = -8", {"frame 6, line 38: layer.optical_depth.seed", "got -8"});
    refused("layer.optical_depth.seed = 8", "layer.optical_depth = 8", "optical_depth as both");
    refused("[7.0, 0, 1]", "[-3, -4, 1]", {"frame 4: camera.position", "look_at"});
    refused("[[animation.keys]]\nframe = 4",
            "picture.width = 64\n[[animation.keys]]\nframe = 4\npicture.width = 32",
            "one size in all frames");
    for (const char* key : {"panels = []", "columns = 2", "animation = {}"})
        refused("effects = 'all'", key, "absent from animation.keys");
    expect_scene_refusal(moving + "[[panels]]\nanimation = {}\n", {"animation", "from a panel"});
    expect_scene_refusal(
        "[lambert]\nphase_function = 'isotropic'\nalbedo = 1.0\noptical_depth = 1.0\n"
        "mu_in = [1]\n[animation]\nframes = 2\nkeys = [{ frame = 0 }]\n",
        {"animation", "absent from a figure"});
}

TEST(SceneOfAStack, HoldsItsLayers) {
    const TemporaryFolder folder;
    const std::string layer = "[[layers]]\nphase_function = 'rayleigh'\nalbedo = 1\n";
    set_content(folder / "two.toml", layer + "optical_depth = 0.5\n" +
                                         "[[layers]]\nphase_function = 'isotropic'\n"
                                         "albedo = 0.5\noptical_depth = 1.5\n");
    set_content(folder / "ground.toml",
                layer + "optical_depth = 0.5\n[below]\nlambert_albedo = 0.5\n");
    set_content(folder / "bad.toml", layer + "optical_depth = -1\n");
    const auto scene_of = [&](const std::string& stack, const std::string& more = "",
                              const std::string& subject = "[slab]\n",
                              const std::string& elevation = "30", const std::string& view = "30") {
        return parse_scene("[camera]\ndistance = 10.0\nelevation_deg = " + view +
                               "\northographic_width = 2.0\n[sun]\nelevation_deg = " + elevation +
                               "\n[layer]\nstack = '" + stack + "'\n" + more + subject,
                           folder.path().string(), "scene.toml")
            .panels[0];
    };
    const Scene scene = scene_of("two.toml");
    ASSERT_EQ(scene.layer.stacks.size(), 1u);
    EXPECT_EQ(scene.layer.stacks[0][1].optical_depth, 1.5);
    EXPECT_EQ(scene_of("two.toml", "", "[slab]\n", "-30").layer.stacks[0][0].optical_depth, 1.5)
        << "lit from beneath";
    set_content(folder / "deep.toml",
                layer + "optical_depth = 0.5\n" + layer + "optical_depth = inf\n");
    EXPECT_EQ(scene_of("deep.toml", "", "[slab]\n", "-30").layer.stacks[0].size(), 1u);
    EXPECT_EQ(scene.layer.optical_depth.max, 2);
    EXPECT_EQ(scene.layer.albedo[0], (0.5 + 0.75) / 2);
    const auto refused = [&](const auto& call, const Fragments& fragments) {
        expect_refusal(call, fragments);
    };
    for (const char* line : {"phase_function = 'isotropic'", "albedo = 0.5", "optical_depth = 1",
                             "density = 0.1", "opposition = { law = 'blinn' }"}) {
        const std::string key = std::string(line).substr(0, std::string(line).find(' '));
        refused([&] { scene_of("two.toml", std::string(line) + "\n"); },
                {"scene.toml, line 9", key.c_str(), "beside a stack"});
    }
    refused([&] { scene_of("ground.toml"); }, {"scene.toml, line 8", "layer.stack", "[below]"});
    refused([&] { scene_of("bad.toml"); },
            {"scene.toml, line 8", "bad.toml, line 4", "optical_depth", "got -1"});
    refused([&] { scene_of("two.toml", "", "[rings]\nprofile = 'r.csv'\n"); },
            {"scene.toml, line 8", "layer.stack", "[rings]"});
    refused([&] { scene_of("two.toml", "", "[slab]\n", "0"); },
            {"scene.toml, line 5", "sun", "wholly above or wholly beneath", "0.0"});
    refused(
        [&] { scene_of("two.toml", "", "[slab]\nsurface = 0.5\nheight = 20.0\n", "30", "-30"); },
        {"scene.toml, line 10", "slab.surface", "seen from its unlit side"});
    refused([&] { scene_of("two.toml", "", "[slab]\n[background]\ncolour = 1.0\n", "30", "-30"); },
            {"scene.toml, line 10", "background", "seen from its unlit side"});
    EXPECT_NO_THROW(scene_of("two.toml", "", "[slab]\n", "30", "-30"));
    EXPECT_NO_THROW(scene_of("two.toml", "", "[planet]\n", "-5"));
    EXPECT_NO_THROW(scene_of("two.toml", "", "[slab]\n[background]\ncolour = 1.0\n", "-5", "-30"));
}

}  // namespace
}  // namespace stratus::test
