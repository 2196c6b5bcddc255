// `stratus bake` of a sweep: a table a row of a CSV, or of a recipe's [sweep].
#pragma once

#include <string>

namespace stratus {

class Ranks;

struct SweepCommand {
    std::string recipe;
    std::string csv;  // empty: the rows of the recipe
    std::string folder;
    int threads = 0;
    bool quiet = false;
    bool resume = false;  // bakes only what the folder lacks
    bool accept = false;  // exit code 0 even where tables miss their tolerances
};

/// Bakes all rows, several at once, and tells how each came out. On ranks each row is baked by one of them,
/// which rank 0 gives it to, and rank 0 writes its table.
///
/// Errors   std::invalid_argument for the rows, before anything is baked; std::runtime_error where a
///          table failed or missed its tolerance, once all are done; EndedBySignal where one came.
void run_sweep(const SweepCommand& command, Ranks* ranks = nullptr);

}  // namespace stratus
