#include <stratus/io/atomic_file.h>
#include <stratus/io/file_bytes.h>

#include <atomic>
#include <cerrno>
#include <fcntl.h>
#include <random>
#include <sstream>
#include <unistd.h>

namespace stratus {
namespace {

namespace fs = std::filesystem;

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
        for (;;) {
            const fs::path path = temporary_beside(target);
            io::Descriptor created(path, O_RDWR | O_CREAT | O_EXCL);
            // Another writer may have removed it as abandoned before it was locked.
            if (!created.lock() || !created.is_still_at(path)) continue;
            path_ = path;
            return created;
        }
    }

    fs::path path_;
    io::Descriptor file_;  // locked while its writer lives
};

/// The file to replace, which must be a regular file if it exists.
fs::path checked_target(const fs::path& path) {
    if (path.empty()) throw std::runtime_error("a file name is needed");
    fs::path target = resolve(path);
    const auto status = fs::status(target);
    if (fs::is_directory(status)) throw std::runtime_error("is a directory");
    if (fs::exists(status) && !fs::is_regular_file(status))
        throw std::runtime_error("is not a regular file");
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

void write_content(const fs::path& path, std::string_view content) {
    io::write_bytes(path, content);
}

void write_content_atomically(const fs::path& path, std::string_view content, Flush flush) {
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
