// Samples of a table on the disk while it is baked, so that memory need not hold them.
#pragma once

#include <stratus/layer/single_scattering.h>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>

namespace stratus {

/// Threads  `make_room` by one alone; all else by any.
class SampleFiles {
  public:
    explicit SampleFiles(std::filesystem::path folder);
    ~SampleFiles();
    SampleFiles(const SampleFiles&) = delete;
    SampleFiles& operator=(const SampleFiles&) = delete;

    /// Room for so many samples of reflection and of transmission, in a file without a name, which
    /// goes with the process; what it held before is lost. False where the folder has no such room.
    bool make_room(const PerSide<std::size_t>& counts);
    bool has_room() const noexcept { return file_ != nullptr; }

    /// Errors   std::system_error.
    void write(Side side, std::size_t first, std::span<const float> samples);

    /// Returns the samples as they lie in the file.
    std::span<const float> samples(Side side) const noexcept;

    /// Lets go of what `samples` has brought into memory.
    void release() const noexcept;

  private:
    struct File;
    const std::filesystem::path folder_;
    std::unique_ptr<File> file_;  // null: no room
};

}  // namespace stratus
