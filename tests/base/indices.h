// Loops over indices.
#pragma once

#include <cstddef>
#include <iterator>

/// 0 to a count less one, in a loop over a range.
class IndicesBelow {
  public:
    explicit IndicesBelow(std::size_t count) : count_(count) {}

    struct Index {
        std::size_t n;

        std::size_t operator*() const { return n; }
        Index& operator++() { return ++n, *this; }
        bool operator!=(const Index& other) const { return n != other.n; }
    };
    Index begin() const { return {0}; }
    Index end() const { return {count_}; }

  private:
    std::size_t count_;
};

/// Those of a container or an array, whose size must not change meanwhile.
auto indices(const auto& of) { return IndicesBelow(std::size(of)); }

/// Those of red, green and blue.
inline const IndicesBelow three_channels(3);
