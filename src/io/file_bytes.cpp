#include <stratus/io/file_bytes.h>

#include <stratus/base/number_text.h>
#include <stratus/base/size.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <fcntl.h>
#include <limits>
#include <stdexcept>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace stratus::io {

namespace {

/// Limit of a single read or write; that of Linux is 2 GiB.
constexpr std::size_t max_transfer = std::size_t{1} << 30;

std::system_error last_error() { return {errno, std::generic_category()}; }

}  // namespace

Descriptor::Descriptor(const std::filesystem::path& path, int flags)
    : number_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {
    if (number_ < 0) throw last_error();
}

Descriptor Descriptor::unnamed_in(const std::filesystem::path& folder) {
    std::string name = folder / ".stratus-samples-XXXXXX";
    Descriptor file(::mkostemp(name.data(), O_CLOEXEC));
    if (file.number_ < 0 || ::unlink(name.c_str()) != 0) throw last_error();
    return file;
}

Descriptor::~Descriptor() {
    if (number_ >= 0) ::close(number_);
}

void Descriptor::read_at(std::uint64_t offset, std::span<char> bytes) const {
    while (!bytes.empty()) {
        const ssize_t got = ::pread(number_, bytes.data(), std::min(bytes.size(), max_transfer),
                                    static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) throw last_error();
        if (got == 0) throw std::runtime_error("was truncated while being read");
        bytes = bytes.subspan(size(got));
        offset += static_cast<std::uint64_t>(got);
    }
}

void Descriptor::write_at(std::uint64_t offset, std::span<const char> bytes) const {
    while (!bytes.empty()) {
        const ssize_t put = ::pwrite(number_, bytes.data(), std::min(bytes.size(), max_transfer),
                                     static_cast<off_t>(offset));
        if (put < 0 && errno == EINTR) continue;
        if (put < 0) throw last_error();
        bytes = bytes.subspan(size(put));
        offset += static_cast<std::uint64_t>(put);
    }
}

void Descriptor::resize(std::uint64_t size) const {
    if (::ftruncate(number_, static_cast<off_t>(size)) != 0) throw last_error();
}

bool Descriptor::lock() const {
    int failure = 0;
    do failure = ::flock(number_, LOCK_EX | LOCK_NB) != 0 ? errno : 0;
    while (failure == EINTR);
    return failure != EWOULDBLOCK;
}

bool Descriptor::is_still_at(const std::filesystem::path& path) const {
    struct stat here, there;
    return ::fstat(number_, &here) == 0 && ::lstat(path.c_str(), &there) == 0 &&
           here.st_dev == there.st_dev && here.st_ino == there.st_ino;
}

void Descriptor::flush() const {
    if (::fsync(number_) != 0) throw last_error();
}

void Descriptor::close() {
    if (::close(std::exchange(number_, -1)) != 0) throw last_error();
}

Bytes read_bytes(const std::filesystem::path& path, std::string_view magic, const std::string& kind,
                 MemoryLimit& limit) {
    const auto status = std::filesystem::status(path);
    if (std::filesystem::is_directory(status)) throw std::runtime_error("is a directory");
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
        throw std::runtime_error("is not a regular file");

    const Descriptor file(path, O_RDONLY);
    const std::uintmax_t size = std::filesystem::file_size(path);
    if (size == 0) throw std::runtime_error("is empty");
    Bytes bytes(static_cast<std::size_t>(std::min<std::uintmax_t>(size, magic.size())));
    file.read_at(0, bytes);
    if (std::string_view(bytes.data(), bytes.size()) != magic)
        throw std::runtime_error("is not " + kind + " file");
    limit.take("the file", size);
    bytes.resize(static_cast<std::size_t>(size));
    file.read_at(magic.size(), std::span(bytes).subspan(magic.size()));
    return bytes;
}

void write_bytes(const std::filesystem::path& path, std::span<const char> bytes) {
    Descriptor file(path, O_WRONLY | O_CREAT | O_TRUNC);
    file.write_at(0, bytes);
    file.close();
}

namespace {

std::string mebibytes(std::uintmax_t bytes) {
    return short_number(static_cast<double>(bytes) / (1 << 20), 4) + " MiB";
}

}  // namespace

std::uintmax_t default_max_memory() {
    const long pages = ::sysconf(_SC_PHYS_PAGES);
    const long page = ::sysconf(_SC_PAGESIZE);
    if (pages <= 0 || page <= 0) return std::numeric_limits<std::uintmax_t>::max();
    return static_cast<std::uintmax_t>(pages) * static_cast<std::uintmax_t>(page) / 2;
}

void MemoryLimit::take(const std::string& what, std::uintmax_t bytes) {
    if (bytes > max_bytes_ - taken_)
        throw std::runtime_error("reading " + what + " needs " +
                                 mebibytes(taken_ + std::min(bytes, UINTMAX_MAX - taken_)) +
                                 " of memory in total, more than the limit of " +
                                 mebibytes(max_bytes_));
    taken_ += bytes;
}

}  // namespace stratus::io

namespace stratus {

std::ifstream open_text(const std::filesystem::path& path) {
    std::ifstream file(path);
    if (!file || std::filesystem::is_directory(path))
        throw std::runtime_error(path.string() + ": cannot be read");
    return file;
}

std::string read_text(const std::filesystem::path& path) {
    std::ifstream file = open_text(path);
    std::string text;
    constexpr std::size_t step = 1 << 16;
    while (file && text.size() <= max_text) {
        const std::size_t size = text.size();
        text.resize(size + step);
        file.read(text.data() + size, static_cast<std::streamsize>(step));
        text.resize(size + static_cast<std::size_t>(file.gcount()));
    }
    if (file.bad()) throw std::runtime_error(path.string() + ": cannot be read");
    if (text.size() > max_text)
        throw std::runtime_error(path.string() + ": must have at most " + std::to_string(max_text) +
                                 " bytes, got more");
    return text;
}

bool read_line(std::istream& stream, std::string& line, std::uint64_t most) {
    using Traits = std::istream::traits_type;
    line.clear();
    const std::istream::sentry ready(stream, true);
    if (!ready) return false;
    std::streambuf& buffer = *stream.rdbuf();
    try {
        for (;;) {
            const Traits::int_type next = buffer.sbumpc();
            if (Traits::eq_int_type(next, Traits::eof())) break;
            if (next == '\n') return true;
            line += Traits::to_char_type(next);
            if (line.size() > most) return true;
        }
    } catch (const std::ios_base::failure&) {  // the buffer's, of a folder
        stream.setstate(std::ios::badbit);
        return false;
    }
    stream.setstate(line.empty() ? std::ios::eofbit | std::ios::failbit : std::ios::eofbit);
    return !line.empty();
}

}  // namespace stratus
