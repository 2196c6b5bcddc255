#include "mapped_tensors.h"

#include <stratus/base/argument.h>
#include <stratus/base/size.h>
#include <stratus/base/tensor_file.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <system_error>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace stratus {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& reason) {
    throw std::runtime_error(path + ": " + reason);
}

[[noreturn]] void refuse_as_system(const std::string& path) {
    refuse(path, std::generic_category().message(errno));
}

struct Descriptor {
    int number;
    ~Descriptor() { ::close(number); }
};

}  // namespace

void MappedFile::Unmapping::operator()(void* data) const noexcept { ::munmap(data, bytes); }

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
    const std::size_t bytes = size(status.st_size);
    void* const start = ::mmap(nullptr, bytes, PROT_READ, MAP_PRIVATE, file.number, 0);
    if (start == MAP_FAILED) refuse_as_system(path);
    data_ = {start, Unmapping{bytes}};
}

namespace {

bool is_surrogate(std::uint32_t character) { return character >= 0xd800 && character < 0xe000; }

void append_utf8(std::string& text, std::uint32_t character) {
    constexpr std::uint32_t leads[] = {0, 0xc0, 0xe0, 0xf0};  // by bytes after the first
    const int more = character < 0x80 ? 0 : character < 0x800 ? 1 : character < 0x10000 ? 2 : 3;
    text += static_cast<char>(leads[more] | character >> 6 * more);
    for (int shift = 6 * (more - 1); shift >= 0; shift -= 6)
        text += static_cast<char>(0x80 | (character >> shift & 0x3f));
}

}  // namespace

void refuse_tensor_file(const std::string& argument, const std::string& allowed,
                        const std::string& met) {
    throw std::invalid_argument("TensorFile: " + argument + " must be " + allowed + ", got " + met);
}

std::string quoted(const std::string& text) { return "'" + shown(text, 60) + "'"; }

std::string list_text(const std::vector<std::size_t>& numbers) {
    std::vector<std::string> words;
    for (const std::size_t number : numbers) words.push_back(std::to_string(number));
    return "[" + joined(words) + "]";
}

bool is_utf8(const std::string& text) {
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t length = character_length(text, at);
        if (length == 0) return false;
        at += length;
    }
    return true;
}

std::string json_string(const std::string& utf8) {
    constexpr char hex[] = "0123456789abcdef";
    std::string json = "\"";
    for (const char letter : utf8) {
        if (letter == '"' || letter == '\\') {
            json += '\\';
            json += letter;
        } else if (static_cast<unsigned char>(letter) < ' ') {
            json += "\\u00";
            json += hex[letter >> 4];
            json += hex[letter & 15];
        } else {
            json += letter;
        }
    }
    return json + '"';
}

std::string TensorHeaderReader::read_string() {
    expect('"');
    const char* const start = next_ - 1;
    std::string text;
    while (!is_next('"')) {
        if (is_next('\\'))
            append_escape(text);
        else if (next_ == end_ || static_cast<unsigned char>(*next_) < ' ')
            refuse_tensor_file(place(next_), "a character of a string or '\"'", met());
        else
            text += *next_++;
    }
    ++next_;
    if (!is_utf8(text))
        refuse_tensor_file("the string from " + place(start), "UTF-8", quoted(text));
    return text;
}

std::size_t TensorHeaderReader::read_integer() {
    skip_space();
    const char* const start = next_;
    std::size_t number = 0;
    const auto [stop, error] = std::from_chars(start, end_, number);
    if (stop == start) refuse_tensor_file(place(start), "a digit", met());
    if (*start == '0' && stop - start > 1)
        refuse_tensor_file("the number from " + place(start), "without leading zeros",
                           quoted({start, 2}));
    if (error != std::errc())
        refuse_tensor_file("the number from " + place(start),
                           "at most " + std::to_string(std::numeric_limits<std::size_t>::max()),
                           "more");
    next_ = stop;
    return number;
}

std::vector<std::size_t> TensorHeaderReader::read_integers(std::size_t max) {
    std::vector<std::size_t> numbers;
    expect('[');
    const char* const start = next_ - 1;
    if (take(']')) return numbers;
    do {
        if (numbers.size() == max)
            refuse_tensor_file("the list from " + place(start),
                               "at most " + std::to_string(max) + " numbers", "more");
        numbers.push_back(read_integer());
    } while (take(','));
    expect(']');
    return numbers;
}

void TensorHeaderReader::expect_end() {
    skip_space();
    if (next_ != end_)
        refuse_tensor_file(place(next_), "a space up to the end of the header", met());
}

void TensorHeaderReader::skip_space() {
    while (is_next(' ') || is_next('\n') || is_next('\r') || is_next('\t')) ++next_;
}

bool TensorHeaderReader::take(char wanted) {
    skip_space();
    if (!is_next(wanted)) return false;
    ++next_;
    return true;
}

void TensorHeaderReader::expect(char wanted) {
    if (!take(wanted)) refuse_tensor_file(place(next_), std::string("'") + wanted + "'", met());
}

void TensorHeaderReader::append_escape(std::string& text) {
    constexpr char letters[] = "\"\\/bfnrt", meant[] = "\"\\/\b\f\n\r\t";
    ++next_;
    if (is_next('u')) {
        append_utf8(text, read_escaped_character());
        return;
    }
    const char* const letter =
        next_ == end_ || *next_ == '\0' ? nullptr : std::strchr(letters, *next_);
    if (letter == nullptr) refuse_tensor_file(place(next_), "one of \"\\/bfnrtu after '\\'", met());
    text += meant[letter - letters];
    ++next_;
}

std::uint32_t TensorHeaderReader::read_escaped_character() {
    const char* const start = next_;
    const std::uint32_t first = read_hex();
    if (!is_surrogate(first)) return first;
    if (first < 0xdc00 && end_ - next_ >= 2 && next_[0] == '\\' && next_[1] == 'u') {
        ++next_;
        const std::uint32_t second = read_hex();
        if (is_surrogate(second) && second >= 0xdc00)
            return 0x10000 + ((first - 0xd800) << 10) + (second - 0xdc00);
    }
    refuse_tensor_file("the character from " + place(start), "one, or a pair of surrogates",
                       "half a pair");
}

/// The four digits after 'u'.
std::uint32_t TensorHeaderReader::read_hex() {
    const char* const start = ++next_;
    std::uint32_t number = 0;
    next_ =
        std::from_chars(start, start + std::min<std::ptrdiff_t>(4, end_ - start), number, 16).ptr;
    if (next_ != start + 4) refuse_tensor_file(place(next_), "a hexadecimal digit", met());
    return number;
}

std::string TensorHeaderReader::place(const char* at) const {
    const auto offset = size(at - begin_);
    return "byte " + std::to_string(tensor_header_start + offset) + " of the file";
}

std::string TensorHeaderReader::met() const {
    return next_ == end_ ? "the end of the header" : quoted(std::string(1, *next_));
}

}  // namespace stratus
