#include "hdf5_memory_file.h"

#include <atomic>
#include <cstddef>
#include <cstring>
#include <new>
#include <string>

namespace stratus::io::hdf5 {
namespace {

// HDF5's memory driver works directly on a `Bytes` that outlives the file: nothing is copied, and
// it holds the finished file once that is closed. (H5Fget_file_image would leave a superblock with
// a wrong checksum.) Closing a file closes all objects, also those that the library forgot where the
// file is damaged.

void* image_allocate(size_t size, H5FD_file_image_op_t, void* image) {
    Bytes& bytes = *static_cast<Bytes*>(image);
    try {
        if (size > bytes.size()) bytes.resize(size);
    } catch (const std::bad_alloc&) {
        return nullptr;
    }
    return bytes.data();
}

void* image_copy(void* to, const void* from, size_t size, H5FD_file_image_op_t, void*) {
    return to == from ? to : std::memcpy(to, from, size);
}

void* image_grow(void*, size_t size, H5FD_file_image_op_t operation, void* image) {
    return image_allocate(size, operation, image);
}

herr_t image_keep(void*, H5FD_file_image_op_t, void*) { return 0; }
void* image_owner(void* image) { return image; }
herr_t image_disown(void*) { return 0; }

Handle access_to(Bytes& bytes) {
    constexpr size_t increment = 1;  // so that the buffer ends where the file ends
    Handle access = new_property_list(H5P_FILE_ACCESS);
    H5FD_file_image_callbacks_t callbacks{image_allocate, image_copy,   image_grow, image_keep,
                                          image_owner,    image_disown, &bytes};
    checked(H5Pset_fapl_core(access, increment, false), "use its memory driver");
    checked(H5Pset_file_image_callbacks(access, &callbacks), "use its memory driver");
    checked(H5Pset_fclose_degree(access, H5F_CLOSE_STRONG), "use its memory driver");
    return access;
}

/// A new name for each file: HDF5 tells open files apart by their names. No file on disk can have
/// this one.
std::string name_in_memory() {
    static std::atomic<unsigned long> counter{0};
    return "/dev/null/" + std::to_string(counter++);
}

}  // namespace

Handle create_file(Bytes& bytes) { return create_file(name_in_memory(), access_to(bytes)); }

Handle open_file(const Bytes& bytes) {
    Bytes& image = const_cast<Bytes&>(bytes);  // only read
    const Handle access = access_to(image);
    checked(H5Pset_file_image(access, image.data(), image.size()), "use its memory driver");
    return {H5Fopen(name_in_memory().c_str(), H5F_ACC_RDONLY, access), H5Fclose, "open the file"};
}

}  // namespace stratus::io::hdf5
