// How good a plan's estimates are: the change of pictures without the orders n >= 2, or without their
// azimuth, or without the shell that a layer is, over the estimate of it, for random and for adversarial
// scenes, for stacks and for shells. `plan_bench [KIND] [COUNT [FIRST SEED [TOLERANCE]]]`, 50 of each kind
// (random, adversarial, stack, shell), or of one, from 1 on at a tolerance of 2e-3 unless told. A
// line for each change that exceeds its estimate, then how often that was and by how much. `plan_bench
// forecast [COUNT [FIRST SEED]]`: processor seconds of random pictures over their forecasts.
#include <stratus/bake/parallel.h>

#include "plan_scenes.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <utility>
#include <vector>

using namespace stratus;

namespace {

/// Ascending ratios: how many are above 1, and quantiles.
void print_record(const char* kind, std::vector<double> ratios) {
    if (ratios.empty()) return;
    std::sort(ratios.begin(), ratios.end());
    const auto above = std::count_if(ratios.begin(), ratios.end(), [](double r) { return r > 1; });
    const auto quantile = [&](double share) {
        return ratios[static_cast<std::size_t>(share * static_cast<double>(ratios.size() - 1))];
    };
    std::printf(
        "%-12s %4zu, of which %ld above 1: least %.2f, 10 %% %.2f, median %.2f, 90 %% %.2f, "
        "99 %% %.2f, largest %.2f\n",
        kind, ratios.size(), static_cast<long>(above), ratios.front(), quantile(0.1), quantile(0.5),
        quantile(0.9), quantile(0.99), ratios.back());
}

int compare_forecasts(int count, unsigned first) {
    std::vector<double> ratios;
    for (unsigned seed = first; seed < first + static_cast<unsigned>(count); ++seed) {
        test::RandomScenes scenes(seed);
        Scene scene = scenes.next();
        scene.width *= 10;
        scene.height *= 10;
        scene.tolerance = 2e-3;
        scene.effects = plan_scene(scene).effects;
        test::picture(scene);  // what a process does but once is in neither
        const RenderCost cost = report_plans({scene}).cost;
        const double forecast = cost.seconds();
        const double started = processor_seconds();
        test::picture(scene);
        ratios.push_back((processor_seconds() - started) / forecast);
        std::printf(
            "%4u  %.3f s, forecast %.3f s: choosing %.3f, solving %.3f, checking %.3f, packing "
            "%.3f, light %.3f, rays %.3f\n",
            seed, ratios.back() * forecast, forecast, cost.tables.choose_seconds,
            cost.tables.solve_seconds, cost.tables.check_seconds, cost.tables.pack_seconds,
            cost.light_seconds, cost.ray_seconds);
    }
    print_record("forecasts", ratios);
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc > 1 && std::string_view(argv[1]) == "forecast")
        return compare_forecasts(argc > 2 ? std::atoi(argv[2]) : 50,
                                 static_cast<unsigned>(argc > 3 ? std::atoi(argv[3]) : 1));
    const std::string_view only = argc > 1 && std::isalpha(argv[1][0]) ? argv[1] : "";
    if (!only.empty()) {
        --argc;
        ++argv;
    }
    const int count = argc > 1 ? std::atoi(argv[1]) : 50;
    const auto first = static_cast<unsigned>(argc > 2 ? std::atoi(argv[2]) : 1);
    const double tolerance = argc > 3 ? std::atof(argv[3]) : 2e-3;
    const std::pair<const char*, Scene (test::RandomScenes::*)()> kinds[] = {
        {"random", &test::RandomScenes::next},
        {"adversarial", &test::RandomScenes::adversarial},
        {"stack", &test::RandomScenes::stack},
        {"shell", &test::RandomScenes::shell}};
    for (const auto& [kind, draw] : kinds) {
        if (!only.empty() && only != kind) continue;
        std::vector<double> ratios;
        for (unsigned seed = first; seed < first + static_cast<unsigned>(count); ++seed) {
            test::RandomScenes scenes(seed);
            Scene scene = (scenes.*draw)();
            scene.tolerance = tolerance;
            for (const auto& [effect, estimate, found, where] : test::changes_of(scene)) {
                // Smaller changes are lost in the tables' own errors.
                if (found < 2 * tolerance) continue;
                ratios.push_back(found / estimate);
                if (found > estimate)
                    std::printf("%s %u: without %s %.3g, estimated %.3g (%s; %s)\n", kind, seed,
                                effect, found, estimate, where.c_str(),
                                scene.layer.components[0].text().c_str());
            }
            std::fflush(stdout);
        }
        print_record(kind, ratios);
    }
}
