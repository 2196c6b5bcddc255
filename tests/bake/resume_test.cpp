#include <stratus/bake/bake.h>

#include "all_near.h"
#include "instruction_sets.h"
#include "refusal.h"
#include "row_name.h"
#include "small_recipe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace stratus::test {
namespace {

/// Finished pieces in memory; from `max_pieces` on it asks the work to stop.
struct MemoryLog {
    std::map<std::string, std::vector<char>> pieces;
    std::size_t max_pieces = 1000000;
    std::atomic<int> kept{0};
    std::mutex mutex;

    BakeOptions options(int threads) {
        BakeOptions options;
        options.threads = threads;
        options.log.find = [this](const std::string& piece) -> std::optional<std::vector<char>> {
            const std::lock_guard lock(mutex);
            const auto at = pieces.find(piece);
            if (at == pieces.end()) return std::nullopt;
            return at->second;
        };
        options.log.keep = [this](const std::string& piece, std::span<const char> result) {
            const std::lock_guard lock(mutex);
            const bool is_new = pieces.try_emplace(piece, result.begin(), result.end()).second;
            EXPECT_TRUE(is_new) << piece << " is done twice, or the name of two pieces";
            ++kept;
        };
        options.log.stop = [this] {
            const std::lock_guard lock(mutex);
            return pieces.size() >= max_pieces;
        };
        return options;
    }
};

/// Too few mu_samples for its tolerance: the first attempt misses, the second chooses anew.
Recipe recipe_of_attempts() {
    Recipe recipe = rayleigh_recipe();
    recipe.tolerance = 3e-2;
    recipe.discretisation.mu_samples = 6;
    return recipe;
}

Recipe recipe_over_ground() {
    Recipe recipe = explicit_recipe();
    recipe.lower_boundary = LowerBoundary::surface(0.3);
    recipe.transmission = false;
    recipe.discretisation.albedo_samples = 11;
    return recipe;
}

Recipe recipe_of_mixtures() {
    return parse_recipe(
        "phase_function = 'rayleigh'\n"
        "second_phase_function = 'isotropic'\n"
        "mixture = { min = 0.0, max = 1.0 }\n"
        "tolerance = 0.1\n"
        "optical_depth = { min = 0.5, max = inf }\n"
        "albedo = { min = 0.8, max = 0.9 }\n");
}

Recipe recipe_of_some_directions() {
    Recipe recipe = rayleigh_recipe();
    recipe.tolerance = 3e-2;
    recipe.mu_in = {0.4, 0.4};
    recipe.azimuth = {30, 60};
    return recipe;
}

struct Case {
    const char* name;
    Recipe (*recipe)();
};

class Resume : public testing::TestWithParam<Case> {};

TEST_P(Resume, GivesTheBitsOfAnUninterruptedBake) {
    const Recipe recipe = GetParam().recipe();
    MemoryLog undisturbed;
    const Table whole = bake(recipe, undisturbed.options(2));
    const std::size_t all = undisturbed.pieces.size();
    ASSERT_GT(all, 10U);

    MemoryLog log;
    int stops = 0;
    for (log.max_pieces = all / 3;; log.max_pieces += all / 3) {
        const int threads = stops % 3 + 1;
        log.kept = 0;
        const std::size_t before = log.pieces.size();
        try {
            const Table table = bake(recipe, log.options(threads));
            expect_same_bits(table, whole);
            ASSERT_EQ(table.family.size(), whole.family.size());
            for (const auto k : indices(whole.family))
                EXPECT_EQ(table.family[k].axis.values, whole.family[k].axis.values);
            EXPECT_EQ(table.attributes, whole.attributes);
            break;
        } catch (const WorkStopped&) {
            ++stops;
            // pieces at work are finished first
            EXPECT_GE(log.pieces.size(), log.max_pieces);
            EXPECT_LE(log.pieces.size(), log.max_pieces + static_cast<std::size_t>(threads));
            EXPECT_EQ(log.pieces.size(), before + static_cast<std::size_t>(log.kept));
        }
    }
    EXPECT_GE(stops, 2);
    EXPECT_EQ(log.pieces, undisturbed.pieces);
}

INSTANTIATE_TEST_SUITE_P(Recipes, Resume,
                         testing::Values(Case{"Attempts", recipe_of_attempts},
                                         Case{"OverGround", recipe_over_ground},
                                         Case{"Mixtures", recipe_of_mixtures},
                                         Case{"SomeDirections", recipe_of_some_directions}),
                         row_name);

TEST(ResumeRefusal, NamesAPieceOfTheWrongSize) {
    MemoryLog log;
    bake(explicit_recipe(), log.options(1));
    log.pieces["attempt 0, request 0, depths from 0, 3 octaves, albedos 0 1 2"].push_back('x');
    expect_refusal<std::runtime_error>([&] { bake(explicit_recipe(), log.options(1)); },
                                       "depths from 0, 3 octaves, albedos 0 1 2 must hold");
}

class InstructionSets : public testing::TestWithParam<InstructionSet> {};

TEST_P(InstructionSets, AgreeToRounding) {
    if (!is_available(GetParam())) GTEST_SKIP() << "this processor has none";
    Recipe recipe = explicit_recipe();
    recipe.tolerance = 1e-4;  // below which samples keep all bits of a float
    const Table widest = solve_table(recipe);
    const InstructionSetLimit limit(GetParam());
    const Table table = solve_table(recipe);
    for (const auto samples :
         {&Table::reflection_multiple, &Table::transmission_multiple, &Table::plane_albedo,
          &Table::diffuse_transmittance, &Table::spherical_albedo})
        expect_all_near(table.*samples, widest.*samples, 0,
                        1.2e-7 * std::ranges::max(widest.*samples));  // the last bit
    expect_all_near(table.diffusion_exponent, widest.diffusion_exponent, 0, 1e-12);
}

TEST_P(InstructionSets, AgreeOnChoices) {
    if (!is_available(GetParam())) GTEST_SKIP() << "this processor has none";
    const std::string chosen = resolved_text(resolve(rayleigh_recipe()));
    const InstructionSetLimit limit(GetParam());
    EXPECT_EQ(resolved_text(resolve(rayleigh_recipe())), chosen);
}

INSTANTIATE_TEST_SUITE_P(Named, InstructionSets, testing::ValuesIn(instruction_sets),
                         instruction_set_row);

}  // namespace
}  // namespace stratus::test
