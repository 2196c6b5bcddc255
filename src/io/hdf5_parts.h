// The HDF5 library as tables and grids are written and read with it: its objects and errors in C++, files in
// memory and on the disk, attributes, chunks.
#pragma once

#include "table_content.h"

#include <hdf5.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace stratus::io::hdf5 {

// ---- objects and errors

/// Keeps HDF5 from printing its errors during its scope.
class QuietErrors {
  public:
    QuietErrors() {
        H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
        // At exit it would complain of memory that it lost while it refused a damaged file.
        [[maybe_unused]] static const int registered =
            std::atexit([] { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); });
    }
    ~QuietErrors() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
    QuietErrors(const QuietErrors&) = delete;
    QuietErrors& operator=(const QuietErrors&) = delete;

  private:
    H5E_auto2_t print_ = nullptr;
    void* data_ = nullptr;
};

/// Throws "HDF5 cannot TASK: reason", the innermost error on HDF5's stack if there is one.
[[noreturn]] void fail(const std::string& task);

/// Returns the result of a library call, or fails if it is negative.
template <class Result>
Result checked(Result result, const std::string& task) {
    if (result < 0) fail(task);
    return result;
}

/// An open object of the library, closed at the end of its scope.
class Handle {
  public:
    using Close = herr_t (*)(hid_t);

    Handle(hid_t id, Close close, const std::string& task)
        : id_(checked(id, task)), close_(close) {}
    Handle(Handle&& other) noexcept
        : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
    ~Handle() {
        if (id_ >= 0) close_(id_);
    }
    Handle& operator=(Handle&&) = delete;

    operator hid_t() const noexcept { return id_; }

    /// Closes it now and reports failure, unlike the destructor.
    void close(const std::string& task) {
        checked(close_(std::exchange(id_, H5I_INVALID_HID)), task);
    }

  private:
    hid_t id_;
    Close close_;
};

Handle new_property_list(hid_t kind);
Handle new_dataspace(Extents extents);

/// A new dataset, which keeps the order of its attributes, and no times.
Handle new_dataset(hid_t file, const std::string& name, hid_t stored, Extents extents,
                   bool in_chunks = false);

// ---- files: through a driver of our own. They are read in memory, so that only the system can fail on the disk
// (file_bytes.h); what is written can be larger than memory, and where the system fails it says why, not HDF5

/// Opens the file in `bytes`, which must outlive it, for reading.
Handle open_file(const Bytes& bytes);

/// Makes `path` an HDF5 file with what fill(file) puts into it.
///
/// Errors   std::system_error from the system; what `fill` throws.
void write_file(const fs::path& path, const std::function<void(hid_t file)>& fill);

// ---- attributes: the metadata of a table, on the root, and texts on its datasets

void write_text(hid_t object, const std::string& name, const std::string& text);

/// The attribute `name` of an object, as text if it is numbers; nothing if it is missing or neither.
std::optional<std::string> read_text(hid_t object, const std::string& name);

/// Writes each entry as an attribute of its type, their names, and the checksum of all.
void write_metadata(hid_t file, Metadata metadata);

/// All attributes that are text or numbers, of whatever type another program made them. The checksum
/// covers those that were there when it was written.
///
/// Errors   std::runtime_error for another format or version; NotAsSealed for another checksum.
Metadata read_metadata(hid_t file, bool ignore_checksums);

// ---- chunks

// Chunks are shuffled and deflated here, with libdeflate, which takes half the time of HDF5's own filters and
// makes smaller files. Any HDF5 reads them.

/// Makes a dataset over `extents` chunked, shuffled and deflated.
void set_chunks(hid_t creation, Extents extents);

/// Lets go of samples on the disk that have been brought into memory.
void release_samples(const WriteOptions& options);

/// Writes all chunks of a dataset from `values`, which has the size of its extents.
///
/// Threads  as many deflate as `options` say; one at a time calls HDF5; the file is the same for any
///          number of them.
/// Errors   std::runtime_error for a chunk that HDF5 cannot write.
void write_chunks(hid_t dataset, const std::string& name, Extents extents,
                  std::span<const float> values, const WriteOptions& options);

}  // namespace stratus::io::hdf5
