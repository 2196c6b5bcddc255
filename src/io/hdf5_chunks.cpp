#include "hdf5_parts.h"

#include <libdeflate.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <thread>
#include <utility>
#include <vector>

namespace stratus::io::hdf5 {
namespace {

constexpr int deflate_level = 6;      // of libdeflate
constexpr unsigned not_deflated = 2;  // mask of the second filter
constexpr std::size_t target_chunk_bytes = std::size_t{1} << 19;

/// Where chunks end, of samples of which the first begins one.
struct Cuts {
    std::size_t length;  // samples of a chunk
    std::size_t run;     // samples that the last chunk may cut short

    /// Samples of the chunk that begins there.
    std::size_t count_from(std::size_t first) const { return std::min(length, run - first % run); }
};

/// Extents of a chunk, which is a run of consecutive samples: the whole of as many of the last
/// dimensions as fit the target size, the next one divided evenly, and 1 in the others.
struct Chunks {
    explicit Chunks(Extents extents) : chunk(extents.size()) {
        std::size_t bytes = sizeof(float);
        for (std::size_t d = extents.size(); d-- > 0;) {
            const std::size_t fitting =
                std::clamp(target_chunk_bytes / bytes, std::size_t{1}, extents[d]);
            const std::size_t parts = (extents[d] + fitting - 1) / fitting;
            chunk[d] = (extents[d] + parts - 1) / parts;
            bytes *= chunk[d];
        }
        std::size_t d = 0;
        while (d + 1 < extents.size() && chunk[d] == 1) ++d;
        cuts = {chunk[d], extents[d]};
        while (++d < extents.size()) cuts = {cuts.length * extents[d], cuts.run * extents[d]};
    }

    std::vector<hsize_t> chunk;
    Cuts cuts;
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

/// A dataset's chunks, written in their order.
struct OrderedChunks {
    hid_t dataset;
    std::string name;
    Extents extents;
    Cuts cuts = Chunks(extents).cuts;
    std::size_t next = 0;  // sample

    void write_next(const Deflated& chunk) {
        std::vector<hsize_t> at(extents.size());
        std::size_t rest = next;
        for (std::size_t d = at.size(); d-- > 0; rest /= extents[d]) at[d] = rest % extents[d];
        checked(H5Dwrite_chunk(dataset, H5P_DEFAULT, chunk.filters_left_out, at.data(),
                               chunk.bytes.size(), chunk.bytes.data()),
                "write dataset " + name);
        next += cuts.count_from(next);
    }
};

// ---- parts --------------------------------------------------------------------------------------

/// Before the bytes of each chunk of a part.
struct DeflatedHead {
    std::size_t size;
    unsigned filters_left_out;
};

template <class Content>
std::span<const std::byte> byte_span(const Content& content) {
    return std::as_bytes(std::span(&content, 1));
}

void append(std::span<const std::byte> bytes, std::vector<char>& all) {
    const std::size_t before = all.size();
    all.resize(before + bytes.size());
    if (!bytes.empty()) std::memcpy(all.data() + before, bytes.data(), bytes.size());
}

/// Takes what `bytes` begin with.
template <class Content>
Content taken(std::span<const char>& bytes) {
    if (bytes.size() < sizeof(Content)) throw std::runtime_error("a part of a table is cut short");
    Content content;
    std::memcpy(&content, bytes.data(), sizeof content);
    bytes = bytes.subspan(sizeof content);
    return content;
}

/// Some chunks each: whole runs, or a part of one.
class Parts {
  public:
    Parts(const Cuts& cuts, std::span<const float> values) : cuts_(cuts), values_(values) {
        const std::size_t most = most_bytes_of_part / sizeof(float);
        const std::size_t runs = most / cuts.run, chunks = most / cuts.length;
        for (std::size_t first = 0; first < values.size();) {
            first_.push_back(first);
            first += runs > 0 ? runs * cuts.run
                              : std::min(chunks * cuts.length, cuts.run - first % cuts.run);
        }
        first_.push_back(values.size());
    }

    int count() const { return int_size(first_) - 1; }

    std::vector<char> give(int part) const {
        const std::size_t n = size(part);
        const Cuts of_part{cuts_.length, cuts_.run - first_[n] % cuts_.run};
        std::vector<char> given;
        append(byte_span(of_part), given);
        append(std::as_bytes(values_.subspan(first_[n], first_[n + 1] - first_[n])), given);
        return given;
    }

    void take(int part, std::span<const char> deflated, OrderedChunks& file) {
        const std::lock_guard lock(mutex_);
        waiting_.emplace(part, std::vector(deflated.begin(), deflated.end()));
        for (; !waiting_.empty() && waiting_.begin()->first == next_; ++next_) {
            std::span<const char> bytes = waiting_.begin()->second;
            while (!bytes.empty()) {
                const auto head = taken<DeflatedHead>(bytes);
                if (bytes.size() < head.size)
                    throw std::runtime_error("a part of a table is cut short");
                const auto* const first = reinterpret_cast<const unsigned char*>(bytes.data());
                file.write_next({{first, first + head.size}, head.filters_left_out});
                bytes = bytes.subspan(head.size);
            }
            waiting_.erase(waiting_.begin());
        }
    }

  private:
    const Cuts cuts_;
    const std::span<const float> values_;
    std::vector<std::size_t> first_;  // sample of each part, and the end of the last
    std::mutex mutex_;
    int next_ = 0;                              // part in the file
    std::map<int, std::vector<char>> waiting_;  // deflated
};

/// Chunks that are deflated while one waits to be written: two for each thread, so that none is
/// idle while the first of them is not ready.
std::size_t chunks_ahead(int threads) {
    const unsigned all = threads > 0 ? static_cast<unsigned>(threads)
                                     : std::max(1u, std::thread::hardware_concurrency());
    return all == 1 ? 1 : 2 * std::size_t{all};
}

}  // namespace

void set_chunks(hid_t creation, Extents extents) {
    const Chunks chunks(extents);
    checked(H5Pset_chunk(creation, int_size(extents), chunks.chunk.data()), "set chunks");
    checked(H5Pset_shuffle(creation), "set a filter");
    checked(H5Pset_deflate(creation, deflate_level), "set a filter");
}

void release_samples(const WriteOptions& options) {
    if (options.samples) options.samples->release();
}

void write_chunks(hid_t dataset, const std::string& name, Extents extents,
                  std::span<const float> values, const WriteOptions& options) {
    OrderedChunks file{dataset, name, extents};
    if (options.share) {
        Parts parts(file.cuts, values);
        options.share({parts.count(), [&](int part) { return parts.give(part); },
                       [&](int part, std::span<const char> deflated) {
                           parts.take(part, deflated, file);
                           release_samples(options);
                       }});
        return;
    }
    const Cuts& cuts = file.cuts;
    std::deque<std::future<Deflated>> ahead;
    for (std::size_t first = 0; first < values.size(); first += cuts.count_from(first)) {
        ahead.push_back(
            std::async(deflated, values.subspan(first, cuts.count_from(first)), cuts.length));
        if (ahead.size() < chunks_ahead(options.threads)) continue;
        file.write_next(ahead.front().get());
        release_samples(options);
        ahead.pop_front();
    }
    for (std::future<Deflated>& last : ahead) file.write_next(last.get());
}

}  // namespace stratus::io::hdf5

namespace stratus {

std::vector<char> deflate_part(std::span<const char> given) {
    using namespace io::hdf5;
    const auto cuts = taken<Cuts>(given);
    if (cuts.length == 0 || cuts.run == 0 || given.size() % sizeof(float) != 0)
        throw std::runtime_error("a part of a table to deflate is damaged");
    std::vector<float> values(given.size() / sizeof(float));
    if (!values.empty()) std::memcpy(values.data(), given.data(), given.size());
    std::vector<char> all;
    for (std::size_t first = 0; first < values.size(); first += cuts.count_from(first)) {
        const std::size_t count = std::min(cuts.count_from(first), values.size() - first);
        const Deflated chunk = deflated(std::span(values).subspan(first, count), cuts.length);
        append(byte_span(DeflatedHead{chunk.bytes.size(), chunk.filters_left_out}), all);
        append(std::as_bytes(std::span(chunk.bytes)), all);
    }
    return all;
}

}  // namespace stratus
