// `stratus bake`: a recipe in, a table out.

#include <stratus/bake/forecast.h>
#include <stratus/bake/parallel.h>
#include <stratus/bake/sweep.h>
#include <stratus/base/argument.h>
#include <stratus/io/file_bytes.h>
#include <stratus/io/write_options.h>

#include "bake.h"
#include "options.h"
#include "progress.h"

#include <cstdlib>
#include <dlfcn.h>
#include <future>
#include <unistd.h>

namespace stratus {
namespace {

std::string checkpoint_path(const BakeCommand& command) { return command.output + ".checkpoint"; }

/// The checkpoint of an interrupted bake, or a new one.
std::unique_ptr<Checkpoint> open_checkpoint(const BakeCommand& command, const Recipe& recipe,
                                            Progress& progress) {
    const std::string path = checkpoint_path(command);
    auto checkpoint = std::make_unique<Checkpoint>(
        path, CheckpointOwner{baking_program(), resolved_text(recipe)});
    if (checkpoint->pieces() > 0 && !command.resume)
        throw std::runtime_error(path +
                                 ": is left from an interrupted bake; --resume continues it, "
                                 "removing the file starts over");
    if (checkpoint->pieces() > 0)
        progress.note("resuming from " + path + ": " + std::to_string(checkpoint->pieces()) +
                      " finished pieces of work");
    else if (command.resume)
        progress.note("note: no checkpoint to resume from: baking from the start");
    return checkpoint;
}

/// Bakes from the checkpoint, and adds to it.
Table bake_on(const Recipe& recipe, BakeOptions options, Checkpoint& checkpoint) {
    keep_in(checkpoint, options.log);
    bool told = false;
    options.progress = [&, show = options.progress](double done, const std::string& stage) {
        show(done, stage);
        const std::string trouble = checkpoint.trouble();
        if (!told && !trouble.empty())
            options.note("note: the checkpoint cannot be written: " + trouble);
        told = !trouble.empty();
    };
    return bake(recipe, options);
}

/// Bakes until a signal ends it.
///
/// Errors   EndedBySignal where one came.
Table bake_on_unless_stopped(const Recipe& recipe, BakeOptions options, Checkpoint& checkpoint,
                             const std::string& path) {
    const StopOnSignal stop;
    options.log.stop = [&] { return stop.signal() != 0; };
    try {
        return bake_on(recipe, options, checkpoint);
    } catch (const WorkStopped&) {
        throw EndedBySignal(stop.signal(),
                            "interrupted; " + (checkpoint.pieces() == 0 ? "no work was kept"
                                                                        : sentence_of_kept(path)));
    }
}

/// A stage as the ranks that deflate see it.
RankedStage deflating() {
    RankedStage stage;
    stage.solve = [](int, std::span<const char> given) { return deflate_part(given); };
    stage.claimed_ahead = 1;
    return stage;
}

/// Writes a .h5 as write_table does, on rank 0 while all others are in help_write; each rank deflates on so many
/// threads. Besides the table, rank 0 holds the parts that are deflated.
void write_on_ranks(const Table& table, const fs::path& path, Ranks& ranks, int threads,
                    const SampleFiles* samples) {
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

/// Writes all files of a table, compressed at the same time; with ranks, by all of them.
void write_files(const Table& table, const std::vector<char>& packed, const BakeCommand& command,
                 const SampleFiles* samples, Ranks* ranks) {
    std::future<void> picture;
    if (!command.exr.empty())
        picture = std::async([&] { write_table(table, command.exr, command.threads); });
    if (is_packed(command.output))
        write_content_atomically(command.output, packed);
    else if (ranks)
        write_on_ranks(table, command.output, *ranks, command.threads, samples);
    else
        write_table(table, command.output, WriteOptions{command.threads, {}, samples});
    if (!command.h5.empty()) write_table(table, command.h5, command.threads);
    if (picture.valid()) picture.get();
}

/// Returns the command's options, with progress and notes on standard error.
BakeOptions make_options(const BakeCommand& command, Progress& progress) {
    BakeOptions options;
    options.threads = command.threads;
    options.note = [&](const std::string& line) { progress.note("  " + line); };
    options.progress = std::ref(progress);
    return options;
}

/// Tells what a bake would choose, make and take.
void run_dry(const BakeCommand& command) {
    Forecast ahead;
    double tolerance = 0;
    {
        std::vector<std::string> notes;
        const Recipe recipe = read_recipe(command.recipe, &notes);
        tolerance = recipe.tolerance;
        Progress progress(command.quiet);
        progress.notes(notes);
        ahead = forecast(recipe, make_options(command, progress));
    }
    std::printf("%s\n%s\n", resolved_text(ahead.resolved).c_str(), sentence_of_cost(ahead).c_str());
    for (const Shortfall& axis : ahead.shortfalls) std::printf("%s\n", describe(axis).c_str());
    if (command.accept || !ahead.misses(tolerance)) return;
    throw std::runtime_error("bake: " + command.recipe +
                             ": the tolerance is out of reach (--accept: exit code 0)");
}

/// State that is shared with rank 0's threads; null when run without ranks.
struct RankZero {
    Ranks& ranks;
    std::atomic<const Checkpoint*>& checkpoint;
    std::atomic<bool>& is_writing;  // and not to be stopped
};

/// Tells what the ranks did.
void note_tallies(const std::vector<RankTally>& tallies, Progress& progress) {
    for (std::size_t rank = 0; rank < tallies.size(); ++rank) {
        progress.note(formatted("rank %zu: %d pieces, %.2f s of processor time", rank,
                                tallies[rank].pieces, tallies[rank].seconds));
    }
}

void bake_to_file(const BakeCommand& command, const RankZero* rank_zero) {
    require_writable("bake", "--output", command.output, {packed_ending, ".h5"});
    if (!command.exr.empty()) require_writable("bake", "--exr", command.exr, {".exr"});
    if (!command.h5.empty()) {
        require_writable("bake", "--h5", command.h5, {".h5"});
        require(is_packed(command.output), "bake", "--h5",
                "left out for an output that is itself .h5", command.h5);
    }
    require_different_files("bake", {command.recipe}, {command.output, command.exr, command.h5});
    std::vector<std::string> notes;
    const Recipe recipe = read_recipe(command.recipe, &notes);

    const auto started = Clock::now();
    Progress progress(command.quiet);
    progress.notes(notes);
    BakeOptions options = make_options(command, progress);
    std::string missed;
    options.missed = [&](const std::string& sentence) { missed = sentence; };
    std::optional<SampleFiles> samples(fs::path(command.output).parent_path());
    std::vector<char> packed;
    options.keeps_samples = command.keeps_samples();
    if (is_packed(command.output))
        options.packed = &packed;
    else if (!command.keeps_samples())  // pictures are made in memory
        options.samples = &*samples;
    const std::string kept_in = checkpoint_path(command);
    const std::unique_ptr<Checkpoint> checkpoint = open_checkpoint(command, recipe, progress);
    if (rank_zero) {
        rank_zero->checkpoint = checkpoint.get();
        options.log.ranks = &rank_zero->ranks;
    }
    const Table table = rank_zero ? bake_on(recipe, options, *checkpoint)
                                  : bake_on_unless_stopped(recipe, options, *checkpoint, kept_in);
    if (rank_zero) rank_zero->is_writing = true;
    const SignalsHeld held;
    try {
        write_files(table, packed, command, samples->has_room() ? &*samples : nullptr,
                    rank_zero ? &rank_zero->ranks : nullptr);
    } catch (const std::runtime_error& error) {
        if (checkpoint->pieces() == 0) throw;
        throw std::runtime_error(std::string(error.what()) + "; finished work is kept in " +
                                 kept_in + " for --resume");
    }
    // Freeing files of gigabytes takes the system seconds: both at the same time.
    const auto freeing = std::async([&] { samples.reset(); });
    checkpoint->remove();
    if (rank_zero) note_tallies(rank_zero->ranks.finish(), progress);

    progress.note(formatted(
        "%zu samples a side, %.1f MiB on disk, %.2f s; largest error at random points "
        "%.2g, asked for %.2g",
        table.sample_count(), static_cast<double>(fs::file_size(command.output)) / 1048576,
        seconds_since(started), table.measured_error, table.tolerance));
    if (missed.empty()) return;
    missed = "bake: " + command.output + ": " + missed;
    if (!command.accept) throw std::runtime_error(missed + " (--accept: exit code 0)");
    say(missed);
}

/// Solves the pieces that rank 0 hands out, until there are no more.
void help_bake(const BakeCommand& command, Ranks& ranks) {
    BakeOptions options;
    options.threads = command.threads;
    options.log.ranks = &ranks;
    std::vector<char> none;
    if (is_packed(command.output)) options.packed = &none;
    options.keeps_samples = command.keeps_samples();
    bake(read_recipe(command.recipe), options);
    if (!is_packed(command.output)) help_write(ranks, command.threads);
    ranks.finish();
}

/// Has every rank do its work; an error ends all of them.
template <class Work>
void on_ranks(std::unique_ptr<RankTransport> transport, const RanksOptions& options, Work work) {
    Ranks ranks(std::move(transport), options);
    const auto end_all = [&](int exit_code, const std::string& reason) {
        if (ranks.is_finished()) throw;
        ranks.end_all(exit_code, reason);
    };
    try {
        work(ranks);
    } catch (const std::invalid_argument& error) {
        end_all(2, error.what());
    } catch (const std::bad_alloc&) {
        end_all(1, ranks.is_first() ? "rank 0: out of memory" : "out of memory");
    } catch (const std::exception& error) {
        end_all(1, error.what());
    }
}

void bake_on_ranks(const BakeCommand& command, std::unique_ptr<RankTransport> transport) {
    const StopOnSignal stop;
    std::atomic<const Checkpoint*> checkpoint = nullptr;
    std::atomic<bool> is_writing = false;
    RanksOptions options;
    options.time_limit = command.rank_timeout;
    options.stop = [&] { return is_writing ? 0 : stop.signal(); };
    options.kept = [&]() -> std::string {
        const Checkpoint* const kept = checkpoint;
        return kept && kept->pieces() > 0 ? sentence_of_kept(checkpoint_path(command)) : "";
    };
    on_ranks(std::move(transport), options, [&](Ranks& ranks) {
        if (!ranks.is_first()) return help_bake(command, ranks);
        const RankZero zero{ranks, checkpoint, is_writing};
        bake_to_file(command, &zero);
    });
}

void sweep_on_ranks(const BakeCommand& command, std::unique_ptr<RankTransport> transport) {
    const StopOnSignal stop;
    RanksOptions options;
    options.time_limit = command.rank_timeout;
    options.stop = [&] { return stop.signal(); };
    options.kept = [&] { return sentence_of_kept(command.output); };
    on_ranks(std::move(transport), options, [&](Ranks& ranks) { run_sweep(command, &ranks); });
}

void run_bake(BakeCommand command) {
    if (command.dry_run) return run_dry(command);
    if (command.output_option->count() == 0) throw CLI::RequiredError("--output");
    auto transport = started_ranks();
    if (transport && command.threads == 0) command.threads = threads_of_rank(*transport);
    if (!command.sweep.empty() || has_sweep(command.recipe)) {
        require(!command.keeps_samples(), "bake", command.exr.empty() ? "--h5" : "--exr",
                "left out for a sweep", command.exr.empty() ? command.h5 : command.exr);
        if (!transport) return run_sweep(command);
        return sweep_on_ranks(command, std::move(transport));
    }
    if (transport) return bake_on_ranks(command, std::move(transport));
    bake_to_file(command, nullptr);
}

}  // namespace

void add_bake(CLI::App& app) {
    const auto [command, options] =
        add_command<BakeCommand>(app, "bake", "Bake a table from a recipe", run_bake);
    add_file(command, "RECIPE", options.recipe, "Recipe, .toml")->required();
    options.output_option = command.add_option(
        "-o,--output", options.output,
        "Table to write: .stratus, packed, which lookups and renderers read, or .h5 with all "
        "samples; folder of a sweep's tables; required to bake");
    command.add_flag(
        "--dry-run", options.dry_run,
        "Only choose the discretisation, and print it with the table's size, the time that solving "
        "and checking it will take, and every axis at its cap");
    add_file(command, "--exr", options.exr,
             "Also write all samples as a picture file, .exr, from the same solutions");
    add_file(command, "--h5", options.h5, "Also write all samples for other programs, .h5");
    add_file(command, "--sweep", options.sweep,
             "CSV: bakes a table a row, each column a key of the recipe (section.key), the "
             "column name naming the tables; a recipe's own [sweep] needs no option. A "
             "summary goes to standard output and to summary.csv. --resume bakes what the "
             "folder lacks or has damaged, as after a power cut: tables are flushed to "
             "disk together at the end")
        ->excludes("--dry-run", "--exr", "--h5");
    add_threads(command, options.threads);
    command.add_flag(
        "--resume", options.resume,
        "Resume an interrupted bake from OUTPUT.checkpoint, which is removed when the "
        "table is complete. The table is the same, byte for byte. Without a checkpoint, "
        "bake from the start");
    command.add_flag("--accept", options.accept,
                     "Exit code 0 even where the table misses its tolerance");
    command
        .add_option("--rank-timeout", options.rank_timeout,
                    "Started by mpirun or srun: seconds without a sign of life after which a rank "
                    "counts as lost, and the bake ends")
        ->capture_default_str()
        ->check(number("at least 1", [](double seconds) { return seconds >= 1; }));
    add_quiet(command, options.quiet);
    add_keys(command, "recipes", recipe_keys());
    command.footer(
        "Before the first solve, a note tells size and time, and a warning every axis at its cap: "
        "what it misses, how many samples would do and at what cost.\n"
        "Exit code 1 when the table misses its tolerance; it is written all the same, and the last "
        "line on standard error says by how much. With --dry-run, exit code 1 when an axis at its "
        "cap alone misses the tolerance.\n"
        "A stack file, with [[layers]], bakes the stack as one material: "
        "tables/stacks/haze_over_cloud.toml.\n"
        "A recipe with a second_phase_function bakes both in any mixture, of which lookups choose "
        "one.\n"
        "Example:\n  stratus bake tables/saturn_rings.toml -o saturn_rings.stratus\n"
        "  stratus bake tables/saturn_rings.toml -o rings.stratus --h5 rings.h5 --exr rings.exr\n"
        "  stratus bake tables/saturn_rings.toml --sweep sweep.csv -o rings");
}

namespace {

/// A number in the environment; 0 where there is none.
int environment_number(const char* variable) {
    const char* const text = std::getenv(variable);
    return text == nullptr ? 0 : std::max(0, std::atoi(text));
}

/// Ranks announced by mpirun (OpenMPI, or with a PMI) or by srun with a PMI of its own; 1: none.
int announced_count() {
    int count = 1;
    for (const char* variable : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
        count = std::max(count, environment_number(variable));
    if (std::getenv("PMIX_RANK") != nullptr)
        count = std::max(count, environment_number("SLURM_STEP_NUM_TASKS"));
    return count;
}

bool was_started_as_rank() {
    for (const char* variable : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"})
        if (std::getenv(variable) != nullptr) return true;
    return false;
}

/// The plugin lies beside the program, or where both are installed.
void* load_plugin() {
    constexpr const char* name = "libstratus_ranks.so";
    std::error_code ignored;
    const fs::path program = fs::read_symlink("/proc/self/exe", ignored).parent_path();
    for (const fs::path& folder : {program, program / STRATUS_PLUGINS_FROM_PROGRAM})
        if (fs::exists(folder / name, ignored)) {
            void* const plugin = ::dlopen((folder / name).c_str(), RTLD_NOW | RTLD_GLOBAL);
            if (plugin == nullptr) throw std::runtime_error(::dlerror());
            return plugin;
        }
    throw std::runtime_error(std::string(name) + " is missing: stratus was built without MPI");
}

}  // namespace

std::unique_ptr<RankTransport> started_ranks() {
    if (!was_started_as_rank()) return nullptr;
    const int announced = announced_count();
    try {
        const auto start = reinterpret_cast<StartRanks*>(::dlsym(load_plugin(), start_ranks_name));
        if (start == nullptr) throw std::runtime_error(::dlerror());
        std::unique_ptr<RankTransport> ranks(start());
        if (ranks->count() < announced)
            throw std::runtime_error("the library of MPI is not that of this mpirun or srun");
        return ranks;
    } catch (const std::exception& error) {
        if (announced == 1) return nullptr;
        throw std::runtime_error("started as one of " + std::to_string(announced) +
                                 " ranks, but: " + error.what());
    }
}

int threads_of_rank(const RankTransport& ranks) {
    const long all = ::sysconf(_SC_NPROCESSORS_ONLN);
    const long own = std::thread::hardware_concurrency();  // that it may run on
    return static_cast<int>(
        std::max(1L, std::min(own, all / std::max(1, ranks.count_on_this_machine()))));
}

}  // namespace stratus
