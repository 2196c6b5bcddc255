#include "hdf5_memory_file.h"

#include "hdf5_structures.h"

#include <atomic>
#include <cstddef>
#include <cstring>
#include <limits>
#include <new>
#include <string>

namespace stratus::io::hdf5 {
namespace {

// --- Writing ---

// HDF5's memory driver works directly on a `Bytes` that outlives the file: nothing is copied, and
// it holds the finished file once that is closed. (H5Fget_file_image would leave a superblock with
// a wrong checksum.)

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

Handle write_access(Bytes& bytes) {
    constexpr size_t increment = 1;  // so that the buffer ends where the file ends
    Handle access = new_property_list(H5P_FILE_ACCESS);
    H5FD_file_image_callbacks_t callbacks{image_allocate, image_copy,   image_grow, image_keep,
                                          image_owner,    image_disown, &bytes};
    checked(H5Pset_fapl_core(access, increment, false), "use its memory driver");
    checked(H5Pset_file_image_callbacks(access, &callbacks), "use its memory driver");
    checked(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110),
            "choose the format version");
    return access;
}

/// A new name for each file: HDF5 tells open files apart by their names. No file on disk can have
/// this one.
std::string name_in_memory() {
    static std::atomic<unsigned long> counter{0};
    return "/dev/null/" + std::to_string(counter++);
}

// --- Reading ---

// A driver of our own that never changes the bytes and reads nothing outside the file. HDF5 puts a
// buffer in front of its own drivers and extends it by any size that a forged file names; it does
// not do so here.

struct BytesFile : H5FD_t {
    explicit BytesFile(const Bytes& file) : H5FD_t{}, bytes(file), structures(file) {}

    const Bytes& bytes;
    Hdf5Structures structures;
    haddr_t end_of_addresses = 0;  // set and asked for by the library
};

H5FD_t* bytes_open(const char*, unsigned, hid_t access, haddr_t) {
    return new (std::nothrow)
        BytesFile(**static_cast<const Bytes* const*>(H5Pget_driver_info(access)));
}

herr_t bytes_close(H5FD_t* file) {
    delete static_cast<BytesFile*>(file);
    return 0;
}

haddr_t bytes_end_of_addresses(const H5FD_t* file, H5FD_mem_t) {
    return static_cast<const BytesFile*>(file)->end_of_addresses;
}

herr_t bytes_set_end_of_addresses(H5FD_t* file, H5FD_mem_t, haddr_t address) {
    static_cast<BytesFile*>(file)->end_of_addresses = address;
    return 0;
}

haddr_t bytes_end_of_file(const H5FD_t* file, H5FD_mem_t) {
    return static_cast<const BytesFile*>(file)->bytes.size();
}

herr_t bytes_read(H5FD_t* file, H5FD_mem_t kind, hid_t, haddr_t address, size_t size, void* to) {
    auto& reading = *static_cast<BytesFile*>(file);
    const Bytes& bytes = reading.bytes;
    if (const char* const reason = reading.structures.refusal(kind, address, size)) {
        H5Epush2(H5E_DEFAULT, __FILE__, __func__, __LINE__, H5E_ERR_CLS, H5E_FILE, H5E_READERROR,
                 "%s", reason);
        return -1;
    }
    if (address > bytes.size() || size > bytes.size() - address) return -1;
    std::memcpy(to, bytes.data() + address, size);
    return 0;
}

herr_t bytes_write(H5FD_t*, H5FD_mem_t, hid_t, haddr_t, size_t, const void*) { return -1; }

}  // namespace

Handle create_file(Bytes& bytes) {
    constexpr unsigned ordered = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
    const Handle access = write_access(bytes);
    const Handle creation = new_property_list(H5P_FILE_CREATE);
    checked(H5Pset_link_creation_order(creation, ordered), "track the order of datasets");
    checked(H5Pset_attr_creation_order(creation, ordered), "track the order of attributes");
    checked(H5Pset_obj_track_times(creation, false), "leave out times");
    return {H5Fcreate(name_in_memory().c_str(), H5F_ACC_TRUNC, creation, access), H5Fclose,
            "create the file"};
}

Handle register_driver() {
    H5FD_class_t driver{};
    driver.name = "stratus-bytes";
    driver.maxaddr = std::numeric_limits<std::ptrdiff_t>::max();
    driver.fc_degree = H5F_CLOSE_STRONG;
    driver.fapl_size = sizeof(const Bytes*);
    driver.open = bytes_open;
    driver.close = bytes_close;
    driver.get_eoa = bytes_end_of_addresses;
    driver.set_eoa = bytes_set_end_of_addresses;
    driver.get_eof = bytes_end_of_file;
    driver.read = bytes_read;
    driver.write = bytes_write;
    return {H5FDregister(&driver), H5FDunregister, "register a driver"};
}

Handle open_file(hid_t driver, const Bytes& bytes) {
    const Handle access = new_property_list(H5P_FILE_ACCESS);
    const Bytes* const from = &bytes;
    checked(H5Pset_driver(access, driver, &from), "use the driver");
    return {H5Fopen("table", H5F_ACC_RDONLY, access), H5Fclose, "open the file"};
}

}  // namespace stratus::io::hdf5
