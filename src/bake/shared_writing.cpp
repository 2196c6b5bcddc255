#include <stratus/bake/shared_writing.h>

#include <stratus/io/table_file.h>
#include <stratus/io/write_options.h>

namespace stratus {
namespace {

/// A stage as the ranks that deflate see it.
RankedStage deflating() {
    RankedStage stage;
    stage.solve = [](int, std::span<const char> given) { return deflate_part(given); };
    stage.claimed_ahead = 1;
    return stage;
}

}  // namespace

void write_on_ranks(const Table& table, const std::filesystem::path& path, Ranks& ranks,
                    int threads, const SampleFiles* samples) {
    WriteOptions options;
    options.samples = samples;
    options.share = [&](const PartsToDeflate& parts) {
        ranks.share({1});  // there is a side to write
        RankedStage stage = deflating();
        stage.count = parts.count;
        stage.most_ahead = 2 * ranks.count() * threads;
        stage.give = parts.give;
        stage.take = parts.take;
        stage.is_done = [](int) { return false; };
        stage.progress = [](int) {};
        ranks.run(stage, threads);
    };
    write_table(table, path, options);
    ranks.share({});
}

void help_write(Ranks& ranks, int threads) {
    while (!ranks.share({}).empty()) ranks.run(deflating(), threads);
}

}  // namespace stratus
