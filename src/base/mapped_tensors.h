// Files of tensors as they lie on the disk: mapped into memory, then the header that says what they hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace stratus {

/// A regular file, open for reading until the end of its scope. It may be replaced or removed
/// meanwhile (stratus/io/file_bytes.h does no more), but not shortened: what is gone cannot be
/// read, and systems that map files end a program that tries.
class MappedFile {
  public:
    /// Errors   std::runtime_error "PATH: reason".
    explicit MappedFile(const std::string& path);

    /// Aligned to at least 64 bytes.
    const void* data() const noexcept { return data_.get(); }
    std::size_t bytes() const noexcept { return data_.get_deleter().bytes; }

  private:
    struct Unmapping {
        std::size_t bytes;
        void operator()(void* data) const noexcept;
    };
    std::unique_ptr<void, Unmapping> data_;
};

// The header of a file of tensors (tensor_file.h) as text: its JSON, and what is said about it.

constexpr std::size_t tensor_header_start = 8;  // bytes of the header's length, before it

/// Throws std::invalid_argument "TensorFile: argument must be allowed, got met".
[[noreturn]] void refuse_tensor_file(const std::string& argument, const std::string& allowed,
                                     const std::string& met);

/// A text for a message, in quotation marks, as shown() has it.
std::string quoted(const std::string& text);

/// "[2, 3]", which is JSON, too.
std::string list_text(const std::vector<std::size_t>& numbers);

bool is_utf8(const std::string& text);

/// Reads JSON of the few forms that a header has: objects of what the caller reads, strings, lists
/// of integers, spaces between them. No function calls itself, so depth is that of the caller.
///
/// Errors   std::invalid_argument for everything else.
class TensorHeaderReader {
  public:
    TensorHeaderReader(const char* begin, const char* end)
        : begin_(begin), end_(end), next_(begin) {}

    /// Calls member(key) for each key, which reads the value.
    template <class Member>
    void read_object(const Member& member) {
        expect('{');
        if (take('}')) return;
        do {
            const std::string key = read_string();
            expect(':');
            member(key);
        } while (take(','));
        expect('}');
    }

    std::string read_string();

    /// At most `max` integers, none negative.
    std::vector<std::size_t> read_integers(std::size_t max);

    /// Nothing but spaces is left.
    void expect_end();

  private:
    bool is_next(char wanted) const { return next_ != end_ && *next_ == wanted; }
    void skip_space();
    bool take(char wanted);
    void expect(char wanted);
    std::size_t read_integer();
    void append_escape(std::string& text);
    std::uint32_t read_escaped_character();
    std::uint32_t read_hex();
    std::string place(const char* at) const;
    std::string met() const;

    const char *begin_, *end_, *next_;
};

}  // namespace stratus
