// How good a plan's estimates are: the change of pictures without the orders n >= 2, or without their
// azimuth, over the estimate of it, for random and for adversarial scenes. `plan_bench [COUNT [FIRST
// SEED [TOLERANCE]]]`, 50 of either kind from 1 on at a tolerance of 2e-3 unless told. A line for each
// change that exceeds its estimate, then how often that was and by how much.
#include "random_scene.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

using namespace stratus;

namespace {

void print_record(const char* kind, std::vector<double> ratios) {
    if (ratios.empty()) return;
    std::sort(ratios.begin(), ratios.end());
    const auto exceeded =
        std::count_if(ratios.begin(), ratios.end(), [](double r) { return r > 1; });
    const auto quantile = [&](double share) {
        return ratios[static_cast<std::size_t>(share * static_cast<double>(ratios.size() - 1))];
    };
    std::printf(
        "%-12s %4zu changes, exceeded %ld times; change over estimate: median %.2f, 90 %% "
        "%.2f, 99 %% %.2f, largest %.2f\n",
        kind, ratios.size(), static_cast<long>(exceeded), quantile(0.5), quantile(0.9),
        quantile(0.99), ratios.back());
}

}  // namespace

int main(int argc, char** argv) {
    const int count = argc > 1 ? std::atoi(argv[1]) : 50;
    const auto first = static_cast<unsigned>(argc > 2 ? std::atoi(argv[2]) : 1);
    const double tolerance = argc > 3 ? std::atof(argv[3]) : 2e-3;
    for (const bool adversarial : {false, true}) {
        std::vector<double> ratios;
        for (unsigned seed = first; seed < first + static_cast<unsigned>(count); ++seed) {
            test::RandomScenes scenes(seed);
            Scene scene = adversarial ? scenes.adversarial() : scenes.next();
            scene.tolerance = tolerance;
            for (const auto& [effect, estimate, found, where] : test::changes_of(scene)) {
                // Smaller changes are lost in the tables' own errors.
                if (found < 2 * tolerance) continue;
                ratios.push_back(found / estimate);
                if (found > estimate)
                    std::printf("%s %u: without %s %.3g, estimated %.3g (%s; %s)\n",
                                adversarial ? "adversarial" : "random", seed, effect, found,
                                estimate, where.c_str(), scene.layer.components[0].text().c_str());
            }
            std::fflush(stdout);
        }
        print_record(adversarial ? "adversarial" : "random", ratios);
    }
}
