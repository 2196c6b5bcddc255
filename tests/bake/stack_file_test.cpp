#include <stratus/bake/stack_file.h>

#include "indices.h"
#include "refusal.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace stratus::test {
namespace {

const std::string air =
    "[[layers]]\n"
    "phase_function = 'rayleigh'\n"
    "albedo = 1\n"
    "optical_depth = 0.2\n";

std::string deep(const std::string& depth) {
    return "[[layers]]\n"
           "phase_function = 'henyey_greenstein:g=0.7'\n"
           "albedo = 0.95\n"
           "optical_depth = " +
           depth + "\n";
}

void expect_stack_refusal(const std::string& text, const Fragments& fragments) {
    SCOPED_TRACE(text);
    expect_refusal([&] { parse_stack(text); }, fragments);
}

TEST(StackFile, HoldsItsText) {
    const Stack stack = parse_stack(air + deep("4") + "[below]\nlambert_albedo = 0.3\n");
    ASSERT_EQ(stack.layers.size(), 2u);
    EXPECT_EQ(stack.layers[0].phase_function.text(), PhaseFunction::rayleigh().text());
    EXPECT_EQ(stack.layers[0].albedo, 1);
    EXPECT_EQ(stack.layers[0].optical_depth, 0.2);
    EXPECT_EQ(stack.layers[1].phase_function.asymmetry(), 0.7);
    EXPECT_EQ(stack.layers[1].albedo, 0.95);
    EXPECT_EQ(stack.layers[1].optical_depth, 4);
    EXPECT_EQ(stack.lower_boundary.kind, LowerBoundary::Kind::surface);
    EXPECT_EQ(stack.lower_boundary.albedo, 0.3);
}

TEST(StackFile, HoldsThreeColoursForScenesAlone) {
    const TemporaryFolder folder;
    const std::string haze =
        "[[layers]]\nphase_function = ['isotropic', 'rayleigh', 'isotropic']\n"
        "albedo = [0.5, 0.6, 0.7]\noptical_depth = [1, 2, 3]\n";
    const auto write = [&](const std::string& text) { set_content(folder / "s.toml", text); };
    write(haze + deep("inf"));
    const std::vector<Stack> stacks = read_coloured_stack(folder / "s.toml");
    ASSERT_EQ(stacks.size(), 3u);
    for (const auto c : three_channels) {
        const std::vector<StackLayer>& layers = stacks[c].layers;
        EXPECT_EQ(layers[0].phase_function.text(), c == 1 ? "rayleigh" : "isotropic");
        EXPECT_DOUBLE_EQ(layers[0].albedo, 0.5 + 0.1 * static_cast<double>(c));
        EXPECT_EQ(layers[0].optical_depth, static_cast<double>(c + 1));
        EXPECT_EQ(layers[1].albedo, 0.95);
        EXPECT_TRUE(std::isinf(layers[1].optical_depth));
    }
    write(air + deep("4") + "[below]\nlambert_albedo = 0.3\n");
    EXPECT_EQ(read_coloured_stack(folder / "s.toml").size(), 1u);
    expect_stack_refusal(haze, "line 1: layers must be without lists of three where one colour");
    for (const auto& [depths, met] :
         {std::pair("[1, 2, inf]", "got inf"), {"[1, 2]", "three numbers"}}) {
        std::string text = haze;
        write(text.replace(text.find("[1, 2, 3]"), 9, depths));
        expect_refusal([&] { read_coloured_stack(folder / "s.toml"); },
                       {"line 4: layer 1.optical_depth", met});
    }
}

TEST(StackFile, MayEndInASemiInfiniteLayer) {
    const Stack last = parse_stack(air + deep("inf"));
    EXPECT_TRUE(std::isinf(last.layers[1].optical_depth));
    EXPECT_FALSE(last.lower_boundary.is_present());
    const Stack below =
        parse_stack(air + "[below]\nphase_function = 'lambert_sphere'\nalbedo = 0.5");
    EXPECT_EQ(below.lower_boundary.kind, LowerBoundary::Kind::layer);
    EXPECT_EQ(below.lower_boundary.albedo, 0.5);
    EXPECT_EQ(below.lower_boundary.phase_function.text(), PhaseFunction::lambert_sphere().text());
}

TEST(StackFile, FindsPhaseFunctionsBesideIt) {
    const TemporaryFolder folder;
    set_content(folder / "dust.csv", "phase_angle_deg,value\n0,2\n90,1\n180,1\n");
    set_content(folder / "stack.toml",
                "[[layers]]\nphase_function = 'tabulated:file=dust.csv'\n"
                "albedo = 1\noptical_depth = 1\n");
    const Stack stack = read_stack(folder / "stack.toml");
    EXPECT_GT(stack.layers[0].phase_function(-1), stack.layers[0].phase_function(1));
    expect_refusal<std::runtime_error>([&] { read_stack(folder / "missing.toml"); },
                                       "missing.toml: cannot be read");
}

TEST(StackFile, RefusesNoLayers) {
    expect_stack_refusal("", "stack: layers must be tables [[layers]], got nothing");
    expect_stack_refusal("layers = 3",
                         "stack: line 1: layers must be tables [[layers]], got another value");
    expect_stack_refusal("layers = [3]",
                         "stack: line 1: layers must be tables [[layers]], got another value");
    expect_stack_refusal("[layers]\nalbedo = 1", "stack: line 1: layers must be tables [[layers]]");
}

TEST(StackFile, RefusesRecipesAndScenesByName) {
    expect_stack_refusal("phase_function = 'isotropic'\nalbedo = { min = 0.1, max = 1 }",
                         "must be a stack, got a recipe, which is for `stratus bake`");
    expect_stack_refusal("[camera]\n[layer]",
                         "must be a stack, got a scene, which is for `stratus render`");
}

TEST(StackFile, RefusesUnknownKeysWithTheNearestKnown) {
    expect_stack_refusal("layer = 3", "line 1: unknown key 'layer'; did you mean 'layers'");
    expect_stack_refusal(
        air + "opticaldepth = 1",
        "line 5: unknown key 'layer 1.opticaldepth'; did you mean 'layer 1.optical_depth'");
    expect_stack_refusal(
        air + "[below]\nlambert_albdo = 0.3",
        "line 6: unknown key 'below.lambert_albdo'; did you mean 'below.lambert_albedo'");
}

TEST(StackFile, RefusesValuesOutOfRange) {
    expect_stack_refusal(
        air + deep("-1"),
        "layer 2.optical_depth must be a number or three numbers in [0, inf], got -1");
    expect_stack_refusal(
        air + deep("nan"),
        "layer 2.optical_depth must be a number or three numbers in [0, inf], got nan");
    expect_stack_refusal(
        air + deep("'thick'"),
        "layer 2.optical_depth must be a number or three numbers in [0, inf], got 'thick'");
    expect_stack_refusal("[[layers]]\nphase_function = 'rayleigh'\nalbedo = 1.1\noptical_depth = 1",
                         "layer 1.albedo must be a number or three numbers in [0, 1], got 1.1");
}

TEST(StackFile, RefusesSemiInfiniteLayersAboveOthers) {
    expect_stack_refusal(
        deep("inf") + air,
        "layer 1.optical_depth must be finite where a layer or [below] lies under it, got inf");
    expect_stack_refusal(
        deep("inf") + "[below]\nlambert_albedo = 0",
        "layer 1.optical_depth must be finite where a layer or [below] lies under it, got inf");
}

TEST(StackFile, RefusesIncompleteLowerBoundaries) {
    expect_stack_refusal(air + "[below]\nlambert_albedo = 0.3\nalbedo = 1",
                         "below must be lambert_albedo alone, ground alone, or both");
    expect_stack_refusal(air + "[below]\nlambert_albedo = 0.3\nground = 'ocean:wind=5'",
                         {"below", "ground alone", "got lambert_albedo and ground"});
    expect_stack_refusal(air + "[below]\nground = 'ocean:wind=-1'",
                         "line 6: below.ground: ocean: wind must be in [0, 50] m/s, got -1");
    expect_stack_refusal(air + "[below]\n", {"below", "lambert_albedo alone", "got nothing"});
    expect_stack_refusal(air + "[below]\nalbedo = 1",
                         {"below", "both phase_function and albedo", "got albedo alone"});
    expect_stack_refusal(air + "[below]\nphase_function = 'rayleigh'",
                         {"below", "both", "got phase_function alone"});
    expect_stack_refusal("below = 3\n" + air, "below must be a table");
}

TEST(StackFile, RefusesMalformedToml) { expect_stack_refusal("[[layers]\n", "stack: line 1"); }

}  // namespace
}  // namespace stratus::test
