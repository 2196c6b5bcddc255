#include "piece_of_work.h"

#include <stratus/bake/parallel.h>
#include <stratus/bake/ranks.h>

namespace stratus {

WorkLog nested_log(const WorkLog& log, const std::string& part) {
    WorkLog named;
    if (log.find)
        named.find = [find = log.find, part](const std::string& piece) {
            return find(part + ", " + piece);
        };
    if (log.keep)
        named.keep = [keep = log.keep, part](const std::string& piece,
                                             std::span<const char> result) {
            keep(part + ", " + piece, result);
        };
    named.stop = log.stop;
    named.ranks = log.ranks;
    return named;
}

bool is_first_rank(const WorkLog& log) { return log.ranks == nullptr || log.ranks->is_first(); }

std::vector<char> shared(const WorkLog& log, std::vector<char> bytes) {
    return log.ranks == nullptr ? bytes : log.ranks->share(std::move(bytes));
}

void solve_pieces(const Pieces& pieces, const WorkLog& log, int threads) {
    const auto is_done = [&](int piece) {
        const auto found = log.find ? log.find(pieces.name(piece)) : std::nullopt;
        if (found) pieces.take(piece, *found);
        return found.has_value();
    };
    const auto solve = [&](int piece) {
        stop_if_asked(log);
        return pieces.solve(piece);
    };
    const auto take = [&](int piece, std::span<const char> result) {
        if (log.keep) log.keep(pieces.name(piece), result);
        pieces.take(piece, result);
    };
    const auto progress = [&](int done) {
        if (pieces.progress) pieces.progress(static_cast<double>(done) / pieces.count);
    };
    if (log.ranks != nullptr) {
        RankedStage stage;
        stage.count = pieces.count;
        stage.solve = [&](int piece, std::span<const char>) { return solve(piece); };
        stage.is_done = is_done;
        stage.take = take;
        stage.progress = progress;
        log.ranks->run(stage, thread_count(threads));
        return;
    }
    const auto do_piece = [&](int piece) {
        stop_if_asked(log);
        if (!is_done(piece)) take(piece, pieces.solve(piece));
    };
    parallel_for(pieces.count, threads, do_piece, progress);
}

std::vector<std::vector<double>> gather(const WorkLog& log, const std::vector<double>& numbers,
                                        int from_ranks) {
    if (log.ranks == nullptr) return {numbers};
    std::vector<std::vector<double>> of_rank;
    for (const std::vector<char>& bytes : log.ranks->gather(byte_span(numbers), from_ranks))
        of_rank.push_back(as_numbers<double>(bytes));
    return of_rank;
}

}  // namespace stratus
