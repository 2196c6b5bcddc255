#include <stratus/bake/recipe.h>

#include <stratus/base/constants.h>

#include "indices.h"
#include "refusal.h"
#include "small_recipe.h"
#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>

namespace stratus::test {
namespace {

/// A recipe of the keys that cannot be left out, and more lines.
std::string recipe_with(const std::string& lines) {
    return "phase_function = 'rayleigh'\n"
           "tolerance = 1e-2\n"
           "optical_depth = { min = 0.25, max = 2.0 }\n"
           "albedo = { min = 0.5, max = 1.0 }\n" +
           lines;
}

/// The same with one of its lines in another form.
std::string recipe_but(const std::string& key, const std::string& line) {
    std::string text = recipe_with("");
    const std::size_t begin = text.find(key + " =");
    return text.replace(begin, text.find('\n', begin) - begin, line);
}

void expect_recipe_refusal(const std::string& text, const Fragments& fragments) {
    SCOPED_TRACE(text);
    expect_refusal([&] { parse_recipe(text); }, fragments);
}

TEST(Recipe, HoldsItsText) {
    const std::string text =
        "title = \"Rings, \\\"thin\\\"\"\n"
        "phase_function = '0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5'\n"
        "tolerance = 2e-3\n"
        "optical_depth = { min = 0.01, max = inf }\n"
        "albedo = { min = 0.25, max = 0.75 }\n"
        "sides = ['transmission']\n"
        "orders = 'all'\n"
        "[discretisation]\n"
        "nodes = 24\n"
        "modes = 20\n"
        "mu_samples = 22\n"
        "azimuth_samples = 9\n"
        "azimuth_scale = 'square_root'\n"
        "optical_depth_samples_per_octave = 3\n"
        "deepest_optical_depth = 64.0\n"
        "albedo_samples = 11\n"
        "albedo_scale = 'fourth_root_of_complement'\n"
        "scheme = 'classic'\n";
    const Recipe recipe = parse_recipe(text);
    EXPECT_EQ(recipe.title, "Rings, \"thin\"");
    EXPECT_EQ(recipe.phase_text, "0.596*henyey_greenstein:g=-0.5 + 0.404*henyey_greenstein:g=0.5");
    EXPECT_EQ(recipe.phase_function.terms().size(), 2u);
    EXPECT_EQ(recipe.tolerance, 2e-3);
    expect_range(recipe.optical_depth, 0.01, infinity);
    expect_range(recipe.albedo, 0.25, 0.75);
    EXPECT_FALSE(recipe.reflection);
    EXPECT_TRUE(recipe.transmission);
    const Discretisation& d = recipe.discretisation;
    EXPECT_EQ(d.nodes, 24);
    EXPECT_EQ(d.modes, 20);
    EXPECT_EQ(d.mu_samples, 22);
    EXPECT_EQ(d.azimuth_samples, 9);
    EXPECT_EQ(d.azimuth_scale, AxisScale::square_root);
    EXPECT_EQ(d.optical_depth_samples_per_octave, 3);
    EXPECT_EQ(d.deepest_optical_depth, 64);
    EXPECT_EQ(d.albedo_samples, 11);
    EXPECT_EQ(d.albedo_scale, AxisScale::fourth_root_of_complement);
    EXPECT_EQ(d.scheme, Scheme::classic);
    EXPECT_EQ(recipe.text, text);
}

TEST(Recipe, HasDefaults) {
    const Recipe recipe = parse_recipe(recipe_with(""));
    EXPECT_EQ(recipe.title, "");
    EXPECT_TRUE(recipe.reflection);
    EXPECT_TRUE(recipe.transmission);
    const Discretisation& d = recipe.discretisation;
    for (const int open : {d.nodes, d.modes, d.mu_samples, d.azimuth_samples,
                           d.optical_depth_samples_per_octave, d.albedo_samples})
        EXPECT_EQ(open, 0);
    EXPECT_EQ(d.deepest_optical_depth, 0);
    EXPECT_FALSE(d.azimuth_scale);
    EXPECT_FALSE(d.albedo_scale);
    EXPECT_EQ(d.scheme, Scheme::harmonic);
}

TEST(Recipe, KnowsAllDirectionsUnlessTheyAreNarrowed) {
    const Recipe all = parse_recipe(recipe_with(""));
    expect_range(all.mu_in, 0, 1);
    expect_range(all.mu_out, 0, 1);
    expect_range(all.azimuth, 0, 180);
    const Recipe some = parse_recipe(recipe_with(
        "mu_in = 0.375\nmu_out = { min = 0.25, max = 0.5 }\nazimuth_deg = { min = 171, max = 180 "
        "}\n"));
    expect_range(some.mu_in, 0.375, 0.375);
    expect_range(some.mu_out, 0.25, 0.5);
    expect_range(some.azimuth, 171, 180);
}

TEST(Recipe, RefusesDirectionsOutOfRange) {
    for (const char* key : {"mu_in", "mu_out"}) {
        const auto refused = [&](const std::string& value, const Fragments& says) {
            expect_recipe_refusal(recipe_with(key + (" = " + value) + "\n"), says);
        };
        refused("0.00001", {"recipe", key, ".max", "[0.0001, 1]", "got 1e-05"});
        refused("[0.1, 0.2]", {"recipe", key, "a number"});
        refused("{ min = 0.5, max = 0.25 }", {"recipe", key, ".min", "at most max", "got 0.5"});
        refused("{ min = 0.5 }", {"recipe", key, ".max", "present"});
        refused("{ min = 0.5, max = 0.50000001 }", {"recipe", key, "equal to min or 1e-06"});
    }
    expect_recipe_refusal(recipe_with("azimuth_deg = 0\n"),
                          "azimuth_deg.max must be in [0.001, 180], got 0");
    expect_recipe_refusal(recipe_with("azimuth = 5\n"), "'azimuth'; did you mean 'azimuth_deg'");
}

TEST(Recipe, TakesTheAlbedoOfDroplets) {
    std::string text = recipe_but("albedo", "albedo = 'phase_function'");
    expect_recipe_refusal(text, {"albedo", "droplets", "phase_function"});
    text.replace(text.find("rayleigh"), 8, "mie:radius=1um,index=1.5+0.01i");
    const Recipe recipe = parse_recipe(text);
    EXPECT_EQ(recipe.albedo.min, recipe.phase_function.albedo());
    EXPECT_EQ(recipe.albedo.max, recipe.albedo.min);
    EXPECT_LT(recipe.albedo.max, 0.95);
    EXPECT_EQ(parse_recipe(resolved_text(recipe)).albedo.min, recipe.albedo.min);
}

TEST(Recipe, MayReachToInfinity) {
    const Recipe recipe =
        parse_recipe(recipe_but("optical_depth", "optical_depth = { min = 0.1, max = inf }"));
    EXPECT_EQ(recipe.optical_depth.max, infinity);
    const Recipe alone =
        parse_recipe(recipe_but("optical_depth", "optical_depth = { min = inf, max = inf }") +
                     "sides = ['reflection']\n");
    EXPECT_EQ(alone.optical_depth.min, infinity);
}

TEST(Recipe, HasReflectionAloneAtInfinityAlone) {
    const std::string text =
        recipe_but("optical_depth", "optical_depth = { min = inf, max = inf }");
    const Recipe recipe = parse_recipe(text);
    EXPECT_TRUE(recipe.reflection);
    EXPECT_FALSE(recipe.transmission);
    EXPECT_EQ(resolved_text(recipe),
              resolved_text(parse_recipe(text + "sides = ['reflection']\n")));
}

TEST(Recipe, RefusesTransmissionAtInfinityAlone) {
    for (const char* const sides : {"['reflection', 'transmission']", "['transmission']"})
        expect_recipe_refusal(
            recipe_but("optical_depth", "optical_depth = { min = inf, max = inf }") +
                "sides = " + sides + "\n",
            {"recipe: line", "sides", "[\"reflection\"]", "inf alone", "got transmission"});
}

TEST(Recipe, RequiresItsFourKeys) {
    for (const char* key : {"phase_function", "tolerance", "optical_depth", "albedo"})
        expect_recipe_refusal(recipe_but(key, ""), {"recipe", key});
    expect_recipe_refusal("", "recipe: phase_function");
}

TEST(Recipe, RefusesUnknownKeysAndNamesTheNearest) {
    expect_recipe_refusal(recipe_with("tolerence = 1e-3\n"),
                          "recipe: line 5: unknown key 'tolerence'; did you mean 'tolerance'");
    expect_recipe_refusal(
        recipe_but("albedo", "albedo = { min = 0, maximum = 1 }"),
        "recipe: line 4: unknown key 'albedo.maximum'; did you mean 'albedo.max'");
    expect_recipe_refusal(recipe_with("[discretisation]\nmu_sample = 8\n"),
                          {"recipe", "'discretisation.mu_sample'", "'discretisation.mu_samples'"});
    expect_recipe_refusal(
        recipe_with("[discretization]\nmu_samples = 8\n"),
        "recipe: line 5: unknown key 'discretization'; did you mean 'discretisation'");
}

TEST(Recipe, RefusesMalformedToml) {
    expect_recipe_refusal("title = \"Rings\"\ntolerance = \n", "recipe: line 2");
    expect_recipe_refusal(recipe_with("albedo = { min = 0, max = 1 }\n"), "recipe: line 5");
}

TEST(Recipe, RefusesValuesOfAnotherType) {
    expect_recipe_refusal(recipe_but("albedo", "albedo = 0.5"),
                          "recipe: line 4: albedo must be a table { min");
    expect_recipe_refusal(recipe_with("sides = 'reflection'\n"),
                          "recipe: line 5: sides must be a list");
    expect_recipe_refusal(recipe_with("sides = [1]\n"), "recipe: line 5: sides must be a list");
}

TEST(Recipe, RefusesRangesThatDescendOrHaveOneEnd) {
    expect_recipe_refusal(recipe_but("optical_depth", "optical_depth = { min = 2, max = 1 }"),
                          "recipe: line 3: optical_depth.min must be at most max, got 2");
    expect_recipe_refusal(recipe_but("albedo", "albedo = { min = 0.75, max = 0.5 }"),
                          "recipe: line 4: albedo.min must be at most max, got 0.75");
    expect_recipe_refusal(recipe_but("albedo", "albedo = { min = 0.5 }"),
                          "recipe: line 4: albedo.max");
    expect_recipe_refusal(
        recipe_with("[discretisation]\nalbedo_samples = 1\n"),
        "discretisation.albedo_samples must be 2 or more over a range of albedos, got 1");
}

TEST(Recipe, RefusesUnknownSides) {
    expect_recipe_refusal(recipe_with("sides = ['reflection', 'absorption']\n"),
                          {"recipe", "sides", "\"reflection\", \"transmission\"", "absorption"});
    expect_recipe_refusal(recipe_with("sides = []\n"), {"recipe", "sides", "an empty list"});
}

TEST(Recipe, ReadsOrders) {
    EXPECT_EQ(parse_recipe(recipe_with("orders = 'all'\n")).orders, 0);
    EXPECT_EQ(parse_recipe(recipe_with("orders = 3\n")).orders, 3);
    expect_holds(resolved_text(parse_recipe(recipe_with("orders = 3\n"))), "orders = 3\n");
}

TEST(Recipe, RefusesOtherOrders) {
    const Fragments allowed{"recipe: line 5: orders must be \"all\" or a whole number in [2, 100]"};
    for (const char* orders : {"'first'", "1", "101", "2.5", "[2]"})
        expect_recipe_refusal(recipe_with(std::string("orders = ") + orders + "\n"), allowed);
    expect_recipe_refusal(recipe_with("orders = 2\n[discretisation]\nscheme = 'classic'\n"),
                          {"recipe", "discretisation.scheme", "orders", "classic"});
}

TEST(Recipe, RefusesUnknownScalesAndSchemes) {
    expect_recipe_refusal(
        recipe_with("[discretisation]\nazimuth_scale = 'logarithmic'\n"),
        {"recipe", "discretisation.azimuth_scale", "\"square_root\"", "logarithmic"});
    expect_recipe_refusal(
        recipe_with("[discretisation]\nalbedo_scale = 'linear'\n"),
        {"recipe", "discretisation.albedo_scale", "\"fourth_root_of_complement\"", "linear"});
    expect_recipe_refusal(recipe_with("[discretisation]\nscheme = 'monte_carlo'\n"),
                          {"recipe", "discretisation.scheme", "\"classic\"", "monte_carlo"});
}

TEST(Recipe, RefusesUnknownPhaseFunctions) {
    expect_recipe_refusal(recipe_but("phase_function", "phase_function = 'henyey_greenstein:g=1'"),
                          "henyey_greenstein: g must be in (-1");
    expect_recipe_refusal(recipe_but("phase_function", "phase_function = 'mie'"), "mie");
}

TEST(ReadRecipe, FindsPhaseTablesBesideTheRecipe) {
    const TemporaryFolder folder;
    set_content(folder / "curve.csv", "phase_angle_deg,value\n0,3\n90,1\n180,2\n");
    set_content(folder / "moon.toml",
                recipe_but("phase_function", "phase_function = 'tabulated:file=curve.csv'"));
    std::vector<std::string> notes;
    Recipe recipe = read_recipe(folder / "moon.toml", &notes);
    ASSERT_EQ(recipe.phase_function.terms().size(), 1u);
    EXPECT_TRUE(std::holds_alternative<Tabulated>(recipe.phase_function.terms()[0].second));
    EXPECT_FALSE(notes.empty());  // the values had to be scaled
    // and what comes of it needs the file no more
    recipe.discretisation = {24, 20, 22, 9, 3, 0, 11, {}, Scheme::harmonic};
    EXPECT_EQ(parse_recipe(resolved_text(recipe)).phase_function.text(),
              recipe.phase_function.text());
}

TEST(ReadRecipe, NamesFileAndLineOfABadKey) {
    const TemporaryFolder folder;
    const std::string name = (folder / "rings.toml").string();
    const auto refuse = [&](const std::string& text, const std::string& start) {
        set_content(folder / "rings.toml", text);
        expect_refusal([&] { read_recipe(name); }, {"recipe: " + name + start});
    };
    refuse(recipe_with("tolerence = 1\n"), ", line 5: unknown key 'tolerence'");
    refuse(recipe_but("tolerance", "tolerance = 1"), ", line 2: tolerance must be");
    refuse(recipe_but("tolerance", "tolerance = "), ", line 2: ");
    refuse(recipe_but("tolerance", ""), ": tolerance must be present");
    refuse(recipe_but("phase_function", "phase_function = 'henyey_greenstein:g=1'"),
           ", line 1: phase_function: henyey_greenstein: g must be");
    refuse(recipe_with("[discretisation]\nmixture_samples = 3\n"),
           ", line 6: discretisation.mixture_samples must be absent");
    set_content(folder / "curve.csv", "phase_angle_deg,value\n0,3\n90,-1\n180,2\n");
    refuse(recipe_but("phase_function", "phase_function = 'tabulated:file=curve.csv'"),
           ", line 1: phase_function: tabulated: value (" + (folder / "curve.csv").string() +
               ", line 3) must be");
}

TEST(ReadRecipe, RefusesMissingFilesAndFolders) {
    const TemporaryFolder folder;
    for (const std::filesystem::path& path : {folder / "missing.toml", folder.path()})
        expect_refusal<std::runtime_error>([&] { read_recipe(path); },
                                           {path.c_str(), "cannot be read"});
}

TEST(Recipe, ReadsTheLowerBoundary) {
    const Recipe bare = parse_recipe(recipe_with(""));
    EXPECT_FALSE(bare.lower_boundary.is_present());
    const Recipe ground = parse_recipe(recipe_with("[below]\nlambert_albedo = 0.3\n"));
    EXPECT_EQ(ground.lower_boundary.kind, LowerBoundary::Kind::surface);
    EXPECT_EQ(ground.lower_boundary.albedo, 0.3);
    EXPECT_TRUE(ground.reflection);
    EXPECT_FALSE(ground.transmission);
    const Recipe dust = parse_recipe(recipe_with(
        "sides = ['reflection']\n[below]\nphase_function = 'lambert_sphere'\nalbedo = 1"));
    EXPECT_EQ(dust.lower_boundary.kind, LowerBoundary::Kind::layer);
    EXPECT_EQ(dust.lower_boundary.phase_function.text(), PhaseFunction::lambert_sphere().text());
    EXPECT_EQ(dust.lower_boundary.albedo, 1);
}

TEST(Recipe, RefusesTransmissionOverGround) {
    for (const char* const sides : {"['reflection', 'transmission']", "['transmission']"})
        expect_recipe_refusal(
            recipe_with(std::string("sides = ") + sides + "\n[below]\nlambert_albedo = 0.3"),
            {"recipe: line 5: sides", "[\"reflection\"]", "[below]", "nothing pass",
             "got transmission"});
}

TEST(Recipe, RefusesUnknownGrounds) {
    expect_recipe_refusal(
        recipe_with("[below]\nlambert = 1"),
        "recipe: line 6: unknown key 'below.lambert'; did you mean 'below.albedo'");
    expect_recipe_refusal(
        recipe_with("[below]\nlambert_albedo = 1\nalbedo = 1"),
        "recipe: line 5: below must be lambert_albedo alone, ground alone, or both");
}

TEST(Recipe, MayMixTwoPhaseFunctions) {
    EXPECT_TRUE(parse_recipe(recipe_with("")).family.empty());
    const Recipe all = parse_recipe(recipe_with("second_phase_function = 'isotropic'\n"));
    ASSERT_TRUE(is_mixture_alone(all));
    expect_range(*mixture_range(all), 0, 1);
    EXPECT_EQ(all.second_phase_function.text(), "isotropic");
    const Recipe some = parse_recipe(
        recipe_with("second_phase_function = 'isotropic'\nmixture = { min = 0.25, max = 0.5 }\n"
                    "[discretisation]\nmixture_samples = 4\n"));
    expect_range(*mixture_range(some), 0.25, 0.5);
    EXPECT_EQ(some.discretisation.family_samples[0], 4);
    EXPECT_NEAR(at_member(some, {0.25}).phase_function(1), 0.25 * 1.5 + 0.75, 1e-15);
}

TEST(Recipe, RefusesWhatIsNestedTooDeep) {  // the stack ended, and the program with it
    std::string key = "a", lists, tables;
    for (int i = 1; i < 40'000; ++i) key += ".a", lists += '[', tables += "{a=";
    const auto refused = [](const std::string& lines, const char* sentence) {
        expect_refusal([&] { parse_recipe(recipe_with(lines)); }, {"line 5", sentence, "got more"});
    };
    refused(key + " = 1\n", "a key must have at most 32 dotted parts");
    refused("[" + key + "]\n", "a key must have at most 32 dotted parts");
    refused("a = " + lists, "brackets must be nested at most 32 deep");
    refused("a = " + tables, "brackets must be nested at most 32 deep");
}

TEST(Recipe, CountsNoDotsOrBracketsInTexts) {
    const std::string dots(100, '.'), brackets(100, '[');
    for (const char* const quote : {"'", "\"", "'''", "\"\"\""}) {
        const std::string text = std::string(quote) + dots + brackets + quote;
        EXPECT_NO_THROW(parse_recipe(
            recipe_but("phase_function", "phase_function = 'rayleigh' # " + dots + brackets)));
        expect_refusal([&] { parse_recipe(recipe_with("depth = " + text)); },
                       "unknown key 'depth'");
    }
}

TEST(Recipe, ShowsNoControlCharacters) {
    expect_refusal([] { parse_recipe(recipe_with("\"\\u001b[2J\" = 1\n")); },
                   "unknown key '\\x1b[2J'");
}

TEST(Recipe, IsNoDeviceWithoutEnd) {
    if (!std::filesystem::is_character_file("/dev/zero")) GTEST_SKIP() << "no /dev/zero here";
    expect_refusal<std::runtime_error>([] { read_recipe("/dev/zero"); },
                                       "/dev/zero: must have at most 67108864 bytes");
}

TEST(Recipe, RefusesMixturesOfOneShare) {
    const std::string second = "second_phase_function = 'isotropic'\nmixture = ";
    expect_recipe_refusal(recipe_with(second + "{ min = 0.5, max = 0.5 }\n"),
                          {"recipe: line 6: mixture.max", "above min", "sum", "0.5"});
    expect_recipe_refusal(recipe_with("second_phase_function = 'mie'\n"), "mie");
}

TEST(Recipe, RefusesAMixtureOfOnePhaseFunction) {
    expect_recipe_refusal(recipe_with("mixture = { min = 0, max = 1 }\n"),
                          {"recipe: line 5: mixture", "no second_phase_function", "given"});
    expect_recipe_refusal(
        recipe_with("[discretisation]\nmixture_samples = 5\n"),
        {"recipe: line 6: discretisation.mixture_samples", "no second_phase_function"});
}

/// The choices of `a`, written as a text and read again.
void expect_round_trip(const Recipe& a) {
    const Recipe b = parse_recipe(resolved_text(a));
    EXPECT_EQ(a.title, b.title);
    EXPECT_EQ(a.phase_function.text(), b.phase_function.text());
    EXPECT_EQ(a.second_phase_function.text(), b.second_phase_function.text());
    ASSERT_EQ(a.family.size(), b.family.size());
    for (const auto k : indices(a.family)) {
        EXPECT_EQ(a.family[k].parameter, b.family[k].parameter);
        expect_range(a.family[k].range, b.family[k].range.min, b.family[k].range.max);
        EXPECT_EQ(a.family[k].values, b.family[k].values);
    }
    EXPECT_EQ(a.tolerance, b.tolerance);
    for (const auto range : {&Recipe::optical_depth, &Recipe::albedo, &Recipe::mu_in,
                             &Recipe::mu_out, &Recipe::azimuth})
        expect_range(a.*range, (b.*range).min, (b.*range).max);
    expect_same(a.lower_boundary, b.lower_boundary);
    EXPECT_EQ(a.reflection, b.reflection);
    EXPECT_EQ(a.transmission, b.transmission);
    expect_same(a.discretisation, b.discretisation);
}

TEST(Recipe, RefusesDeepestSamplesOutsideTheAxis) {
    for (const char* range : {"{ min = 1, max = inf }", "{ min = 0.1, max = 8 }"})
        expect_refusal(
            [&] {
                parse_recipe("phase_function = 'rayleigh'\ntolerance = 1e-2\noptical_depth = " +
                             std::string(range) +
                             "\nalbedo = { min = 0.5, max = 1 }\n[discretisation]\n"
                             "deepest_optical_depth = 0.5\n");
            },
            {"deepest_optical_depth", "at least optical_depth.min", "got 0.5"});
}

TEST(Recipe, RefusesRangesTooNarrowToSample) {
    expect_refusal(
        [] {
            parse_recipe(
                "phase_function = 'rayleigh'\ntolerance = 1e-2\n"
                "optical_depth = { min = 1, max = 2 }\n"
                "albedo = { min = 0.9999999999999999, max = 1 }\n");
        },
        "albedo.max must be equal to min or 1e-9 above it, got 1");
}

TEST(ResolvedText, RoundTrips) {
    Recipe recipe = parse_recipe(recipe_with("title = 'A \"title\" with \\ and \u03c4'\n"));
    recipe.phase_function = PhaseFunction::henyey_greenstein(1.0 / 3);
    recipe.tolerance = 1.0 / 300;
    recipe.discretisation = {24, 20, 22, 9, 3, 0, 11, {}, Scheme::classic};
    expect_round_trip(recipe);

    recipe.optical_depth = {1.0 / 7, infinity};
    recipe.albedo = {0.1 + 0.2, 1};
    recipe.transmission = false;
    recipe.discretisation.deepest_optical_depth = 100.0 / 7;
    recipe.discretisation.scheme = Scheme::harmonic;
    expect_round_trip(recipe);

    recipe.lower_boundary = LowerBoundary::surface(1.0 / 7);
    expect_round_trip(recipe);
    recipe.lower_boundary =
        LowerBoundary::layer(PhaseFunction::henyey_greenstein(1.0 / 3), 0.1 + 0.2);
    expect_round_trip(recipe);

    set_mixture(recipe, PhaseFunction::henyey_greenstein(-1.0 / 3), {1.0 / 7, 1});
    recipe.discretisation.family_samples = {5, 0};
    expect_round_trip(recipe);

    Recipe droplets = recipe;
    droplets.phase_function = parse_phase_function("mie:radius=10um");
    droplets.second_phase_function = {};
    droplets.family = {{PhaseParameter::radius, {10.0 / 3, 20}, {}},
                       {PhaseParameter::wavelength, {0.45, 0.7}, {0.45, 5.0 / 9, 0.7}}};
    expect_round_trip(droplets);

    recipe.discretisation.deepest_optical_depth = 1e9;  // the largest, and a whole number
    expect_round_trip(recipe);

    recipe.mu_in = {1.0 / 3, 1.0 / 3};
    recipe.mu_out = {0, 1.0 / 7};
    recipe.azimuth = {100.0 / 3, 180};
    expect_round_trip(recipe);

    recipe.optical_depth = {infinity, infinity};
    recipe.discretisation.optical_depth_samples_per_octave = 0;
    recipe.discretisation.deepest_optical_depth = 0;
    expect_round_trip(recipe);
}

}  // namespace
}  // namespace stratus::test
