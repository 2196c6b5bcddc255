// Messages between ranks (ranks.cpp): a head, and bytes after it.
#pragma once

#include <algorithm>
#include <cstring>
#include <span>
#include <stdexcept>
#include <vector>

namespace stratus {

enum Tag {
    to_first,    // answered by rank 0's thread that serves
    gathering,   // awaited by rank 0 in `gather`
    sign,        // of life, from rank 0
    first_slot,  // and on: the answer to a claim, for each thread of a rank
};

enum class Kind { claim, alive, failed, leaving };

constexpr int no_piece = -1;
constexpr int not_yet = -2;  // the next piece waits for others

/// Before the bytes of a message to rank 0, and of its signs of life.
struct Head {
    Kind kind;
    int stage, slot;
    int piece = no_piece;  // whose result follows
    int pieces = 0;        // RankTally
    double seconds = 0;
};

template <class Content>
std::span<const char> raw_bytes(const Content& content) {
    return {reinterpret_cast<const char*>(&content), sizeof content};
}

template <class Content>
Content content_of(std::span<const char> bytes) {
    if (bytes.size() < sizeof(Content)) throw std::runtime_error("ranks: a message is cut short");
    Content content;
    std::memcpy(&content, bytes.data(), sizeof content);
    return content;
}

inline std::vector<char> joined(const Head& head, std::span<const char> bytes) {
    const std::span<const char> first = raw_bytes(head);
    std::vector<char> all(first.size() + bytes.size());
    std::ranges::copy(bytes, std::ranges::copy(first, all.begin()).out);
    return all;
}

}  // namespace stratus
