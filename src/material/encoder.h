// Little-endian files, built in memory.
#pragma once

#include <stratus/io/atomic_file.h>

#include <bit>
#include <cstddef>
#include <filesystem>
#include <string_view>
#include <type_traits>
#include <vector>

namespace stratus {

class Encoder {
  public:
    static_assert(std::endian::native == std::endian::little, "files are little-endian");

    template <class Number>
    void put(Number value) {
        static_assert(std::is_arithmetic_v<Number>);
        const char* const first = reinterpret_cast<const char*>(&value);
        bytes_.insert(bytes_.end(), first, first + sizeof value);
    }
    template <class Number>
    void put(const std::vector<Number>& values) {
        static_assert(std::is_arithmetic_v<Number>);
        const char* const first = reinterpret_cast<const char*>(values.data());
        bytes_.insert(bytes_.end(), first, first + values.size() * sizeof(Number));
    }
    void put(std::string_view text) { bytes_.insert(bytes_.end(), text.begin(), text.end()); }

    std::size_t size() const { return bytes_.size(); }
    const std::vector<char>& bytes() const { return bytes_; }

    /// Errors   std::system_error.
    void write(const std::filesystem::path& path) const {
        write_content(path, {bytes_.data(), bytes_.size()});
    }

  private:
    std::vector<char> bytes_;
};

}  // namespace stratus
