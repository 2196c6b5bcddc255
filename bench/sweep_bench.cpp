// Where the time of a sweep of small tables goes: parsing, choosing, solving, checking and writing,
// row by row on one thread. `sweep_bench [RECIPE.toml SWEEP.csv]`; without them 20 tables of hazes.
#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>
#include <stratus/bake/clock.h>
#include <stratus/bake/sweep.h>
#include <stratus/io/table_file.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>
#include <utility>
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
    Stage parsing{"parsing"}, choosing{"choosing"}, solving{"solving"}, checking{"checking"},
        writing{"writing"}, whole{"as a bake"};
    const std::vector<SweepRow> rows = parsing.time([&] { return read_sweep(recipe, sweep); });
    BakeOptions options;
    options.threads = 1;
    for (const SweepRow& row : rows) {
        const Recipe resolved = choosing.time([&] { return resolve(row.recipe, options); });
        Table table = solving.time([&] { return solve_table(resolved, options); });
        table.tolerance = row.recipe.tolerance;
        table.attributes["nodes"] = std::to_string(resolved.discretisation.nodes);
        VerifyOptions check;
        check.threads = 1;
        check.fluxes = false;
        checking.time([&] { return verify(table, check).samples.size(); });
        writing.time([&] {
            write_table(table, folder / (row.name + ".h5"));
            return 0;
        });
        whole.time([&] { return bake(row.recipe, options).tolerance; });
    }
    for (const Stage& stage : {parsing, choosing, solving, checking, writing, whole})
        std::printf("%-10s %8.3f s, %7.2f ms a row\n", stage.name, stage.seconds,
                    1e3 * stage.seconds / static_cast<double>(rows.size()));
    std::filesystem::remove_all(folder);
}
