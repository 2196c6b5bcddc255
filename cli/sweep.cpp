#include <stratus/bake/parallel.h>
#include <stratus/bake/sweep.h>
#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/io/file_bytes.h>
#include <stratus/table/packed_table.h>

#include "bake.h"
#include "progress.h"
#include "query.h"

#include <cstring>
#include <iostream>
#include <map>
#include <mutex>

namespace stratus {
namespace {

/// How the table of a row came out.
struct OutcomeNumbers {
    bool met = false, failed = false;
    double worst = 0, bytes = 0;
    double seconds = 0;  // 0: it was there already
};
struct Outcome : OutcomeNumbers {
    std::string remark;
};

/// Rows that are alike, in the order of the first: it is baked, the others are copies.
using Alike = std::vector<std::vector<std::size_t>>;

Alike find_alike(const std::vector<SweepRow>& rows) {
    std::map<std::string, std::size_t> place;
    Alike alike;
    for (std::size_t row = 0; row < rows.size(); ++row) {
        const auto [found, is_new] = place.try_emplace(rows[row].recipe.text, alike.size());
        if (is_new) alike.emplace_back();
        alike[found->second].push_back(row);
    }
    return alike;
}

// ---- One table

/// With a checkpoint it stops on signals.
Outcome bake_row(const SweepRow& row, int threads, std::vector<char>& packed,
                 Checkpoint* checkpoint = nullptr) {
    const auto started = Clock::now();
    Outcome outcome;
    outcome.met = true;
    BakeOptions options;
    options.threads = threads;
    options.packed = &packed;
    options.missed = [&](const std::string& sentence) {
        outcome.met = false;
        outcome.remark = sentence;
    };
    if (checkpoint) {
        keep_in(*checkpoint, options.log);
        options.log.stop = [] { return StopOnSignal::signal() != 0; };
    }
    outcome.worst = bake(row.recipe, options).measured_error;
    outcome.seconds = seconds_since(started);
    outcome.bytes = static_cast<double>(packed.size());
    return outcome;
}

/// Where tables go, and what all of them share.
class SweepFolder {
  public:
    SweepFolder(fs::path folder, bool resume) : folder_(std::move(folder)), resume_(resume) {
        std::error_code there_already;
        fs::create_directory(folder_, there_already);
        require_writable("bake", "--output", folder_ / "summary.csv");
    }

    fs::path table(const SweepRow& row) const { return folder_ / (row.name + packed_ending); }
    fs::path checkpoint(const SweepRow& row) const { return table(row).string() + ".checkpoint"; }
    fs::path summary() const { return folder_ / "summary.csv"; }

    /// The table that a sweep which goes on finds baked already.
    std::optional<Outcome> found(const SweepRow& row) const {
        const std::optional<Table> table = resume_ ? find(row) : std::nullopt;
        if (!table) return std::nullopt;
        fs::remove(checkpoint(row));
        return Outcome{{.met = states_tolerance_met(*table),
                        .worst = table->measured_error,
                        .bytes = static_cast<double>(fs::file_size(this->table(row)))},
                       "was there"};
    }

    /// Bakes a row's table, from its checkpoint if there is one, or finds it baked already.
    ///
    /// Errors   WorkStopped where a signal came.
    /// Threads  any number, of different rows.
    Outcome finish(const SweepRow& row, int threads) const {
        if (const std::optional<Outcome> there = found(row)) return *there;
        Checkpoint checkpoint(this->checkpoint(row), {baking_program(), resolved_text(row.recipe)});
        std::vector<char> packed;
        const Outcome outcome = bake_row(row, threads, packed, &checkpoint);
        write(row, {packed.data(), packed.size()});
        return outcome;
    }

    /// Writes a row's table and removes the checkpoint of an earlier sweep.
    void write(const SweepRow& row, std::string_view packed) const {
        write_content_atomically(table(row), packed, Flush::later);
        fs::remove(checkpoint(row));
    }

    /// Copies a table to another row's name.
    void copy(const SweepRow& from, const SweepRow& to) const {
        const auto copy_to = [&](const fs::path& temporary) {
            fs::copy_file(table(from), temporary, fs::copy_options::overwrite_existing);
        };
        write_atomically(table(to), copy_to, Flush::later);
    }

  private:
    /// The header of a row's table, if that is there whole.
    std::optional<Table> find(const SweepRow& row) const {
        if (!fs::exists(table(row))) return std::nullopt;
        try {
            const PackedTable found(table(row).string());
            if (found.is_intact() && is_baked_from(found.header(), row.recipe))
                return found.header();
        } catch (const std::exception&) {  // damaged, or of something else
        }
        return std::nullopt;
    }

    const fs::path folder_;
    const bool resume_;
};

/// Returns finish(); whatever goes wrong with one table but a signal leaves the others alone.
template <class Finish>
Outcome try_to_finish(const Finish& finish) {
    Outcome outcome;
    try {
        return finish();
    } catch (const WorkStopped&) {
        throw;
    } catch (const std::bad_alloc&) {
        outcome.remark = "out of memory";
    } catch (const std::exception& error) {
        outcome.remark = error.what();
    }
    outcome.failed = true;
    return outcome;
}

// ---- What ranks send to rank 0

/// An outcome's numbers, its remark, a zero and its table.
std::vector<char> to_message(const Outcome& outcome, const std::vector<char>& packed) {
    const OutcomeNumbers& numbers = outcome;
    std::string message(reinterpret_cast<const char*>(&numbers), sizeof numbers);
    message += outcome.remark + '\0';
    message.append(packed.data(), packed.size());
    return {message.begin(), message.end()};
}

/// The outcome, and the table's bytes.
std::pair<Outcome, std::string_view> read_outcome(std::span<const char> message) {
    OutcomeNumbers numbers;
    std::memcpy(&numbers, message.data(), sizeof numbers);
    const Outcome outcome{numbers, message.data() + sizeof numbers};
    return {outcome, std::string_view(message.data(), message.size())
                         .substr(sizeof numbers + outcome.remark.size() + 1)};
}

// ---- All of them

/// The first of alike rows, baked for rank 0.
RankedStage row_stage(const std::vector<SweepRow>& rows, const Alike& alike, int threads) {
    RankedStage stage;
    stage.count = int_size(alike);
    stage.solve = [&, threads](int piece, std::span<const char>) {
        std::vector<char> packed;
        const Outcome outcome = try_to_finish(
            [&] { return bake_row(rows[alike[size(piece)].front()], threads, packed); });
        return to_message(outcome, packed);
    };
    return stage;
}

/// Bakes all rows; what has come out of each.
std::vector<Outcome> bake_rows(const std::vector<SweepRow>& rows, const SweepFolder& folder,
                               const BakeCommand& command, Progress& progress, Ranks* ranks) {
    const Alike alike = find_alike(rows);
    std::vector<Outcome> outcomes(rows.size());
    std::mutex telling;
    std::size_t finished = 0;
    const auto told = [&](std::size_t row) {
        const std::lock_guard one_at_a_time(telling);
        ++finished;
        const Outcome& outcome = outcomes[row];
        if (outcome.failed || !outcome.met) progress.note(rows[row].name + ": " + outcome.remark);
        progress(static_cast<double>(finished) / static_cast<double>(rows.size()), "tables");
    };
    const auto finish_alike = [&](int n, const auto& finish) {
        const std::vector<std::size_t>& same = alike[size(n)];
        const std::size_t first = same.front();
        outcomes[first] = try_to_finish([&] { return finish(rows[first]); });
        told(first);
        for (std::size_t s = 1; s < same.size(); ++s) {
            outcomes[same[s]] = try_to_finish([&] {
                Outcome copied = outcomes[first];
                if (!copied.failed) folder.copy(rows[first], rows[same[s]]);
                copied.seconds = 0;
                if (copied.met) copied.remark = "the same as " + rows[first].name;
                return copied;
            });
            told(same[s]);
        }
    };
    if (!ranks) {
        nested_parallel_for(int_size(alike), command.threads, [&](int n) {
            finish_alike(n,
                         [&](const SweepRow& row) { return folder.finish(row, command.threads); });
        });
        return outcomes;
    }
    RankedStage stage = row_stage(rows, alike, command.threads);
    stage.is_done = [&](int piece) {
        const auto there = folder.found(rows[alike[size(piece)].front()]);
        if (there) finish_alike(piece, [&](const SweepRow&) { return *there; });
        return there.has_value();
    };
    stage.take = [&](int piece, std::span<const char> message) {
        finish_alike(piece, [&](const SweepRow& row) {
            const auto received = read_outcome(message);
            if (!received.first.failed) folder.write(row, received.second);
            return received.first;
        });
    };
    stage.progress = [](int) {};  // told by rows
    ranks->run(stage, command.threads);
    return outcomes;
}

std::string quoted(const std::string& text) {
    if (text.find_first_of(",\"") == text.npos) return text;
    std::string inside;
    for (const char letter : text) inside += letter == '"' ? "\"\"" : std::string(1, letter);
    return '"' + inside + '"';
}

void write_summary(std::ostream& out, const std::vector<SweepRow>& rows,
                   const std::vector<Outcome>& outcomes) {
    out << "name,asked,met,worst,seconds,bytes,remark\n";
    for (std::size_t r = 0; r < rows.size(); ++r) {
        const Outcome& outcome = outcomes[r];
        const auto number = [&](double value, int digits) {
            return value > 0 ? short_number(value, digits) : "";
        };
        out << quoted(rows[r].name) << ',' << short_number(rows[r].recipe.tolerance, 6) << ','
            << (outcome.failed ? "failed"
                : outcome.met  ? "yes"
                               : "no")
            << ',' << number(outcome.worst, 3) << ',' << number(outcome.seconds, 3) << ','
            << number(outcome.bytes, 15) << ',' << quoted(outcome.remark) << '\n';
    }
}

/// Throws where a table failed, or missed its tolerance.
void judge(const std::vector<Outcome>& outcomes, const BakeCommand& command) {
    const auto failed = std::ranges::count_if(outcomes, &Outcome::failed);
    const auto missed = std::ranges::count_if(
        outcomes, [](const Outcome& outcome) { return !outcome.failed && !outcome.met; });
    const std::string tables = " of " + std::to_string(outcomes.size()) + " tables ";
    std::vector<std::string> sentences;
    if (failed > 0) sentences.push_back(std::to_string(failed) + tables + "failed");
    if (missed > 0)
        sentences.push_back(std::to_string(missed) + tables + "miss their tolerance" +
                            (command.accept ? "" : " (--accept: exit code 0)"));
    if (sentences.empty()) return;
    const std::string line = "bake: " + command.output + ": " + joined(sentences, "; ");
    if (failed > 0 || !command.accept) throw std::runtime_error(line);
    say(line);
}

/// Flushes all tables to disk. Each would have waited for the disk by itself; a power cut before
/// this may damage them, which --resume finds by their checksums.
void flush(const std::vector<SweepRow>& rows, const std::vector<Outcome>& outcomes,
           const SweepFolder& folder) {
    std::vector<fs::path> tables;
    for (std::size_t r = 0; r < rows.size(); ++r)
        if (!outcomes[r].failed) tables.push_back(folder.table(rows[r]));
    flush_files(tables);
}

void refuse_left_over(const std::vector<SweepRow>& rows, const SweepFolder& folder) {
    for (const SweepRow& row : rows)
        if (fs::exists(folder.checkpoint(row)))
            throw std::runtime_error(folder.checkpoint(row).string() +
                                     ": is left from an interrupted sweep; --resume continues it, "
                                     "removing the file starts over");
}

}  // namespace

void run_sweep(const BakeCommand& command, Ranks* ranks) {
    std::vector<std::string> notes;
    const std::vector<SweepRow> rows = command.sweep.empty()
                                           ? read_sweep(command.recipe, &notes)
                                           : read_sweep(command.recipe, command.sweep, &notes);
    if (ranks && !ranks->is_first()) {
        const Alike alike = find_alike(rows);
        ranks->run(row_stage(rows, alike, command.threads), command.threads);
        ranks->finish();
        return;
    }
    const SweepFolder folder(command.output, command.resume);
    if (!command.resume) refuse_left_over(rows, folder);
    std::vector<Outcome> outcomes;
    {
        Progress progress(command.quiet);
        progress.notes(notes);
        std::optional<StopOnSignal> stop;
        if (!ranks) stop.emplace();
        try {
            outcomes = bake_rows(rows, folder, command, progress, ranks);
        } catch (const WorkStopped&) {
            throw EndedBySignal(stop->signal(), "interrupted; " + sentence_of_kept(command.output));
        }
    }
    flush(rows, outcomes, folder);
    write_summary(std::cout, rows, outcomes);
    write_answer(folder.summary(), [&](std::ostream& out) { write_summary(out, rows, outcomes); });
    if (ranks) ranks->finish();
    judge(outcomes, command);
}

}  // namespace stratus
