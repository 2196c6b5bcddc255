// The formats, one file each, and what they share.
#pragma once

#include <stratus/io/file_bytes.h>
#include <stratus/material/material.h>

#include "solved_stack.h"

#include <bit>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace stratus {

MaterialFile make_fourier(const Material& material, const MaterialOptions& options);
MaterialFile make_tensor(const Material& material, bool rgb, const MaterialOptions& options);
MaterialFile make_mqdiffuse(const Material& material, const MaterialOptions& options);
MaterialFile make_atlas(const Material& material, const MaterialOptions& options);
MaterialFile make_slice(const Material& material, const MaterialOptions& options);

/// Returns a MaterialFile::write of these bytes.
std::function<void(const std::filesystem::path&)> writing(std::vector<char> bytes);

/// Every colour of a material solved at the same cosines.
std::vector<SolvedStack> solve_colours(const Material& material, const std::vector<double>& mu,
                                       const MaterialOptions& options);

/// Describes a material for a file's text: its title, layers and the ground under them.
std::string describe(const Material& material);

/// The note on the beam; none where nothing passes.
void note_beam(const Material& material, std::vector<std::string>& notes);

/// The note on what passes, for formats of reflection alone; none where nothing does.
void note_transmission(const Material& material, std::vector<std::string>& notes);

/// A little-endian file, built in memory.
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

    /// Returns the whole file, after which nothing is left.
    std::vector<char> finish() { return std::move(bytes_); }

  private:
    std::vector<char> bytes_;
};

}  // namespace stratus
