#include <stratus/io/checkpoint.h>
#include <stratus/io/file_bytes.h>

#include <libdeflate.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <fcntl.h>
#include <initializer_list>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <sys/stat.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <unordered_map>

namespace stratus {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view magic = "stratus-checkpoint 1\n";
constexpr std::string_view magic_without_version = "stratus-checkpoint ";
constexpr std::size_t max_name = 4096;  // far longer than any name
constexpr int max_tries = 20;           // to lock the file
constexpr std::chrono::milliseconds between_tries{50};

/// Precedes the name of a record. The checksum is of everything after it.
struct RecordHead {
    std::uint32_t checksum;
    std::uint32_t name_size;
    std::uint64_t size;
};
static_assert(sizeof(RecordHead) == 16);

std::uint32_t record_checksum(const RecordHead& head, std::string_view name,
                              std::span<const char> bytes) {
    const char* const covered = reinterpret_cast<const char*>(&head) + sizeof head.checksum;
    std::uint32_t sum = libdeflate_crc32(0, covered, sizeof head - sizeof head.checksum);
    sum = libdeflate_crc32(sum, name.data(), name.size());
    if (bytes.empty()) return sum;  // a null pointer would restart the checksum
    return libdeflate_crc32(sum, bytes.data(), bytes.size());
}

std::string shown_line(const std::string& line) {
    constexpr std::size_t longest = 100;
    return '"' + (line.size() > longest ? line.substr(0, longest) + "..." : line) + '"';
}

/// Throws, with the first line in which they differ, unless both texts are the same.
void check_same(const char* what, const std::string& stored, const std::string& expected) {
    if (stored == expected) return;
    std::istringstream stored_lines(stored), expected_lines(expected);
    std::string found, wanted;
    do {
        if (!std::getline(stored_lines, found)) found.clear();
        if (!std::getline(expected_lines, wanted)) wanted.clear();
    } while (found == wanted && (stored_lines || expected_lines));
    throw std::runtime_error(std::string("belongs to another ") + what + ", with " +
                             shown_line(found) + " where this one has " + shown_line(wanted) +
                             "; remove it to start over");
}

}  // namespace

struct Checkpoint::File {
    struct Content {
        std::uint64_t offset, size;
    };

    File(const fs::path& at, const CheckpointOwner& owner) : path(at), descriptor(open_locked(at)) {
        if (!find_records()) {
            begin(owner);
            return;
        }
        check_same("program", text("program"), owner.program);
        check_same("recipe", text("recipe"), owner.recipe);
        contents.erase("program");
        contents.erase("recipe");
        truncate(end);
    }

    /// Opens and locks the file, in several tries: a killed process holds its lock until the system
    /// has reclaimed its memory.
    static io::Descriptor open_locked(const fs::path& path) {
        for (int tries = 0; tries < max_tries; ++tries) {
            io::Descriptor opened(path, O_RDWR | O_CREAT | O_NOFOLLOW);
            // Its owner may have finished and removed it before it was locked.
            if (opened.lock() && opened.is_still_at(path)) return opened;
            std::this_thread::sleep_for(between_tries);
        }
        throw std::runtime_error("another bake of this table is running");
    }

    /// Finds all complete records; false if there are none besides the owner's.
    bool find_records() {
        struct stat status;
        if (::fstat(descriptor.number(), &status) != 0 || !S_ISREG(status.st_mode))
            throw std::runtime_error("is not a regular file");
        const auto size = static_cast<std::uint64_t>(status.st_size);
        std::string start(std::min<std::uint64_t>(size, magic.size()), '\0');
        read(0, start);
        if (start != magic.substr(0, start.size())) {
            const bool other_version = start.starts_with(magic_without_version);
            throw std::runtime_error(other_version ? "is a checkpoint of another version"
                                                   : "is not a checkpoint");
        }
        if (size < magic.size()) return false;
        end = magic.size();
        while (find_record(size)) continue;
        finished = contents.size();
        for (const char* owner : {"program", "recipe"}) finished -= contents.count(owner);
        return finished > 0;
    }

    /// Finds the record at `end`; false if it is not complete and undamaged.
    bool find_record(std::uint64_t size) {
        RecordHead head;
        if (size - end < sizeof head) return false;
        read(end, {reinterpret_cast<char*>(&head), sizeof head});
        const std::uint64_t rest = size - end - sizeof head;
        if (head.name_size > max_name || head.name_size > rest || head.size > rest - head.name_size)
            return false;
        std::string name(head.name_size, '\0');
        read(end + sizeof head, name);
        const std::uint64_t offset = end + sizeof head + name.size();
        std::vector<char> bytes(head.size);
        read(offset, bytes);
        if (record_checksum(head, name, bytes) != head.checksum) return false;
        contents[name] = {offset, head.size};
        end = offset + head.size;
        return true;
    }

    void begin(const CheckpointOwner& owner) {
        contents.clear();
        truncate(0);
        put({magic});
        append("program", owner.program);
        append("recipe", owner.recipe);
        finished = 0;
    }

    void append(const std::string& name, std::span<const char> bytes) {
        RecordHead head{0, static_cast<std::uint32_t>(name.size()), bytes.size()};
        head.checksum = record_checksum(head, name, bytes);
        put({{reinterpret_cast<const char*>(&head), sizeof head}, name, bytes});
    }

    /// Writes all parts at the end. If that fails, empties the file: on a full disk, the finished
    /// table matters more.
    void put(std::initializer_list<std::span<const char>> parts) {
        const std::lock_guard lock(mutex);
        if (!trouble.empty()) return;
        std::uint64_t at = end;
        try {
            for (const std::span<const char> part : parts) {
                descriptor.write_at(at, part);
                at += part.size();
            }
            end = at;
            ++finished;
        } catch (const std::system_error& error) {
            trouble = path.string() + ": " + error.code().message();
            contents.clear();
            finished = 0;
            truncate(0);
        }
    }

    /// May fail: what is left over is dropped on opening.
    void truncate(std::uint64_t at) {
        end = at;
        [[maybe_unused]] const int failure =
            ::ftruncate(descriptor.number(), static_cast<off_t>(end));
    }

    void read(std::uint64_t offset, std::span<char> bytes) const {
        descriptor.read_at(offset, bytes);
    }

    std::string text(const std::string& name) const {
        const auto found = contents.find(name);
        if (found == contents.end()) return "";
        std::string bytes(found->second.size, '\0');
        read(found->second.offset, bytes);
        return bytes;
    }

    const fs::path path;
    io::Descriptor descriptor;
    std::unordered_map<std::string, Content> contents;  // of the records found on opening
    std::uint64_t end = 0;                              // of the last complete record
    std::size_t finished = 0;
    std::string trouble;
    mutable std::mutex mutex;
};

Checkpoint::Checkpoint(const fs::path& path, const CheckpointOwner& owner)
    : file_(io::naming(path, [&] { return std::make_unique<File>(path, owner); })) {}

Checkpoint::~Checkpoint() {
    if (pieces() == 0) remove();
}

std::size_t Checkpoint::pieces() const {
    const std::lock_guard lock(file_->mutex);
    return file_->finished;
}

std::optional<std::vector<char>> Checkpoint::find(const std::string& piece) const {
    const std::lock_guard lock(file_->mutex);
    const auto found = file_->contents.find(piece);
    if (found == file_->contents.end()) return std::nullopt;
    std::vector<char> result(found->second.size);
    io::naming(file_->path, [&] { file_->read(found->second.offset, result); });
    return result;
}

void Checkpoint::keep(const std::string& piece, std::span<const char> result) {
    file_->append(piece, result);
}

std::string Checkpoint::trouble() const {
    const std::lock_guard lock(file_->mutex);
    return file_->trouble;
}

void Checkpoint::remove() {
    std::error_code ignored;
    if (!file_->descriptor.is_still_at(file_->path)) return;
    fs::remove(file_->path, ignored);
    file_->truncate(0);  // frees it now, not once it is closed
}

}  // namespace stratus
