// The HDF5 library's objects and errors in C++.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <cstdlib>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace stratus::io::hdf5 {

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

/// The innermost error on HDF5's stack; empty if there is none.
std::string innermost_error();

/// Returns the result of a library call, or throws "HDF5 cannot TASK: reason" if it is negative.
template <class Result>
Result checked(Result result, const std::string& task) {
    if (result >= 0) return result;
    const std::string reason = innermost_error();
    throw std::runtime_error("HDF5 cannot " + task + (reason.empty() ? "" : ": " + reason));
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
Handle new_dataspace(std::span<const std::size_t> extents);

/// A new file by an access property list. Its root keeps the order in which datasets and attributes
/// are made, and no times.
Handle create_file(const std::string& name, const Handle& access);

/// Names in no particular order.
std::vector<std::string> attribute_names(hid_t object);

}  // namespace stratus::io::hdf5
