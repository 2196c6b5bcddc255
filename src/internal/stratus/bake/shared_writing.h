// Tables written by many ranks: all deflate, rank 0 writes the file.
#pragma once

#include <stratus/bake/ranks.h>
#include <stratus/io/write_options.h>
#include <stratus/table/table.h>

#include <filesystem>

namespace stratus {

/// Writes a .h5 as `write_table` does, called by rank 0 while all others are in `help_write`; each rank deflates on so many threads. Besides the table, rank 0 holds the parts
/// that are deflated.
///
/// Errors   those of `write_table`.
void write_on_ranks(const Table& table, const std::filesystem::path& path, Ranks& ranks,
                    int threads, const SampleFiles* samples);

void help_write(Ranks& ranks, int threads);

}  // namespace stratus
