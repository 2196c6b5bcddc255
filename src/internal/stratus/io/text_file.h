// Text that people write, read whole: recipes, scenes, rows.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <istream>
#include <string>

namespace stratus {

/// Most bytes of a recipe or a scene, of a line of rows, and of anything that comes through a pipe
/// or from a device, which need not end.
constexpr std::uint64_t max_text = std::uint64_t{64} << 20;

/// Opens a file, a pipe or a device; waits for somebody to write into a pipe of that name.
///
/// Errors   std::runtime_error "PATH: cannot be read".
std::ifstream open_text(const std::filesystem::path& path);

/// A whole file.
///
/// Errors   std::runtime_error as above; "PATH: must have at most 67108864 bytes, got more".
std::string read_text(const std::filesystem::path& path);

/// The next line, of at most `most` bytes: false at the end, and bad() where the stream
/// cannot be read. A longer one is cut after one byte more, to be refused.
bool read_line(std::istream& stream, std::string& line, std::uint64_t most = max_text);

}  // namespace stratus
