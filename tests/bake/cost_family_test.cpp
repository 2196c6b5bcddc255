// What accuracy costs along the axes of a family: cost.h, of recipes with [family].
#include <stratus/bake/cost.h>

#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>

#include "cost_study.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace stratus {
namespace {

using Kind = CostPoint::Kind;

// Directions are sampled so finely that the family alone leaves an error.
const std::string lobe_family =
    "[family]\ng = [0.0, 0.7]\n[discretisation]\nmu_samples = 40\nazimuth_samples = 30\n";
constexpr auto of_g = static_cast<std::size_t>(PhaseParameter::g);

const CostStudy& study_of_lobes() {
    static const CostStudy study = study_of(lobe_family, "henyey_greenstein:g=0.5");
    return study;
}

TEST(CostOfFamily, VariesTheMembersOfAFamily) {
    const CostStudy& study = study_of_lobes();
    const std::vector<CostPoint> along = points_along(study.points, PhaseParameter::g);
    ASSERT_GE(along.size(), 5u);
    for (std::size_t n = 0; n < along.size(); ++n) {
        EXPECT_EQ(along[n].discretisation.family_samples[0], along[n].members[of_g]);
        EXPECT_GT(along[n].lookup_ns, 0);
        if (n == 0) continue;
        EXPECT_GT(along[n].members[of_g], along[n - 1].members[of_g]);
        EXPECT_EQ(along[n].bytes * along[0].members[of_g], along[0].bytes * along[n].members[of_g]);
    }
    EXPECT_EQ(along.front().members[of_g], 2);
    EXPECT_GT(along.front().error_99_9, 4 * along.back().error_99_9);
    int chosen = 0;
    for (const CostPoint& point : study.points) {
        if (point.tolerance != 0.1) continue;
        ++chosen;
        EXPECT_LE(point.error_99_9, 0.1);
        EXPECT_EQ(point.members[of_g] >= 2, point.kind != Kind::solver);
    }
    EXPECT_EQ(chosen, 3) << "a solver, a table and that packed";
    EXPECT_TRUE(points_along(study.points, PhaseParameter::radius).empty());
}

// What the study says of a sampling, against layers of members solved one by one.
TEST(CostOfFamily, ErrorsAlongAFamilyAreThoseOfItsMembers) {
    const CostPoint coarse = points_along(study_of_lobes().points, PhaseParameter::g).front();
    Recipe resolved = cost_recipe(lobe_family, "henyey_greenstein:g=0.5");
    resolved.discretisation = coarse.discretisation;
    const Table table = solve_table(resolved);
    SolverOptions solver;
    solver.nodes = 48;
    std::vector<double> mu = floor_cosines(), errors;
    mu.insert(mu.end(), {0.05, 0.2, 0.45, 0.8});
    for (int n = 0; n < 40; ++n) {  // evenly along the axis, as points are drawn
        const double g = 1 - std::pow(0.3, (n + 0.5) / 40);
        const LayerSolution solution =
            solve_layer(PhaseFunction::henyey_greenstein(g), 0.9, 1, mu, solver);
        const TableView view = table.view().at({g});
        for (int i = 0; i < solution.mu.size(); ++i)
            for (int j = 0; j < solution.mu.size(); ++j)
                for (const double azimuth : {0.4, 1.3, 2.6}) {
                    const Geometry at{mu[static_cast<std::size_t>(i)],
                                      mu[static_cast<std::size_t>(j)], azimuth};
                    const double expected = solution.reflection(i, j, azimuth).total;
                    errors.push_back(std::abs(reflection(view, 0.9, 1, at).total() - expected) /
                                     std::max(expected, reflection_floor(solution)));
                }
    }
    // other directions of the same layers
    EXPECT_NEAR(error_quantile(errors, 0.5) / coarse.error_median, 1, 0.4);
    EXPECT_NEAR(error_quantile(errors, 0.999) / coarse.error_99_9, 1, 0.5);
}

TEST(CostOfFamily, TellsHowErrorsFallAlongAnAxis) {
    const std::vector<GrowthLaw>& growth = study_of_lobes().growth;
    const auto law = std::ranges::find(growth, std::string("members along g"), &GrowthLaw::of);
    ASSERT_NE(law, growth.end());
    EXPECT_EQ(law->what, "error of a table");
    EXPECT_LT(law->law.exponent, -2);  // lines, parabolas, then cubics, whose errors fall as n^-4
    EXPECT_GE(law->law.points, 3u);
}

TEST(CostOfFamily, SweepsMixturesAndDroplets) {
    const CostStudy mixed = study_of("second_phase_function = 'rayleigh'\n", "isotropic");
    EXPECT_GE(points_along(mixed.points, PhaseParameter::mixture).size(), 5u);
    const CostStudy droplets = study_of(
        "[family]\nradius = ['0.1um', '0.2um']\nwavelength = { values = ['450nm', '650nm'] }\n",
        "mie:radius=0.2um,wavelength=0.55um,variance=0.1");
    const std::vector<CostPoint> along = points_along(droplets.points, PhaseParameter::radius);
    EXPECT_GE(along.size(), 5u);
    for (const CostPoint& point : along)
        EXPECT_EQ(point.members[static_cast<std::size_t>(PhaseParameter::wavelength)], 2);
    EXPECT_TRUE(points_along(droplets.points, PhaseParameter::wavelength).empty())
        << "its values are given";
}

}  // namespace
}  // namespace stratus
