// Whether pictures keep their tolerance: those by the plan and its tables, against those with all
// effects and tables that are ten times finer along every light path.
// `picture_bench [COUNT [FIRST SEED]]`, 20 random scenes from 1 on unless told, `picture_bench any
// [COUNT [FIRST SEED]]` of any kind (RandomScene::of_any_kind), or `picture_bench SCENE.toml...`, each
// at a width of 128 with one sample a pixel. A line each: seed or panel, the largest difference of a
// pixel over the tolerance (relative to its own light, or to 1 % of the brightest), the share of lit
// pixels beyond the tolerance, and the processor time of both.
#include <stratus/bake/parallel.h>
#include <stratus/scene/plan.h>
#include <stratus/scene/render.h>

#include "random_scene.h"

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

using namespace stratus;

namespace {

constexpr double finer = 10;

struct Tally {
    int pictures = 0, missed = 0;
    double worst = 0;
};

Image picture_in(const Scene& scene, const std::shared_ptr<const LayerTables>& tables) {
    return render(scene, LayerLight(scene, tables.get()));
}

void compare(const Scene& scene, const std::string& name, Tally& tally) {
    const double started = processor_seconds();
    Scene planned = scene;
    planned.effects = plan_scene(scene).effects;
    const Image found = picture_in(planned, bake_for({planned})[0]);
    const double middle = processor_seconds();
    const Image expected = picture_in(scene, bake_finer(scene, finer)[0]);
    const PictureDifference difference = difference_between(expected, found, scene.tolerance);
    const double share =
        difference.lit > 0 ? static_cast<double>(difference.exceeding) / difference.lit : 0;
    ++tally.pictures;
    tally.missed += difference.exceeding > 0;
    tally.worst = std::max(tally.worst, difference.most / scene.tolerance);
    const char* const subjects[] = {"planet", "rings", "slab"};
    std::printf("%-24s %-6s  %5.2f at (%d, %d)  %5.2f %%  %7.2f s %7.2f s\n", name.c_str(),
                subjects[scene.subject.index()], difference.most / scene.tolerance, difference.x,
                difference.y, 100 * share, middle - started, processor_seconds() - middle);
    std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
    Tally tally;
    const bool any_kind = argc > 1 && std::string(argv[1]) == "any";
    if (any_kind) --argc, ++argv;
    if (argc > 1 && std::atoi(argv[1]) == 0) {
        for (int k = 1; k < argc; ++k) {
            const std::vector<SceneFile> film = read_film(argv[k]);
            for (Scene panel : film[0].panels) {
                panel.height = std::max(1, panel.height * 128 / panel.width);
                panel.width = 128;
                panel.samples = 1;
                compare(panel, panel.title.substr(0, 24), tally);
            }
        }
    } else {
        const int count = argc > 1 ? std::atoi(argv[1]) : 20;
        const auto first = static_cast<unsigned>(argc > 2 ? std::atoi(argv[2]) : 1);
        for (unsigned seed = first; seed < first + static_cast<unsigned>(count); ++seed) {
            RandomScene random(seed);
            compare(any_kind ? random.of_any_kind() : random.scene(), std::to_string(seed), tally);
        }
    }
    std::printf("%d of %d pictures within their tolerance, the worst at %.2f times it\n",
                tally.pictures - tally.missed, tally.pictures, tally.worst);
}
