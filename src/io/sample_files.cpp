#include <stratus/io/sample_files.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <fcntl.h>
#include <string>
#include <sys/mman.h>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace stratus {

struct SampleFiles::File {
    File() = default;
    ~File() {
        if (mapped != MAP_FAILED) ::munmap(mapped, size);
        if (number >= 0) ::close(number);
    }
    File(const File&) = delete;
    File& operator=(const File&) = delete;

    /// False where the system refuses.
    bool open_in(const std::filesystem::path& folder) {
        std::string name = folder / ".stratus-samples-XXXXXX";
        number = ::mkostemp(name.data(), O_CLOEXEC);
        if (number < 0 || ::unlink(name.c_str()) != 0) return false;
        if (::fallocate(number, 0, 0, static_cast<off_t>(size)) != 0) return false;
        mapped = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, number, 0);
        return mapped != MAP_FAILED;
    }

    int number = -1;
    void* mapped = MAP_FAILED;
    std::size_t size = 0;                          // bytes
    std::array<std::size_t, 2> first{}, counts{};  // samples of each side
};

SampleFiles::SampleFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}
SampleFiles::~SampleFiles() = default;

bool SampleFiles::make_room(const std::array<std::size_t, 2>& counts) {
    file_.reset();
    auto file = std::make_unique<File>();
    file->counts = counts;
    file->first = {0, counts[0]};
    file->size = std::max<std::size_t>(1, counts[0] + counts[1]) * sizeof(float);
    if (!file->open_in(folder_.empty() ? "." : folder_)) return false;
    file_ = std::move(file);
    return true;
}

void SampleFiles::write(Side side, std::size_t first, std::span<const float> samples) {
    auto at =
        static_cast<off_t>((file_->first[side == Side::transmission] + first) * sizeof(float));
    const char* next = reinterpret_cast<const char*>(samples.data());
    for (std::size_t left = samples.size_bytes(); left > 0;) {
        const ssize_t put = ::pwrite(file_->number, next, left, at);
        if (put < 0 && errno == EINTR) continue;
        if (put < 0) throw std::system_error(errno, std::generic_category());
        next += put;
        at += put;
        left -= static_cast<std::size_t>(put);
    }
}

std::span<const float> SampleFiles::samples(Side side) const noexcept {
    const std::size_t of = side == Side::transmission;
    return {static_cast<const float*>(file_->mapped) + file_->first[of], file_->counts[of]};
}

void SampleFiles::release() const noexcept { ::madvise(file_->mapped, file_->size, MADV_DONTNEED); }

}  // namespace stratus
