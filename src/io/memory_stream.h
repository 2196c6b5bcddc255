// An OpenEXR stream of bytes in memory (see file_bytes.h for why), which are not copied; the attributes of its
// headers, whose lengths OpenEXR would allocate memory for before it reads them.
#pragma once

#include <stratus/io/file_bytes.h>

#include "table_content.h"

#include <OpenEXR/ImfIO.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string_view>

namespace stratus::io {

class MemoryInput : public Imf::IStream {
  public:
    MemoryInput(const Bytes& bytes, const char* name) : Imf::IStream(name), bytes_(bytes) {}

    bool read(char to[], int count) override {
        const auto wanted = static_cast<std::size_t>(count);
        if (count < 0 || position_ > bytes_.size() || wanted > bytes_.size() - position_)
            throw std::runtime_error("file is truncated or damaged");
        std::copy_n(bytes_.data() + position_, wanted, to);
        position_ += wanted;
        return position_ < bytes_.size();
    }
    uint64_t tellg() override { return position_; }
    void seekg(uint64_t position) override { position_ = position; }

  private:
    const Bytes& bytes_;
    std::size_t position_ = 0;
};

/// Reads a file's headers from the front and throws at the end of its bytes.
class HeaderReader {
  public:
    explicit HeaderReader(const Bytes& bytes) : rest_(bytes.data(), bytes.size()) {
        take(exr_magic.size());
        flags_ = take_integer();
    }

    std::int32_t flags() const noexcept { return flags_; }

    std::string_view take(std::size_t count) {
        if (count > rest_.size()) throw std::runtime_error("a header is truncated or damaged");
        const std::string_view taken = rest_.substr(0, count);
        rest_.remove_prefix(count);
        return taken;
    }

    std::int32_t take_integer() {
        std::int32_t value;
        std::memcpy(&value, take(sizeof value).data(), sizeof value);
        return value;
    }

    /// Characters up to a zero byte, which is taken too.
    std::string_view take_name() {
        const std::string_view name = take(rest_.find('\0'));
        take(1);
        return name;
    }

    bool at_zero() const noexcept { return !rest_.empty() && rest_.front() == '\0'; }

  private:
    std::string_view rest_;
    std::int32_t flags_;
};

constexpr std::int32_t multi_part = 0x1000;  // among the flags of a file

/// Whether an attribute ends where its length says. OpenEXR reads as many bytes as the type needs, whatever
/// length the file gives: if they differed, it would go on reading in the wrong place and allocate
/// memory for lengths that were not checked.
inline bool has_own_length(std::string_view type, std::string_view value) {
    static const std::map<std::string_view, std::size_t> sizes{
        {"box2f", 16},         {"box2i", 16},    {"chromaticities", 32},
        {"compression", 1},    {"double", 8},    {"envmap", 1},
        {"deepImageState", 1}, {"float", 4},     {"int", 4},
        {"keycode", 28},       {"lineOrder", 1}, {"m33d", 72},
        {"m33f", 36},          {"m44d", 128},    {"m44f", 64},
        {"rational", 8},       {"tiledesc", 9},  {"timecode", 8},
        {"v2d", 16},           {"v2f", 8},       {"v2i", 8},
        {"v3d", 24},           {"v3f", 12},      {"v3i", 12}};
    const auto found = sizes.find(type);
    if (found != sizes.end()) return value.size() == found->second;
    const auto integer_at = [&](std::size_t at) {
        std::uint32_t number = 0;
        if (at + sizeof number <= value.size()) std::memcpy(&number, &value[at], sizeof number);
        return std::uint64_t{number};
    };
    std::size_t at = 0;
    if (type == "chlist") {  // a name, a zero and 16 bytes of each channel; an empty name
        constexpr std::size_t after_name = 17;
        while (at < value.size() && value[at] != '\0')
            at = std::min(value.find('\0', at), value.size()) + after_name;
        return at + 1 == value.size();
    }
    if (type == "stringvector") {  // a length and as many bytes of each
        while (at + sizeof(std::uint32_t) <= value.size())
            at += sizeof(std::uint32_t) + static_cast<std::size_t>(integer_at(at));
        return at == value.size();
    }
    if (type == "floatvector") return value.size() % sizeof(float) == 0;
    if (type == "preview") {  // width, height and four bytes of each pixel
        const std::uint64_t width = integer_at(0), height = integer_at(4);
        return width <= value.size() && height <= value.size() &&
               value.size() == 8 + 4 * width * height;
    }
    return true;  // OpenEXR goes by the length
}

/// Calls visit(part, name, type, value) for all attributes of a file's headers.
///
/// Errors   std::runtime_error for lengths beyond the end of the file, or other than the type's.
template <class Visit>
void for_each_attribute(const Bytes& bytes, const Visit& visit) {
    HeaderReader header(bytes);
    int part = 0;
    do {
        while (!header.at_zero()) {
            const std::string_view name = header.take_name(), type = header.take_name();
            const std::int32_t size = header.take_integer();
            if (size < 0) throw std::runtime_error("a header is damaged");
            const std::string_view value = header.take(static_cast<std::size_t>(size));
            if (!has_own_length(type, value))
                throw std::runtime_error("a header has an attribute of the wrong length");
            visit(part, name, type, value);
        }
        header.take(1);
        ++part;
    } while ((header.flags() & multi_part) != 0 && !header.at_zero());
}

}  // namespace stratus::io
