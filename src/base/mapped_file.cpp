#include "mapped_file.h"

#include <stratus/base/size.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>

#if defined(__unix__) || defined(__APPLE__)
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#else
#include <filesystem>
#include <fstream>
#include <new>
#endif

namespace stratus {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& reason) {
    throw std::runtime_error(path + ": " + reason);
}

[[noreturn]] void refuse_as_system(const std::string& path) {
    refuse(path, std::generic_category().message(errno));
}

}  // namespace

#if defined(__unix__) || defined(__APPLE__)

namespace {

struct Descriptor {
    int number;
    ~Descriptor() { ::close(number); }
};

}  // namespace

MappedFile::MappedFile(const std::string& path) {
    // Without waiting for somebody to write into a pipe of this name, which is refused then.
    const int number = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (number < 0) refuse_as_system(path);
    const Descriptor file{number};
    struct stat status;
    if (::fstat(file.number, &status) != 0) refuse_as_system(path);
    if (S_ISDIR(status.st_mode)) refuse(path, "is a directory");
    if (!S_ISREG(status.st_mode)) refuse(path, "is not a regular file");
    if (status.st_size == 0) refuse(path, "is empty");
    bytes_ = size(status.st_size);
    void* const start = ::mmap(nullptr, bytes_, PROT_READ, MAP_PRIVATE, file.number, 0);
    if (start == MAP_FAILED) refuse_as_system(path);
    data_ = start;
}

MappedFile::~MappedFile() {
    if (data_ != nullptr) ::munmap(data_, bytes_);
}

#else

namespace {

constexpr std::align_val_t alignment{64};

}  // namespace

MappedFile::MappedFile(const std::string& path) {
    std::error_code ignored;  // opening the file says it better
    const auto status = std::filesystem::status(path, ignored);
    if (std::filesystem::is_directory(status)) refuse(path, "is a directory");
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
        refuse(path, "is not a regular file");
    errno = 0;
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    const std::streamoff length = file ? static_cast<std::streamoff>(file.tellg()) : 0;
    if (!file || length < 0) refuse_as_system(path);
    if (length == 0) refuse(path, "is empty");
    bytes_ = size(length);
    data_ = ::operator new(bytes_, alignment);
    file.seekg(0);
    if (!file.read(static_cast<char*>(data_), static_cast<std::streamsize>(length))) {
        ::operator delete(data_, alignment);
        refuse_as_system(path);
    }
}

MappedFile::~MappedFile() {
    if (data_ != nullptr) ::operator delete(data_, alignment);
}

#endif

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(bytes_, other.bytes_);
    return *this;
}

}  // namespace stratus
