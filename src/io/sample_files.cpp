#include <stratus/io/file_bytes.h>
#include <stratus/io/write_options.h>

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <sys/mman.h>
#include <system_error>
#include <utility>

namespace stratus {

struct SampleFiles::File {
    /// Errors   std::system_error where the system refuses.
    File(const std::filesystem::path& folder, const PerSide<std::size_t>& of_sides)
        : descriptor(io::Descriptor::unnamed_in(folder)),
          size(std::max<std::size_t>(1, of_sides.reflection + of_sides.transmission) *
               sizeof(float)),
          first{0, of_sides.reflection},
          counts(of_sides) {
        const int number = descriptor.number();
        if (::fallocate(number, 0, 0, static_cast<off_t>(size)) == 0)
            mapped = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, number, 0);
        if (mapped == MAP_FAILED) throw std::system_error(errno, std::generic_category());
    }
    ~File() { ::munmap(mapped, size); }
    File(const File&) = delete;
    File& operator=(const File&) = delete;

    const io::Descriptor descriptor;
    const std::size_t size;                    // bytes
    const PerSide<std::size_t> first, counts;  // samples of each side
    void* mapped = MAP_FAILED;
};

SampleFiles::SampleFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}
SampleFiles::~SampleFiles() = default;

bool SampleFiles::make_room(const PerSide<std::size_t>& counts) {
    file_.reset();
    try {
        file_ = std::make_unique<File>(folder_.empty() ? "." : folder_, counts);
    } catch (const std::system_error&) {
        return false;
    }
    return true;
}

void SampleFiles::write(Side side, std::size_t first, std::span<const float> samples) {
    const std::size_t at = file_->first[side] + first;
    file_->descriptor.write_at(
        at * sizeof(float), {reinterpret_cast<const char*>(samples.data()), samples.size_bytes()});
}

std::span<const float> SampleFiles::samples(Side side) const noexcept {
    return {static_cast<const float*>(file_->mapped) + file_->first[side], file_->counts[side]};
}

void SampleFiles::release() const noexcept { ::madvise(file_->mapped, file_->size, MADV_DONTNEED); }

}  // namespace stratus
