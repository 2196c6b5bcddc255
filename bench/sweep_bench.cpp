// Where the time of a sweep of small tables goes: parsing, choosing, solving all samples, and all of a
// bake, which also packs and checks, row by row on one thread. `sweep_bench [RECIPE.toml SWEEP.csv]`;
// without them 20 tables of hazes.
#include <stratus/bake/bake.h>
#include <stratus/bake/parallel.h>
#include <stratus/bake/sweep.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>
#include <vector>

using namespace stratus;

namespace {

struct Stage {
    const char* name;
    double seconds = 0;

    template <class Work>
    auto time(const Work& work) {
        const double started = processor_seconds();
        auto result = work();
        seconds += processor_seconds() - started;
        return result;
    }
};

void write_hazes(const std::filesystem::path& recipe, const std::filesystem::path& sweep) {
    std::ofstream(recipe) << "phase_function = 'isotropic'\n"
                             "tolerance = 1e-2\n"
                             "optical_depth = { min = 0.25, max = 2.0 }\n"
                             "albedo = { min = 0.5, max = 1.0 }\n";
    std::ofstream rows(sweep);
    rows << "phase_function\n";
    for (int row = 0; row < 20; ++row) rows << "henyey_greenstein:g=" << 0.03 * row << '\n';
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 1 && argc != 3) {
        std::fprintf(stderr, "usage: sweep_bench [RECIPE.toml SWEEP.csv]\n");
        return 2;
    }
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("sweep_bench_" + std::to_string(getpid()));
    std::filesystem::create_directory(folder);
    std::filesystem::path recipe = folder / "recipe.toml", sweep = folder / "sweep.csv";
    if (argc == 3) {
        recipe = argv[1];
        sweep = argv[2];
    } else {
        write_hazes(recipe, sweep);
    }
    Stage parsing{"parsing"}, choosing{"choosing"}, solving{"solving"}, whole{"as a bake"};
    const std::vector<SweepRow> rows = parsing.time([&] { return read_sweep(recipe, sweep); });
    BakeOptions options;
    options.threads = 1;
    for (const SweepRow& row : rows) {
        const Recipe resolved = choosing.time([&] { return resolve(row.recipe, options); });
        solving.time([&] { return solve_table(resolved, options).sample_count(); });
        std::vector<char> packed;
        BakeOptions straight = options;
        straight.packed = &packed;
        whole.time([&] { return bake(row.recipe, straight).tolerance; });
    }
    for (const Stage& stage : {parsing, choosing, solving, whole})
        std::printf("%-10s %8.3f s, %7.2f ms a row\n", stage.name, stage.seconds,
                    1e3 * stage.seconds / static_cast<double>(rows.size()));
    std::filesystem::remove_all(folder);
}
