// Where the time of a sweep of small tables goes: parsing, choosing, solving, checking and writing,
// row by row on one thread, then the sweep as `stratus bake --sweep` runs it.
#include <stratus/bake/accuracy.h>
#include <stratus/bake/bake.h>
#include <stratus/bake/sweep.h>
#include <stratus/io/table_file.h>

#include <cstdio>
#include <ctime>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

using namespace stratus;

namespace {

/// Of the processor, so that other programs do not count.
double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

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

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: sweep_bench RECIPE.toml SWEEP.csv FOLDER\n");
        return 2;
    }
    const std::filesystem::path folder = argv[3];
    std::filesystem::create_directory(folder);
    Stage parsing{"parsing"}, choosing{"choosing"}, solving{"solving"}, checking{"checking"},
        writing{"writing"}, whole{"as a bake"};
    const std::vector<SweepRow> rows = parsing.time([&] { return read_sweep(argv[1], argv[2]); });
    BakeOptions options;
    options.threads = 1;
    for (const SweepRow& row : rows) {
        const Recipe resolved = choosing.time([&] { return resolve(row.recipe, options); });
        Table table = solving.time([&] { return solve_table(resolved, options); });
        table.tolerance = row.recipe.tolerance;
        table.attributes["nodes"] = std::to_string(resolved.discretisation.nodes);
        VerifyOptions check;
        check.threads = 1;
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
}
