#include <stratus/scene/table_cache.h>

#include <stratus/bake/bake.h>
#include <stratus/io/table_file.h>
#include <stratus/scene/layer_tables.h>

#include "temporary_folder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <vector>

namespace stratus::test {
namespace {

std::vector<char> keep(TableCache& cache, const Recipe& recipe, const Table& table) {
    return cache.keep(recipe, table, pack(table));
}

namespace fs = std::filesystem;

Recipe quick_recipe(double albedo) {
    Recipe recipe;
    recipe.phase_function = PhaseFunction::isotropic();
    recipe.tolerance = 0.05;
    recipe.optical_depth = {0.5, 1};
    recipe.albedo = {albedo, albedo};
    recipe.transmission = false;
    return recipe;
}

std::vector<fs::path> files_in(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    return files;
}

TEST(TableCache, FindsWhatItKept) {
    const TemporaryFolder folder;
    TableCache cache(folder.path() / "new", 1 << 30);
    const Recipe recipe = quick_recipe(0.5);
    EXPECT_FALSE(cache.find(recipe));
    const Table table = bake(recipe);
    keep(cache, recipe, table);
    EXPECT_TRUE(cache.trouble().empty());
    const std::optional<PackedTable> found = TableCache(folder.path() / "new", 1).find(recipe);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->header().plane_albedo, table.plane_albedo);
    const Geometry at{0.5, 0.7, 1};
    const double expected = reflection(table.view(), 0.5, 0.8, at).total();
    EXPECT_NEAR(found->reflection(0.5, 0.8, at).total(), expected, recipe.tolerance * expected);
}

TEST(TableCache, FindsWiderTablesAndNoOthers) {
    const TemporaryFolder folder;
    TableCache cache(folder.path(), 1 << 30);
    Recipe wide = quick_recipe(0.5);
    wide.albedo = {0.5, 0.9};
    wide.title = "another title";
    keep(cache, wide, bake(wide));
    Recipe narrow = quick_recipe(0.7);
    EXPECT_TRUE(cache.find(narrow));
    narrow.optical_depth = {1, 1};
    EXPECT_TRUE(cache.find(narrow));
    Recipe other = narrow;
    other.albedo = {0.7, 0.95};
    EXPECT_FALSE(cache.find(other)) << "albedo";
    other = narrow;
    other.optical_depth = {0.25, 1};
    EXPECT_FALSE(cache.find(other)) << "optical depth";
    other = narrow;
    other.mu_out = {0.2, 0.3};
    other.azimuth = {10, 20};
    EXPECT_TRUE(cache.find(other)) << "directions of view";
    other = narrow;
    other.transmission = true;
    EXPECT_FALSE(cache.find(other)) << "sides";
    other = narrow;
    other.tolerance = 0.04;
    EXPECT_FALSE(cache.find(other)) << "tolerance";
    other = narrow;
    other.phase_function = PhaseFunction::rayleigh();
    EXPECT_FALSE(cache.find(other)) << "phase function";
    other = narrow;
    other.discretisation.modes = 1;
    EXPECT_FALSE(cache.find(other)) << "discretisation";
}

TEST(TableCache, FindsNoTableOfFewerDirections) {
    const TemporaryFolder folder;
    TableCache cache(folder.path(), 1 << 30);
    Recipe asked = quick_recipe(0.5);
    asked.mu_in = {0.4, 0.4};
    asked.mu_out = {0.2, 0.5};
    asked.azimuth = {10, 40};
    keep(cache, asked, bake(asked));
    EXPECT_TRUE(cache.find(asked));
    for (Range Recipe::*const range : {&Recipe::mu_in, &Recipe::mu_out, &Recipe::azimuth}) {
        Recipe wider = asked;
        (wider.*range).max += 0.1;
        EXPECT_FALSE(cache.find(wider));
        wider = asked;
        (wider.*range).min -= 0.1;
        EXPECT_FALSE(cache.find(wider));
    }
}

TEST(TableCache, PassesOverDamagedAndForeignFiles) {
    const TemporaryFolder folder;
    TableCache cache(folder.path(), 1 << 30);
    const Recipe recipe = quick_recipe(0.5), other = quick_recipe(0.6);
    keep(cache, other, bake(other));
    const fs::path of_other = files_in(folder.path())[0];
    const Table table = bake(recipe);
    keep(cache, recipe, table);
    fs::path own;
    for (const fs::path& file : files_in(folder.path()))
        if (file != of_other) own = file;
    fs::copy_file(of_other, own, fs::copy_options::overwrite_existing);
    EXPECT_FALSE(cache.find(recipe)) << "another's table under this name";
    const std::vector<char> packed = pack(table);
    std::ofstream(own, std::ios::binary)
        .write(packed.data(), static_cast<std::streamsize>(packed.size()));
    EXPECT_FALSE(cache.find(recipe)) << "a table without a key";
    std::ofstream(own) << "no table";
    EXPECT_FALSE(cache.find(recipe));
    keep(cache, recipe, table);
    EXPECT_TRUE(cache.find(recipe));
    std::fstream file(own, std::ios::binary | std::ios::in | std::ios::out);
    file.seekg(-100, std::ios::end);
    const char byte = static_cast<char>(file.get());
    file.seekp(-100, std::ios::end);
    file.put(static_cast<char>(byte ^ 1));
    file.close();
    EXPECT_FALSE(cache.find(recipe)) << "one bit of a number";
}

TEST(TableCache, RemovesWhatWasLongestUnused) {
    const TemporaryFolder folder;
    TableCache plenty(folder.path(), 1 << 30);
    std::vector<Recipe> recipes;
    std::uintmax_t size = 0;
    for (const double albedo : {0.1, 0.2, 0.3}) {
        recipes.push_back(quick_recipe(albedo));
        keep(plenty, recipes.back(), bake(recipes.back()));
    }
    const fs::path foreign = folder.path() / "notes.stratus";
    std::ofstream(foreign) << "not ours";
    for (const fs::path& file : files_in(folder.path())) {
        if (file == foreign) continue;
        size += fs::file_size(file);
        fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(1));
    }
    EXPECT_TRUE(plenty.find(recipes[0])) << "makes it the youngest";
    TableCache small(folder.path(), size - 1);
    const Recipe fourth = quick_recipe(0.4);
    keep(small, fourth, bake(fourth));
    EXPECT_TRUE(small.find(fourth));
    EXPECT_TRUE(small.find(recipes[0]));
    EXPECT_TRUE(!small.find(recipes[1]) || !small.find(recipes[2]));
    EXPECT_TRUE(fs::exists(foreign));
}

TEST(TableCache, KeepsTheScatteringOfDroplets) {
    const TemporaryFolder folder;
    const char* const text = "mie:radius=2um,variance=0.1,wavelength=0.55um,material=water";
    const std::vector<double> computed = parse_phase_function(text).moments(60);
    TableCache(folder.path(), 1 << 20).keep_droplets();
    EXPECT_EQ(parse_phase_function(text).moments(60), computed);
    ASSERT_EQ(files_in(folder.path()).size(), 1u);
    const fs::path file = files_in(folder.path())[0];
    const auto size = fs::file_size(file);
    const auto kept = fs::last_write_time(file);
    fs::last_write_time(file, kept - std::chrono::hours(1));
    EXPECT_EQ(parse_phase_function(text).moments(60), computed) << "found";
    EXPECT_GE(fs::last_write_time(file), kept) << "the youngest again";
    EXPECT_EQ(fs::file_size(file), size);
    fs::resize_file(file, size - 8);
    EXPECT_EQ(parse_phase_function(text).moments(60), computed) << "of a damaged file";
    EXPECT_EQ(fs::file_size(file), size) << "which is replaced";
    // Old ones go when tables take their place.
    TableCache small(folder.path(), 1);
    keep(small, quick_recipe(0.5), bake(quick_recipe(0.5)));
    EXPECT_FALSE(fs::exists(file));
    Mie::keep_scattering_in({});
}

TEST(TableCache, GoesOnWithoutAFolder) {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "file") << "in the way";
    TableCache cache(folder.path() / "file" / "folder", 1 << 30);
    const Recipe recipe = quick_recipe(0.5);
    EXPECT_FALSE(cache.find(recipe));
    keep(cache, recipe, bake(recipe));
    EXPECT_FALSE(cache.trouble().empty());
}

}  // namespace
}  // namespace stratus::test
