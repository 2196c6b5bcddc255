// The messages between ranks, which ranks.cpp sends and answers.
//
// Start. Every rank sends rank 0 its machine and process (tag `gathering`); rank 0 broadcasts all of them.
// Later `share` and `gather` do the same with what a bake decides: none of them has a head.
//
// A stage. Each thread of another rank, a slot, sends rank 0 a claim (tag `to_first`): a Head with its stage
// and slot and, from the second on, a piece that it has solved, followed by the piece's result. Rank 0
// answers with tag `first_slot` + slot: an int, the next piece, followed by what the solver is given; or
// no_piece, after which the slot is done with the stage. A claim for a stage that rank 0 has not begun, or
// for a piece that must wait for others, is answered when that is over. Rank 0 answers a claim before it
// deals with the result that came with it.
//
// Signs of life. Every other rank sends a Head `alive` once a second or more often; rank 0 answers with tag
// `life_sign`: a Head `alive` and a sentence about the work that is kept, which the rank says if rank 0 is
// lost. Who hears nothing for RanksOptions::time_limit ends all ranks.
//
// The end. After a last broadcast each rank sends a Head `leaving` with its tally and waits for the same
// with tag `life_sign`. A rank that fails sends `failed` followed by its reason, and waits to be ended.
#pragma once

#include <algorithm>
#include <cstring>
#include <span>
#include <stdexcept>
#include <vector>

namespace stratus {

enum Tag {
    to_first,    // to rank 0, whose serving thread answers
    gathering,   // to rank 0 in `gather`
    life_sign,   // from rank 0
    first_slot,  // and above, from rank 0: the answer to the claim of a slot
};

enum class Kind { claim, alive, failed, leaving };

constexpr int no_piece = -1;
constexpr int not_yet = -2;  // the next piece waits for others; never sent

/// Precedes the bytes of a message to rank 0, and of rank 0's signs of life.
struct Head {
    Kind kind;
    int stage, slot;
    int piece = no_piece;  // whose result follows
    int pieces = 0;        // that the rank solved: RankTally
    double seconds = 0;
};

template <class Content>
std::span<const char> raw_bytes(const Content& content) {
    return {reinterpret_cast<const char*>(&content), sizeof content};
}

template <class Content>
Content from_raw_bytes(std::span<const char> bytes) {
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
