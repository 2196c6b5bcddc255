#include "hdf5_chunks.h"

#include <libdeflate.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>
#include <new>
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

}  // namespace

void set_chunks(hid_t creation, std::span<const std::size_t> extents) {
    const Chunks chunks(extents);
    checked(H5Pset_chunk(creation, static_cast<int>(extents.size()), chunks.chunk.data()),
            "set chunks");
    checked(H5Pset_shuffle(creation), "set a filter");
    checked(H5Pset_deflate(creation, deflate_level), "set a filter");
}

void write_chunks(hid_t dataset, const std::string& name, std::span<const std::size_t> extents,
                  std::span<const float> values) {
    const Chunks chunks(extents);
    const std::size_t split = chunks.split, chunk_bytes = chunks.length() * sizeof(float);
    std::vector<unsigned char> shuffled(chunk_bytes), deflated(chunk_bytes);
    const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
        libdeflate_alloc_compressor(deflate_level), libdeflate_free_compressor);
    if (!compressor) throw std::bad_alloc();
    std::vector<hsize_t> at(extents.size(), 0);
    for (std::size_t first = 0; first < values.size();) {
        const std::size_t rows = std::min<std::size_t>(chunks.chunk[split],
                                                       extents[split] - at[split]),
                          count = rows * chunks.inner;
        if (count < chunks.length()) std::ranges::fill(shuffled, '\0');
        shuffle(values.subspan(first, count), shuffled);
        const std::size_t size = libdeflate_zlib_compress(
            compressor.get(), shuffled.data(), chunk_bytes, deflated.data(), chunk_bytes);
        const bool smaller = size > 0;
        checked(H5Dwrite_chunk(dataset, H5P_DEFAULT, smaller ? 0 : not_deflated, at.data(),
                               smaller ? size : chunk_bytes,
                               smaller ? deflated.data() : shuffled.data()),
                "write dataset " + name);
        first += count;
        at[split] += rows;
        for (std::size_t d = split; d > 0 && at[d] == extents[d]; --d) {
            at[d] = 0;
            ++at[d - 1];
        }
    }
}

}  // namespace stratus::io::hdf5
