// Pieces of work whose results are numbers.
#pragma once

#include <stratus/bake/bake.h>

#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace stratus {

/// Throws WorkStopped where the log asks for it.
inline void stop_if_asked(const WorkLog& log) {
    if (log.stop && log.stop()) throw WorkStopped();
}

/// Returns the log for part of the work: its pieces are named after the part.
WorkLog nested_log(const WorkLog& log, const std::string& part);

template <class Number>
std::span<const char> byte_span(const std::vector<Number>& numbers) {
    const auto bytes = std::as_bytes(std::span(numbers));
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

template <class Number>
std::vector<char> as_chars(const std::vector<Number>& numbers) {
    const std::span<const char> bytes = byte_span(numbers);
    return {bytes.begin(), bytes.end()};
}

template <class Number>
std::vector<Number> as_numbers(std::span<const char> bytes) {
    std::vector<Number> numbers(bytes.size() / sizeof(Number));
    if (!numbers.empty()) std::memcpy(numbers.data(), bytes.data(), bytes.size());
    return numbers;
}

/// The `count` numbers that are the result of a piece.
///
/// Errors   std::runtime_error for another count.
template <class Number>
std::vector<Number> numbers_in(std::span<const char> result, const std::string& piece,
                               std::size_t count) {
    if (result.size() != count * sizeof(Number))
        throw std::runtime_error("finished work: " + piece + " must hold " +
                                 std::to_string(count * sizeof(Number)) + " bytes, got " +
                                 std::to_string(result.size()));
    return as_numbers<Number>(result);
}

/// Whether this process has the table: rank 0, or one that works alone.
bool is_first_rank(const WorkLog& log);

/// Broadcasts the bytes of rank 0 to all ranks, which call this in the same order and outside of `solve_pieces`.
std::vector<char> shared(const WorkLog& log, std::vector<char> bytes);

/// Lists the numbers of each of the first so many ranks, on all of them; called likewise.
std::vector<std::vector<double>> gather(const WorkLog& log, const std::vector<double>& numbers,
                                        int from_ranks);

/// The `count` numbers of a finished piece, on all ranks: as `shared`.
///
/// Errors   std::runtime_error for another count.
template <class Number>
std::optional<std::vector<Number>> find_finished(const WorkLog& log, const std::string& piece,
                                                 std::size_t count) {
    std::vector<char> found;  // and whether it was, first
    if (log.find)
        if (const auto result = log.find(piece)) {
            found = {1};
            found.insert(found.end(), result->begin(), result->end());
        }
    found = shared(log, std::move(found));
    if (found.empty()) return std::nullopt;
    return numbers_in<Number>(std::span(found).subspan(1), piece, count);
}

template <class Number>
void keep_finished(const WorkLog& log, const std::string& piece,
                   const std::vector<Number>& numbers) {
    if (log.keep) log.keep(piece, byte_span(numbers));
}

/// A stage of the work in pieces 0 .. count - 1.
///
/// Threads  all functions are called by several at once, but `progress`.
struct Pieces {
    int count;
    std::function<std::string(int piece)> name;  // in the log
    std::function<std::vector<char>(int piece)> solve;
    /// Puts a result where it belongs; with ranks, on rank 0 alone.
    std::function<void(int piece, std::span<const char> result)> take;
    std::function<void(double done)> progress;  // share; may be empty
};

/// Solves all pieces that are not in the log, on threads of this process or on all ranks.
void solve_pieces(const Pieces& pieces, const WorkLog& log, int threads);

}  // namespace stratus
