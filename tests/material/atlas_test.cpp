#include <stratus/material/material.h>

#include "atlas_reader.h"
#include "indices.h"
#include "material_check.h"
#include "refusal.h"

#include <gtest/gtest.h>

#include <memory>

namespace stratus::test {
namespace {

struct Atlas {
    TemporaryFolder folder;
    std::string json;
    std::unique_ptr<AtlasReader> tiles;

    explicit Atlas(const Material& material) {
        write_material(make_material(material, MaterialFormat::exr_atlas), folder / "atlas.exr");
        json = content(folder / "atlas.json");
        tiles = std::make_unique<AtlasReader>(folder / "atlas.exr", json);
    }

    double value(int row, const Geometry& at, std::size_t colour = 0) const {
        return pi * (*tiles)(row, at.mu_in, at.mu_out, at.azimuth)[colour];
    }
};

// 64 tiles of 64 x 64 texels, by the texture's own filter: 0.1 % in the median, 1 % for 99 %.
TEST(AtlasFile, IsTheSolverAtRandomPairs) {
    for (const Stack& stack :
         {layer("rayleigh", 1, 0.1), layer("henyey_greenstein:g=0.7", 0.95, 2)}) {
        const Atlas atlas({{stack}, ""});
        ASSERT_EQ(atlas.tiles->rows(), 2);
        Errors R, T;
        for (const Expected& at : random_geometries(stack, 500, 0.01)) {
            R.add(atlas.value(0, at.geometry), at.reflection);
            T.add(atlas.value(1, at.geometry), at.transmission);
        }
        EXPECT_LE(R.quantile(0.5), 1e-3);
        EXPECT_LE(R.quantile(0.99), 1e-2);
        EXPECT_LE(T.quantile(0.5), 1e-3);
        EXPECT_LE(T.quantile(0.99), 1e-2);
    }
}

TEST(AtlasFile, HoldsStacksLitFromEitherSideInThreeColours) {
    const auto stack = [](double haze) -> Stack {
        return {{{parse_phase_function("rayleigh"), 1, haze},
                 {parse_phase_function("henyey_greenstein:g=0.6"), 0.9, 1}},
                {}};
    };
    const Material material{{stack(0.1), stack(0.2), stack(0.4)}, ""};
    const Atlas atlas(material);
    ASSERT_EQ(atlas.tiles->rows(), 3);
    for (const auto colour : three_channels) {
        Errors R, T, below;
        for (const Expected& at : random_geometries(material.colours[colour], 40, 0.05)) {
            R.add(atlas.value(0, at.geometry, colour), at.reflection);
            T.add(atlas.value(1, at.geometry, colour), at.transmission);
            below.add(atlas.value(2, at.geometry, colour), at.reflection_below);
        }
        for (Errors* errors : {&R, &T, &below}) EXPECT_LE(errors->quantile(0.9), 5e-3);
    }
}

TEST(AtlasFile, LosesNoLightInAWhiteFurnace) {
    const Atlas atlas({{layer("henyey_greenstein:g=0.5", 1, infinity)}, ""});
    ASSERT_EQ(atlas.tiles->rows(), 1);
    for (const double mu_in : {0.1, 0.5, 0.93})
        EXPECT_NEAR(sent_out([&](double mu, double azimuth) {
                        return atlas.value(0, {mu_in, mu, azimuth});
                    }),
                    1, 2e-4);
}

TEST(AtlasFile, IsOnePartOfFourChannelsAndTellsWhatItHolds) {
    const TemporaryFolder folder;
    write_material(make_material({{over(layer("isotropic", 0.9, 1), 0.3)}, "A \"layer\""},
                                 MaterialFormat::exr_atlas),
                   folder / "atlas.exr");
    const std::string bytes = content(folder / "atlas.exr"), json = content(folder / "atlas.json");
    EXPECT_EQ(bytes.substr(4, 4), std::string("\x02\0\0\0", 4));  // version 2, no flags: one part
    for (const char* channel : {"A", "B", "G", "R"})
        expect_holds(bytes, {std::string(channel) + '\0' + '\x02'});
    expect_holds(bytes, "stratus:atlas");
    expect_holds(json, "\"A \\\"layer\\\". isotropic");
    expect_holds(json, "\"rows\": [\"reflection\"]");
    expect_holds(json, "\"optical_depth\": [null]");  // nothing passes
}

// A picture without its description is of no use: neither appears.
TEST(AtlasFile, AppearsWithItsDescriptionOrNotAtAll) {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder / "atlas.json");
    const MaterialFile file =
        make_material({{layer("isotropic", 0.9, 1)}, ""}, MaterialFormat::exr_atlas);
    EXPECT_THROW(write_material(file, folder / "atlas.exr"), std::runtime_error);
    EXPECT_EQ(folder.size(), 1);
}

}  // namespace
}  // namespace stratus::test
