// Pieces of work whose results are numbers.
#pragma once

#include <stratus/bake/work_log.h>

#include <cstring>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {

/// Throws WorkStopped where the log asks for it.
inline void stop_if_asked(const WorkLog& log) {
    if (log.stop && log.stop()) throw WorkStopped();
}

/// The same log for part of the work: its pieces are named after it.
WorkLog part_of(const WorkLog& log, const std::string& part);

/// The `count` numbers of a finished piece.
///
/// Errors   std::runtime_error for another count.
template <class Number>
std::optional<std::vector<Number>> find_finished(const WorkLog& log, const std::string& piece,
                                                 std::size_t count) {
    if (!log.find) return std::nullopt;
    const std::optional<std::vector<char>> bytes = log.find(piece);
    if (!bytes) return std::nullopt;
    if (bytes->size() != count * sizeof(Number))
        throw std::runtime_error("finished work: " + piece + " must hold " +
                                 std::to_string(count * sizeof(Number)) + " bytes, got " +
                                 std::to_string(bytes->size()));
    std::vector<Number> numbers(count);
    if (count > 0) std::memcpy(numbers.data(), bytes->data(), bytes->size());
    return numbers;
}

template <class Number>
void keep_finished(const WorkLog& log, const std::string& piece,
                   const std::vector<Number>& numbers) {
    if (!log.keep) return;
    const auto bytes = std::as_bytes(std::span(numbers));
    log.keep(piece, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace stratus
