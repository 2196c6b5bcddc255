// Whether recipes that nobody chose meet their tolerance: bakes of random ones straight into packed
// tables, verified at 400 points of their own. `random_recipe_bench [COUNT [FIRST SEED]]`, 20 from 1 on
// unless told. A line each: seed, largest error and that of 99.9 % as shares of the tolerance, bytes
// of the file and of all samples, processor time, phase function.
#include <stratus/bake/parallel.h>

#include "random_recipe.h"

#include <cstdio>
#include <cstdlib>

using namespace stratus;

int main(int argc, char** argv) {
    const int count = argc > 1 ? std::atoi(argv[1]) : 20;
    const auto first = static_cast<unsigned>(argc > 2 ? std::atoi(argv[2]) : 1);
    int met = 0;
    for (unsigned seed = first; seed < first + static_cast<unsigned>(count); ++seed) {
        const Recipe recipe = parse_recipe(test::RandomRecipe(seed).text());
        const double started = processor_seconds();
        test::PackedBake baked(recipe, 400);
        const double sides = (recipe.reflection ? 1 : 0) + (recipe.transmission ? 1 : 0);
        met += baked.meets() ? 1 : 0;
        std::printf("%4u  %s  largest %.2f  99.9 %% %.2f  %9zu of %10.0f bytes  %6.2f s  %s\n",
                    seed, baked.meets() ? "met   " : "MISSED",
                    baked.verification.samples.back().error / recipe.tolerance,
                    error_quantile(baked.verification.samples, 0.999) / recipe.tolerance,
                    baked.file.size(), 4 * sides * static_cast<double>(baked.header.sample_count()),
                    processor_seconds() - started, recipe.phase_text.c_str());
        std::fflush(stdout);
    }
    std::printf("%d of %d met their tolerance\n", met, count);
}
