#include "hdf5_chunks.h"

#include <libdeflate.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <deque>
#include <future>
#include <memory>
#include <new>
#include <thread>
#include <utility>
#include <vector>

namespace stratus::io::hdf5 {
namespace {

constexpr int deflate_level = 6;      // of libdeflate
constexpr unsigned not_deflated = 2;  // mask of the second filter
constexpr std::size_t target_chunk_bytes = std::size_t{1} << 19;

/// Extents of a chunk, which is a run of consecutive samples: the whole of as many of the last
/// dimensions as fit the target size, the next one divided evenly, and 1 in the others.
struct Chunks {
    explicit Chunks(std::span<const std::size_t> extents) : chunk(extents.size()) {
        std::size_t bytes = sizeof(float);
        for (std::size_t d = extents.size(); d-- > 0;) {
            const std::size_t fitting =
                std::clamp(target_chunk_bytes / bytes, std::size_t{1}, extents[d]);
            const std::size_t parts = (extents[d] + fitting - 1) / fitting;
            chunk[d] = (extents[d] + parts - 1) / parts;
            bytes *= chunk[d];
        }
        while (split + 1 < extents.size() && chunk[split] == 1) ++split;
        for (std::size_t d = split + 1; d < extents.size(); ++d) inner *= extents[d];
    }
    std::size_t length() const { return chunk[split] * inner; }

    std::vector<hsize_t> chunk;
    std::size_t split = 0;  // the dimension that is divided
    std::size_t inner = 1;  // samples in the dimensions after it
};

/// The shuffle filter: the first bytes of all floats, then all second ones, and so on.
void shuffle(std::span<const float> values, std::span<unsigned char> bytes) {
    unsigned char* const plane = bytes.data();
    const std::size_t count = bytes.size() / sizeof(float);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto bits = std::bit_cast<std::uint32_t>(values[i]);
        for (std::size_t b = 0; b < sizeof(float); ++b)
            plane[b * count + i] = static_cast<unsigned char>(bits >> (8 * b));
    }
}

/// A chunk as the file holds it.
struct Deflated {
    std::vector<unsigned char> bytes;
    unsigned filters_left_out;  // of chunks that deflating makes no smaller
};

/// The chunk of `length` samples that begins with `values` and ends with zeros.
Deflated deflated(std::span<const float> values, std::size_t length) {
    std::vector<unsigned char> shuffled(length * sizeof(float)), bytes(shuffled.size());
    shuffle(values, shuffled);
    const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
        libdeflate_alloc_compressor(deflate_level), libdeflate_free_compressor);
    if (!compressor) throw std::bad_alloc();
    const std::size_t size = libdeflate_zlib_compress(compressor.get(), shuffled.data(),
                                                      shuffled.size(), bytes.data(), bytes.size());
    if (size == 0) return {std::move(shuffled), not_deflated};
    bytes.resize(size);
    return {std::move(bytes), 0};
}

/// Chunks that are deflated while one waits to be written: two for each thread, so that none is
/// idle while the first of them is not ready.
std::size_t chunks_ahead(int threads) {
    const unsigned all = threads > 0 ? static_cast<unsigned>(threads)
                                     : std::max(1u, std::thread::hardware_concurrency());
    return all == 1 ? 1 : 2 * std::size_t{all};
}

}  // namespace

void set_chunks(hid_t creation, std::span<const std::size_t> extents) {
    const Chunks chunks(extents);
    checked(H5Pset_chunk(creation, static_cast<int>(extents.size()), chunks.chunk.data()),
            "set chunks");
    checked(H5Pset_shuffle(creation), "set a filter");
    checked(H5Pset_deflate(creation, deflate_level), "set a filter");
}

void write_chunks(hid_t dataset, const std::string& name, std::span<const std::size_t> extents,
                  std::span<const float> values, int threads) {
    const Chunks chunks(extents);
    const std::size_t split = chunks.split;
    std::vector<hsize_t> at(extents.size(), 0);
    const auto write_next = [&](const Deflated& chunk) {
        checked(H5Dwrite_chunk(dataset, H5P_DEFAULT, chunk.filters_left_out, at.data(),
                               chunk.bytes.size(), chunk.bytes.data()),
                "write dataset " + name);
        at[split] = std::min<hsize_t>(extents[split], at[split] + chunks.chunk[split]);
        for (std::size_t d = split; d > 0 && at[d] == extents[d]; --d) {
            at[d] = 0;
            ++at[d - 1];
        }
    };
    const std::size_t run = extents[split] * chunks.inner;  // samples that whole chunks end with
    std::deque<std::future<Deflated>> ahead;
    for (std::size_t first = 0, count; first < values.size(); first += count) {
        count = std::min(chunks.length(), run - first % run);
        ahead.push_back(std::async(std::launch::async, deflated, values.subspan(first, count),
                                   chunks.length()));
        if (ahead.size() < chunks_ahead(threads)) continue;
        write_next(ahead.front().get());
        ahead.pop_front();
    }
    for (std::future<Deflated>& last : ahead) write_next(last.get());
}

}  // namespace stratus::io::hdf5
