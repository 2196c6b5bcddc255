// How long a bake takes on many ranks, by a model of what they share.
#include <stratus/bake/forecast.h>
#include <stratus/io/table_file.h>
#include <stratus/io/write_options.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>

namespace stratus {
namespace {

// Assumed of the machines and of the network between them.
constexpr double bytes_a_second = 1e9;              // that rank 0 receives and keeps, or gives
constexpr double seconds_a_message = 20e-6;         // of rank 0's time
constexpr double seconds_a_claim = 0.5e-3;          // until a claim is answered
constexpr double bytes_deflated_a_second = 9e7;     // by one thread
constexpr double share_of_choosing_repeated = 0.1;  // by every rank
constexpr int gatherings = 90;                      // of the ranks that choose

/// Seconds until all pieces are done, each by the first worker that is free.
double seconds_of(const std::vector<double>& pieces, int workers) {
    std::priority_queue<double, std::vector<double>, std::greater<>> free_at;
    const auto count = std::min(static_cast<std::size_t>(workers), pieces.size());
    for (std::size_t n = 0; n < count; ++n) free_at.push(0);
    double last = 0;
    for (const double piece : pieces) {
        const double end = free_at.top() + piece;
        free_at.pop();
        free_at.push(end);
        last = std::max(last, end);
    }
    return last;
}

/// Seconds of a stage, and what takes them.
struct Stage {
    double seconds;
    std::string limit;
};

Stage stage_of(const char* name, const std::vector<double>& pieces, double bytes, int ranks,
               int threads) {
    const double solving = seconds_of(pieces, ranks * threads);
    if (ranks == 1) return {solving, ""};
    const double others = 1 - 1.0 / ranks;
    const double receiving =
        others * (bytes / bytes_a_second + seconds_a_message * static_cast<double>(pieces.size()));
    if (receiving > solving) return {receiving, std::string(name) + ": rank 0 passes on all"};
    return {solving + seconds_a_claim,
            std::string(name) + ": " + std::to_string(pieces.size()) + " pieces"};
}

}  // namespace

RankedTime predict_on_ranks(const Forecast& forecast, int ranks, int threads) {
    const ShareableWork& work = forecast.work;
    const int sharing = std::min(ranks * threads, work.probed_albedos);
    const int most = (work.probed_albedos + sharing - 1) / sharing;  // albedos of one of them
    const double messages =
        ranks == 1 ? 0 : gatherings * (seconds_a_claim + sharing * seconds_a_message);
    const double share = static_cast<double>(most) / work.probed_albedos;
    const double repeated = ranks == 1 ? 0 : share_of_choosing_repeated;
    const Stage choosing{
        work.choosing_seconds * (repeated + (1 - repeated) * share) + messages,
        "choosing: " + std::to_string(work.probed_albedos) + " albedos are probed"};
    const Stage solving = stage_of("solving", work.unit_seconds, forecast.bytes, ranks, threads);
    const Stage checking =
        stage_of("checking",
                 std::vector<double>(static_cast<std::size_t>(work.ladders), work.ladder_seconds),
                 0, ranks, threads);
    const auto parts =
        static_cast<std::size_t>(std::max(1.0, std::ceil(forecast.bytes / most_bytes_of_part)));
    const Stage writing =
        stage_of("writing",
                 std::vector<double>(
                     parts, forecast.bytes / static_cast<double>(parts) / bytes_deflated_a_second),
                 forecast.bytes, ranks, threads);
    RankedTime time{ranks, choosing.seconds, solving.seconds, checking.seconds, writing.seconds,
                    ""};

    // More than a fair share of what one rank would take.
    const double solving_alone =
        std::accumulate(work.unit_seconds.begin(), work.unit_seconds.end(), 0.0);
    const std::pair<const Stage*, double> alone[] = {
        {&choosing, work.choosing_seconds},
        {&solving, solving_alone},
        {&checking, work.ladders * work.ladder_seconds},
        {&writing, forecast.bytes / bytes_deflated_a_second}};
    double most_lost = 0;
    for (const auto& [stage, seconds] : alone) {
        const double lost = stage->seconds - seconds / (ranks * threads);
        if (ranks == 1 || lost <= most_lost) continue;
        most_lost = lost;
        time.limit = stage->limit;
    }
    return time;
}

std::string text_of_ranks(const Forecast& forecast, const std::vector<int>& ranks, int threads) {
    const ShareableWork& work = forecast.work;
    char line[400];
    std::snprintf(line, sizeof line,
                  "%zu pieces to solve and %d to check, about %.2g flops to solve, %.3g bytes of "
                  "results; %d thread%s a rank\n"
                  "ranks   seconds     hours  choosing   solving  checking   writing  efficiency  "
                  "what more ranks do not shorten\n",
                  work.unit_seconds.size(), work.ladders, work.flops, forecast.bytes, threads,
                  threads == 1 ? "" : "s");
    std::string text = line;
    const double alone = predict_on_ranks(forecast, 1, threads).total();
    for (const int count : ranks) {
        const RankedTime time = predict_on_ranks(forecast, count, threads);
        std::snprintf(line, sizeof line, "%5d %9.3g %9.2g %9.3g %9.3g %9.3g %9.3g %11.2f  %s\n",
                      count, time.total(), time.total() / 3600, time.choosing, time.solving,
                      time.checking, time.writing, alone / (count * time.total()),
                      time.limit.c_str());
        text += line;
    }
    std::snprintf(line, sizeof line,
                  "measured: choosing, one piece to solve, one to check; assumed: rank 0 passes on "
                  "%.2g bytes a second and answers in %.2g ms; a thread deflates %.2g bytes a "
                  "second; every rank repeats %.2g of choosing\n",
                  bytes_a_second, 1e3 * seconds_a_claim, bytes_deflated_a_second,
                  share_of_choosing_repeated);
    return text + line;
}

}  // namespace stratus
