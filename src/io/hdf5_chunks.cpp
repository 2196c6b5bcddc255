#include "hdf5_chunks.h"

#include <libdeflate.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>
#include <memory>
#include <new>
#include <numeric>
#include <stdexcept>

namespace stratus::io::hdf5 {
namespace {

constexpr int deflate_level = 6;      // of libdeflate
constexpr unsigned not_deflated = 2;  // mask of the second filter
constexpr std::size_t target_chunk_bytes = std::size_t{1} << 19;

/// Enough for the largest dataset, of 8 GiB. HDF5 searches all chunks linearly for one.
constexpr std::size_t max_chunks = 1 << 15;

/// Extents of a chunk: the whole of as many of the last dimensions as fit the target size, the next
/// one divided evenly, and 1 in the others.
std::vector<hsize_t> chunk_extents(std::span<const std::size_t> extents) {
    std::vector<hsize_t> chunk(extents.size());
    std::size_t bytes = sizeof(float);
    for (std::size_t d = extents.size(); d-- > 0;) {
        const std::size_t fitting =
            std::clamp(target_chunk_bytes / bytes, std::size_t{1}, extents[d]);
        const std::size_t parts = (extents[d] + fitting - 1) / fitting;
        chunk[d] = (extents[d] + parts - 1) / parts;
        bytes *= chunk[d];
    }
    return chunk;
}

void check_filters(hid_t creation, const std::string& name) {
    const auto filter = [&](unsigned number) {
        std::size_t values = 0;
        return H5Pget_filter2(creation, number, nullptr, &values, nullptr, 0, nullptr, nullptr);
    };
    const int count = checked(H5Pget_nfilters(creation), "list the filters of " + name);
    for (int i = 0; i < count; ++i)
        if (const H5Z_filter_t met = filter(static_cast<unsigned>(i));
            met != H5Z_FILTER_SHUFFLE && met != H5Z_FILTER_DEFLATE)
            throw std::runtime_error(name + " uses a filter other than shuffle and deflate");
    if (count != 2 || filter(0) != H5Z_FILTER_SHUFFLE || filter(1) != H5Z_FILTER_DEFLATE)
        throw std::runtime_error(name + " must be shuffled and deflated, once each");
}

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

/// Its reverse.
void unshuffle(std::span<const unsigned char> bytes, std::span<float> values) {
    const unsigned char* const plane = bytes.data();
    const std::size_t count = bytes.size() / sizeof(float);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = std::bit_cast<float>(
            std::uint32_t{plane[i]} | std::uint32_t{plane[count + i]} << 8 |
            std::uint32_t{plane[2 * count + i]} << 16 | std::uint32_t{plane[3 * count + i]} << 24);
}

/// The shuffled bytes of the chunk at `at`: inflated into `buffer`, or a view of the file where the
/// chunk was not deflated because that would not have made it smaller.
std::span<const unsigned char> inflate(libdeflate_decompressor* decompressor, hid_t dataset,
                                       const std::string& name, const std::vector<hsize_t>& at,
                                       const Bytes& file_bytes, std::span<unsigned char> buffer) {
    unsigned skipped_filters = 0;
    haddr_t address = HADDR_UNDEF;
    hsize_t size = 0;
    checked(H5Dget_chunk_info_by_coord(dataset, at.data(), &skipped_filters, &address, &size),
            "find a chunk of " + name);
    if (address == HADDR_UNDEF) throw std::runtime_error(name + " is missing a chunk");
    if (address > file_bytes.size() || size > file_bytes.size() - address)
        throw std::runtime_error(name + " has a chunk beyond the end of the file");
    const auto* const stored = reinterpret_cast<const unsigned char*>(file_bytes.data()) + address;
    if (skipped_filters == not_deflated && size == buffer.size()) return {stored, buffer.size()};
    if (skipped_filters != 0 ||
        libdeflate_zlib_decompress(decompressor, stored, size, buffer.data(), buffer.size(),
                                   nullptr) != LIBDEFLATE_SUCCESS)
        throw std::runtime_error(name + " has a damaged chunk");
    return buffer;
}

/// Calls visit(at, first, count) for every chunk: its place in the dataset, and which samples it
/// holds, of `size`.
template <class Visit>
void for_each_chunk(const ChunkRuns& runs, std::size_t size, const Visit& visit) {
    std::vector<hsize_t> at(runs.extents.size(), 0);
    for (std::size_t first = 0; first < size;) {
        const std::size_t rows =
            std::min(runs.chunk[runs.split], runs.extents[runs.split] - at[runs.split]);
        visit(at, first, rows * runs.inner);
        first += rows * runs.inner;
        at[runs.split] += rows;
        for (std::size_t d = runs.split; d > 0 && at[d] == runs.extents[d]; --d) {
            at[d] = 0;
            ++at[d - 1];
        }
    }
}

}  // namespace

void set_chunks(hid_t creation, std::span<const std::size_t> extents) {
    const std::vector<hsize_t> chunk = chunk_extents(extents);
    checked(H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data()), "set chunks");
    checked(H5Pset_shuffle(creation), "set a filter");
    checked(H5Pset_deflate(creation, deflate_level), "set a filter");
}

ChunkRuns chunk_runs(hid_t creation, const std::string& name,
                     std::span<const std::size_t> extents) {
    check_filters(creation, name);
    ChunkRuns runs{{extents.begin(), extents.end()}, std::vector<hsize_t>(extents.size()), 0, 1};
    const int rank = static_cast<int>(extents.size());
    if (H5Pget_chunk(creation, rank, runs.chunk.data()) != rank)
        throw std::runtime_error("chunks of " + name + " have another rank than the dataset");
    for (std::size_t d = 0; d < extents.size(); ++d)
        if (runs.chunk[d] > extents[d])
            throw std::runtime_error(name + " has chunks beyond its extents");
    while (runs.split + 1 < extents.size() && runs.chunk[runs.split] == 1) ++runs.split;
    for (std::size_t d = runs.split + 1; d < extents.size(); ++d) {
        if (runs.chunk[d] != extents[d])
            throw std::runtime_error(name + " has chunks that are not runs of consecutive samples");
        runs.inner *= extents[d];
    }
    const std::size_t count =
        std::accumulate(extents.begin(), extents.end(), std::size_t{1}, std::multiplies<>()) /
        runs.length();
    if (count > max_chunks)
        throw std::runtime_error(name + " has more than " + std::to_string(max_chunks) + " chunks");
    return runs;
}

void write_chunks(hid_t dataset, const std::string& name, const ChunkRuns& runs,
                  std::span<const float> values) {
    const std::size_t chunk_bytes = runs.length() * sizeof(float);
    std::vector<unsigned char> shuffled(chunk_bytes), deflated(chunk_bytes);
    const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
        libdeflate_alloc_compressor(deflate_level), libdeflate_free_compressor);
    if (!compressor) throw std::bad_alloc();
    for_each_chunk(
        runs, values.size(),
        [&](const std::vector<hsize_t>& at, std::size_t first, std::size_t count) {
            if (count < runs.length()) std::fill(shuffled.begin(), shuffled.end(), '\0');
            shuffle(values.subspan(first, count), shuffled);
            const std::size_t size = libdeflate_zlib_compress(
                compressor.get(), shuffled.data(), chunk_bytes, deflated.data(), chunk_bytes);
            checked(size > 0
                        ? H5Dwrite_chunk(dataset, H5P_DEFAULT, 0, at.data(), size, deflated.data())
                        : H5Dwrite_chunk(dataset, H5P_DEFAULT, not_deflated, at.data(), chunk_bytes,
                                         shuffled.data()),
                    "write dataset " + name);
        });
}

void read_chunks(hid_t dataset, const std::string& name, const ChunkRuns& runs,
                 const Bytes& file_bytes, MemoryLimit limit, std::vector<float>& values) {
    const std::size_t chunk_bytes = runs.length() * sizeof(float);
    limit.take("a chunk of " + name, chunk_bytes);
    std::vector<unsigned char> buffer(chunk_bytes);
    const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)>
        decompressor(libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
    if (!decompressor) throw std::bad_alloc();
    for_each_chunk(runs, values.size(),
                   [&](const std::vector<hsize_t>& at, std::size_t first, std::size_t count) {
                       unshuffle(inflate(decompressor.get(), dataset, name, at, file_bytes, buffer),
                                 std::span(values).subspan(first, count));
                   });
}

}  // namespace stratus::io::hdf5
