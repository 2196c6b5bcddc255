// An OpenEXR stream of bytes in memory (see file_bytes.h for why), which are not copied; the attributes of its
// headers, whose lengths OpenEXR would allocate memory for before it reads them.
#pragma once

#include <stratus/io/file_bytes.h>

#include "table_content.h"

#include <OpenEXR/ImfIO.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
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

/// Calls visit(part, name, type, value) for all attributes of a file's headers.
///
/// Errors   std::runtime_error for lengths beyond the end of the file.
template <class Visit>
void for_each_attribute(const Bytes& bytes, const Visit& visit) {
    HeaderReader header(bytes);
    int part = 0;
    do {
        while (!header.at_zero()) {
            const std::string_view name = header.take_name(), type = header.take_name();
            const std::int32_t size = header.take_integer();
            if (size < 0) throw std::runtime_error("a header is damaged");
            visit(part, name, type, header.take(static_cast<std::size_t>(size)));
        }
        header.take(1);
        ++part;
    } while ((header.flags() & multi_part) != 0 && !header.at_zero());
}

}  // namespace stratus::io
