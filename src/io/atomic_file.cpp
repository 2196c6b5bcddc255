#include <stratus/io/atomic_file.h>

#include "file_bytes.h"

#include <atomic>
#include <cerrno>
#include <random>
#include <sstream>

#include <fcntl.h>
#include <unistd.h>

namespace stratus {
namespace {

namespace fs = std::filesystem;

/// A name beside `target` that no other process or thread uses. It keeps the ending, by which
/// writers pick their format.
fs::path temporary_beside(const fs::path& target) {
    static std::atomic<unsigned> counter{0};
    std::ostringstream name;
    name << '.' << target.stem().string() << '.' << ::getpid() << '-' << counter++ << '-'
         << std::hex << std::random_device{}() << ".partial" << target.extension().string();
    return target.parent_path() / name.str();
}

/// The file that a symbolic link leads to, so that the link stays; otherwise the path itself, with
/// its folder.
fs::path resolve(const fs::path& path) {
    return fs::absolute(fs::is_symlink(path) ? fs::weakly_canonical(path) : path);
}

/// A file that is removed at the end of its scope unless it was moved to its place.
class Temporary {
  public:
    explicit Temporary(fs::path path) : path_(std::move(path)) {
        io::Descriptor(path_, O_WRONLY | O_CREAT | O_EXCL).close();
    }
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
    fs::path path_;
};

/// The file to replace, after checking that nothing but a file stands in its place.
fs::path checked_target(const fs::path& path) {
    if (path.empty()) throw std::runtime_error("a file name is needed");
    fs::path target = resolve(path);
    const auto status = fs::status(target);
    if (fs::is_directory(status)) throw std::runtime_error("is a directory");
    if (fs::exists(status) && !fs::is_regular_file(status))
        throw std::runtime_error("is not a regular file");
    return target;
}

/// Makes a rename durable. File systems that cannot flush a folder say EINVAL; there is no more to
/// be done there.
void flush_folder(const io::Descriptor& folder) {
    try {
        folder.flush();
    } catch (const std::system_error& error) {
        if (error.code().value() != EINVAL) throw;
    }
}

}  // namespace

void write_atomically(const fs::path& path,
                      const std::function<void(const fs::path& temporary)>& write) {
    const fs::path target = io::naming(path, [&] { return checked_target(path); });
    const io::Descriptor folder = io::naming(
        path, [&] { return io::Descriptor(target.parent_path(), O_RDONLY | O_DIRECTORY); });
    Temporary temporary = io::naming(path, [&] { return Temporary(temporary_beside(target)); });
    try {
        write(temporary.path());
    } catch (const std::system_error& error) {  // would name the temporary file, or none
        throw std::runtime_error(path.string() + ": " + error.code().message());
    }
    io::naming(path, [&] {
        io::Descriptor(temporary.path(), O_RDONLY).flush();
        temporary.move_to(target);
        flush_folder(folder);
    });
}

}  // namespace stratus
