#include <stratus/io/checkpoint.h>

#include <stratus/base/argument.h>

#include <libdeflate.h>

#include <algorithm>
#include <chrono>
#include <fcntl.h>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <sys/stat.h>
#include <system_error>
#include <thread>
#include <unistd.h>

namespace stratus {
namespace {

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

/// Throws, with the first line in which they differ, unless both texts are the same.
void check_same(const char* what, const std::string& stored, const std::string& expected) {
    if (stored == expected) return;
    std::istringstream stored_lines(stored), expected_lines(expected);
    std::string found, wanted;
    do {
        if (!std::getline(stored_lines, found)) found.clear();
        if (!std::getline(expected_lines, wanted)) wanted.clear();
    } while (found == wanted && (stored_lines || expected_lines));
    constexpr std::size_t most = 100;  // bytes of a line
    throw std::runtime_error(std::string("belongs to another ") + what + ", with \"" +
                             shown(found, most) + "\" where this one has \"" + shown(wanted, most) +
                             "\"; remove it to start over");
}

/// Opens and locks the file, in several tries: a killed process holds its lock until the system
/// has reclaimed its memory.
io::Descriptor open_locked(const fs::path& path) {
    for (int tries = 0; tries < max_tries; ++tries) {
        io::Descriptor opened(path, O_RDWR | O_CREAT | O_NOFOLLOW);
        // Its owner may have finished and removed it before it was locked.
        if (opened.lock() && opened.is_still_at(path)) return opened;
        std::this_thread::sleep_for(between_tries);
    }
    throw std::runtime_error("another bake of this table is running");
}

}  // namespace

Checkpoint::Checkpoint(const fs::path& path, const CheckpointOwner& owner)
    : path_(path), file_(io::naming(path, [&] { return open_locked(path); })) {
    if (!io::naming(path_, [&] { return find_records(); })) {
        begin(owner);
        return;
    }
    const auto text = [&](const char* name) {
        const std::vector<char> bytes = find(name).value_or(std::vector<char>{});
        return std::string(bytes.begin(), bytes.end());
    };
    const std::string program = text("program"), recipe = text("recipe");
    io::naming(path_, [&] {
        check_same("program", program, owner.program);
        check_same("recipe", recipe, owner.recipe);
    });
    contents_.erase("program");
    contents_.erase("recipe");
    truncate(end_);
}

Checkpoint::~Checkpoint() {
    if (pieces() == 0) remove();
}

/// Finds all complete records; false if there are none besides the owner's.
bool Checkpoint::find_records() {
    struct stat status;
    if (::fstat(file_.number(), &status) != 0 || !S_ISREG(status.st_mode))
        throw std::runtime_error("is not a regular file");
    const auto size = static_cast<std::uint64_t>(status.st_size);
    std::string start(std::min<std::uint64_t>(size, magic.size()), '\0');
    file_.read_at(0, start);
    if (start != magic.substr(0, start.size())) {
        const bool other_version = start.starts_with(magic_without_version);
        throw std::runtime_error(other_version ? "is a checkpoint of another version"
                                               : "is not a checkpoint");
    }
    if (size < magic.size()) return false;
    end_ = magic.size();
    while (find_record(size)) continue;
    finished_ = contents_.size();
    for (const char* owner : {"program", "recipe"}) finished_ -= contents_.count(owner);
    return finished_ > 0;
}

/// Finds the record at the end of those found, in a file of `size` bytes; false if it is not complete
/// and undamaged.
bool Checkpoint::find_record(std::uint64_t size) {
    RecordHead head;
    if (size - end_ < sizeof head) return false;
    file_.read_at(end_, {reinterpret_cast<char*>(&head), sizeof head});
    const std::uint64_t rest = size - end_ - sizeof head;
    if (head.name_size > max_name || head.name_size > rest || head.size > rest - head.name_size)
        return false;
    std::string name(head.name_size, '\0');
    file_.read_at(end_ + sizeof head, name);
    const std::uint64_t offset = end_ + sizeof head + name.size();
    std::vector<char> bytes(head.size);
    file_.read_at(offset, bytes);
    if (record_checksum(head, name, bytes) != head.checksum) return false;
    contents_[name] = {offset, head.size};
    end_ = offset + head.size;
    return true;
}

void Checkpoint::begin(const CheckpointOwner& owner) {
    contents_.clear();
    truncate(0);
    put({magic});
    keep("program", owner.program);
    keep("recipe", owner.recipe);
    finished_ = 0;
}

/// Writes all parts at the end. If that fails, empties the file: on a full disk, the finished
/// table matters more.
void Checkpoint::put(std::initializer_list<std::span<const char>> parts) {
    const std::lock_guard lock(mutex_);
    if (!trouble_.empty()) return;
    std::uint64_t at = end_;
    try {
        for (const std::span<const char> part : parts) {
            file_.write_at(at, part);
            at += part.size();
        }
        end_ = at;
        ++finished_;
    } catch (const std::system_error& error) {
        trouble_ = path_.string() + ": " + error.code().message();
        contents_.clear();
        finished_ = 0;
        truncate(0);
    }
}

/// May fail: what is left over is dropped on opening.
void Checkpoint::truncate(std::uint64_t at) {
    end_ = at;
    [[maybe_unused]] const int failure = ::ftruncate(file_.number(), static_cast<off_t>(end_));
}

std::size_t Checkpoint::pieces() const {
    const std::lock_guard lock(mutex_);
    return finished_;
}

std::optional<std::vector<char>> Checkpoint::find(const std::string& piece) const {
    const std::lock_guard lock(mutex_);
    const auto found = contents_.find(piece);
    if (found == contents_.end()) return std::nullopt;
    std::vector<char> result(found->second.size);
    io::naming(path_, [&] { file_.read_at(found->second.offset, result); });
    return result;
}

void Checkpoint::keep(const std::string& piece, std::span<const char> result) {
    RecordHead head{0, static_cast<std::uint32_t>(piece.size()), result.size()};
    head.checksum = record_checksum(head, piece, result);
    put({{reinterpret_cast<const char*>(&head), sizeof head}, piece, result});
}

std::string Checkpoint::trouble() const {
    const std::lock_guard lock(mutex_);
    return trouble_;
}

void Checkpoint::remove() {
    std::error_code ignored;
    if (!file_.is_still_at(path_)) return;
    fs::remove(path_, ignored);
    truncate(0);  // frees it now, not once it is closed
}

}  // namespace stratus
