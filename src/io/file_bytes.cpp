#include <stratus/io/file_bytes.h>

#include <stratus/base/number_text.h>
#include <stratus/base/size.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <limits>
#include <random>
#include <sstream>

namespace stratus::io {

namespace {

/// Limit of a single read or write; that of Linux is 2 GiB.
constexpr std::size_t max_transfer = std::size_t{1} << 30;

std::system_error last_error() { return {errno, std::generic_category()}; }

/// Throws for what is there and no regular file.
void require_regular(const fs::path& path) {
    const auto status = fs::status(path);
    if (fs::is_directory(status)) throw std::runtime_error("is a directory");
    if (fs::exists(status) && !fs::is_regular_file(status))
        throw std::runtime_error("is not a regular file");
}

}  // namespace

Descriptor::Descriptor(const fs::path& path, int flags)
    : number_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {
    if (number_ < 0) throw last_error();
}

Descriptor Descriptor::unnamed_in(const fs::path& folder) {
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

bool Descriptor::is_still_at(const fs::path& path) const {
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

Bytes read_bytes(const fs::path& path, std::string_view magic, const std::string& kind,
                 MemoryLimit& limit) {
    require_regular(path);
    const Descriptor file(path, O_RDONLY);
    const std::uintmax_t size = fs::file_size(path);
    if (size == 0) throw std::runtime_error("is empty");
    Bytes bytes(std::min<std::uintmax_t>(size, magic.size()));
    file.read_at(0, bytes);
    if (std::string_view(bytes.data(), bytes.size()) != magic)
        throw std::runtime_error("is not " + kind + " file");
    limit.take("the file", size);
    bytes.resize(size);
    file.read_at(magic.size(), std::span(bytes).subspan(magic.size()));
    return bytes;
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

std::string read_text(const fs::path& path) {
    std::ifstream file(path);
    if (!file || fs::is_directory(path)) file.setstate(std::ios::badbit);
    std::string text;
    constexpr int step = 1 << 16;
    while (file && text.size() <= max_text) {
        const std::size_t before = text.size();
        text.resize(before + step);
        file.read(text.data() + before, step);
        text.resize(before + size(file.gcount()));
    }
    if (file.bad()) throw std::runtime_error(path.string() + ": cannot be read");
    if (text.size() > max_text)
        throw std::runtime_error(path.string() + ": must have at most " + std::to_string(max_text) +
                                 " bytes, got more");
    return text;
}

bool read_line(std::istream& stream, std::string& line) {
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
            if (line.size() > max_text) return true;
        }
    } catch (const std::ios_base::failure&) {  // the buffer's, of a folder
        stream.setstate(std::ios::badbit);
        return false;
    }
    stream.setstate(line.empty() ? std::ios::eofbit | std::ios::failbit : std::ios::eofbit);
    return !line.empty();
}

namespace {

// A temporary file of `target` is called .STEM.NUMBERS.partial.EXT. It keeps the extension because
// writers choose their format by it.

std::string start_of_temporary(const fs::path& target) {
    return '.' + target.stem().string() + '.';
}

std::string end_of_temporary(const fs::path& target) {
    return ".partial" + target.extension().string();
}

/// A name beside `target` that no other process or thread uses.
fs::path temporary_beside(const fs::path& target) {
    static std::atomic<unsigned> counter{0};
    std::ostringstream name;
    name << start_of_temporary(target) << ::getpid() << '-' << counter++ << '-' << std::hex
         << std::random_device{}() << end_of_temporary(target);
    return target.parent_path() / name.str();
}

bool is_temporary_for(const fs::path& target, const fs::path& path) {
    const std::string name = path.filename().string(), start = start_of_temporary(target),
                      end = end_of_temporary(target);
    return name.size() > start.size() + end.size() && name.starts_with(start) &&
           name.ends_with(end) &&
           name.find_first_not_of("0123456789abcdef-", start.size()) == name.size() - end.size();
}

/// Removes temporary files that killed writers of `target` left behind; living writers hold a lock.
void remove_abandoned(const fs::path& target) {
    std::error_code failure;
    for (fs::directory_iterator entry(target.parent_path(), failure), end; !failure && entry != end;
         entry.increment(failure)) {
        if (!is_temporary_for(target, entry->path())) continue;
        try {
            const io::Descriptor file(entry->path(), O_RDWR | O_NOFOLLOW);
            std::error_code ignored;
            if (file.lock()) fs::remove(entry->path(), ignored);
        } catch (const std::system_error&) {  // not ours to remove
        }
    }
}

/// A link of the system to a file that is open, which others may be writing to.
bool names_open_file(const fs::path& path) {
    const std::string folder = path.parent_path().string();
    return folder == "/dev/fd" || (folder.starts_with("/proc/") && folder.ends_with("/fd"));
}

/// The absolute path of the file to replace: the target of a symbolic link, there or not, so that
/// the link stays, or the path itself.
fs::path resolve(const fs::path& path) {
    constexpr int max_links = 40;  // as Linux follows
    fs::path target = fs::absolute(path);
    for (int links = 0; fs::is_symlink(target); ++links) {
        if (links == max_links)
            throw std::system_error(std::make_error_code(std::errc::too_many_symbolic_link_levels));
        if (names_open_file(target))
            throw std::runtime_error("names an open file, which cannot be replaced");
        target = target.parent_path() / fs::read_symlink(target);
    }
    return target.lexically_normal();
}

/// A temporary file, removed at the end of its scope unless it has been moved to its target.
class Temporary {
  public:
    explicit Temporary(const fs::path& target) : file_(create(target)) {}
    ~Temporary() {
        std::error_code ignored;
        if (!path_.empty()) fs::remove(path_, ignored);
    }
    Temporary(const Temporary&) = delete;
    Temporary& operator=(const Temporary&) = delete;

    const fs::path& path() const noexcept { return path_; }

    void move_to(const fs::path& target) {
        fs::rename(path_, target);
        path_.clear();
    }

  private:
    io::Descriptor create(const fs::path& target) {
        for (int tries = 0; tries < 100; ++tries) {
            path_ = temporary_beside(target);
            io::Descriptor created(path_, O_RDWR | O_CREAT | O_EXCL);
            // Another writer may have removed it as abandoned before it was locked.
            if (created.lock() && created.is_still_at(path_)) return created;
            std::error_code ignored;
            fs::remove(path_, ignored);
        }
        throw std::system_error(std::make_error_code(std::errc::no_lock_available));
    }

    fs::path path_;
    io::Descriptor file_;  // locked while its writer lives
};

/// The file to replace, which must be a regular file if it exists.
fs::path checked_target(const fs::path& path) {
    if (path.empty()) throw std::runtime_error("a file name is needed");
    fs::path target = resolve(path);
    io::require_regular(target);
    return target;
}

/// Makes a rename durable, except on file systems that cannot flush a folder and report EINVAL.
void flush_folder(const io::Descriptor& folder) {
    try {
        folder.flush();
    } catch (const std::system_error& error) {
        if (error.code().value() != EINVAL) throw;
    }
}

}  // namespace

bool takes_what_comes(const fs::path& path) {
    std::error_code absent;
    const auto status = fs::status(path, absent);
    return fs::is_character_file(status) || fs::is_fifo(status) || path == "/dev/stdout" ||
           path == "/dev/stderr" || names_open_file(path);
}

void write_atomically(const fs::path& path,
                      const std::function<void(const fs::path& temporary)>& write, Flush flush) {
    const fs::path target = io::naming(path, [&] { return checked_target(path); });
    const io::Descriptor folder = io::naming(
        path, [&] { return io::Descriptor(target.parent_path(), O_RDONLY | O_DIRECTORY); });
    remove_abandoned(target);
    Temporary temporary = io::naming(path, [&] { return Temporary(target); });
    try {
        write(temporary.path());
    } catch (const std::system_error& error) {  // name the target instead of the temporary file
        throw std::runtime_error(path.string() + ": " + error.code().message());
    }
    io::naming(path, [&] {
        if (flush == Flush::at_once) io::Descriptor(temporary.path(), O_RDONLY).flush();
        temporary.move_to(target);
        if (flush == Flush::at_once) flush_folder(folder);
    });
}

void write_content(const fs::path& path, std::span<const char> content) {
    io::Descriptor file(path, O_WRONLY | O_CREAT | O_TRUNC);
    file.write_at(0, content);
    file.close();
}

void write_content_atomically(const fs::path& path, std::span<const char> content, Flush flush) {
    write_atomically(
        path, [&](const fs::path& temporary) { write_content(temporary, content); }, flush);
}

void flush_files(const std::vector<fs::path>& paths) {
    for (const fs::path& path : paths)
        io::naming(path, [&] { io::Descriptor(path, O_RDONLY).flush(); });
    if (paths.empty()) return;
    const fs::path folder = resolve(paths[0]).parent_path();
    io::naming(folder, [&] { flush_folder(io::Descriptor(folder, O_RDONLY | O_DIRECTORY)); });
}

}  // namespace stratus
