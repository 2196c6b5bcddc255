#include "hdf5_parts.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <fcntl.h>
#include <iterator>
#include <limits>
#include <memory>
#include <new>
#include <string>

namespace stratus::io::hdf5 {
namespace {

constexpr unsigned creation_order = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;

/// Appends a name to the list `names`; HDF5 stops iterating when it returns nonzero.
herr_t append_name(hid_t, const char* name, const H5A_info_t*, void* names) noexcept {
    try {
        static_cast<std::vector<std::string>*>(names)->emplace_back(name);
        return 0;
    } catch (const std::bad_alloc&) {
        return -1;
    }
}

}  // namespace

std::string innermost_error() {
    std::string reason;
    const auto innermost = [](unsigned number, const H5E_error2_t* error, void* text) -> herr_t {
        if (number == 0 && error->desc) *static_cast<std::string*>(text) = error->desc;
        return 0;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, innermost, &reason);
    return reason;
}

Handle new_property_list(hid_t kind) {
    return {H5Pcreate(kind), H5Pclose, "create a property list"};
}

Handle new_dataspace(std::span<const std::size_t> extents) {
    const std::vector<hsize_t> sizes(extents.begin(), extents.end());
    return {H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr), H5Sclose,
            "create a dataspace"};
}

Handle new_dataset(hid_t file, const std::string& name, hid_t stored,
                   std::span<const std::size_t> extents, bool in_chunks) {
    const Handle space = new_dataspace(extents);
    const Handle creation = new_property_list(H5P_DATASET_CREATE);
    checked(H5Pset_obj_track_times(creation, false), "leave out times");
    checked(H5Pset_attr_creation_order(creation, creation_order), "track the order of attributes");
    if (in_chunks) set_chunks(creation, extents);
    return {H5Dcreate2(file, name.c_str(), stored, space, H5P_DEFAULT, creation, H5P_DEFAULT),
            H5Dclose, "write dataset " + name};
}

std::vector<std::string> attribute_names(hid_t object) {
    std::vector<std::string> names;
    checked(H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, append_name, &names),
            "list the attributes");
    return names;
}

// ---- files

namespace {

// HDF5's memory driver reads directly from bytes that outlive the file: nothing is copied. Closing a
// file closes all objects, also those that the library forgot where the file is damaged.

/// The driver takes the bytes for memory that it allocated.
Handle access_to(void* bytes) {
    using Operation = H5FD_file_image_op_t;
    Handle access = new_property_list(H5P_FILE_ACCESS);
    H5FD_file_image_callbacks_t callbacks{
        [](size_t, Operation, void* image) { return image; },
        [](void* to, const void*, size_t, Operation, void*) { return to; },
        [](void*, size_t, Operation, void*) -> void* { return nullptr; },  // nothing is written
        [](void*, Operation, void*) -> herr_t { return 0; },
        [](void* image) { return image; },
        [](void*) -> herr_t { return 0; },
        bytes};
    checked(H5Pset_fapl_core(access, 1, false), "use its memory driver");
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

Handle open_file(const Bytes& bytes) {
    char* const image = const_cast<char*>(bytes.data());  // only read
    const Handle access = access_to(image);
    checked(H5Pset_file_image(access, image, bytes.size()), "use its memory driver");
    return {H5Fopen(name_in_memory().c_str(), H5F_ACC_RDONLY, access), H5Fclose, "open the file"};
}

namespace {

/// The file of the system, and what went wrong with it. Once that is known all that HDF5 writes is
/// dropped, so that it can close its file.
struct Output {
    explicit Output(const std::filesystem::path& path)
        : descriptor(path, O_RDWR | O_CREAT | O_TRUNC) {}

    /// Whether work() succeeds, which is not tried after a failure.
    template <class Work>
    bool attempt(const Work& work) {
        if (failure) return false;
        try {
            work();
        } catch (...) {
            failure = std::current_exception();
        }
        return !failure;
    }

    Descriptor descriptor;
    haddr_t end = 0;
    std::exception_ptr failure;
};

/// An open file as HDF5 holds it and gives it to the functions below.
struct OpenFile : H5FD_t {
    explicit OpenFile(std::shared_ptr<Output> output_) : H5FD_t{}, output(std::move(output_)) {}

    std::shared_ptr<Output> output;
    haddr_t allocated = 0;
};

OpenFile& of(H5FD_t* file) { return *static_cast<OpenFile*>(file); }
const OpenFile& of(const H5FD_t* file) { return *static_cast<const OpenFile*>(file); }

/// The property list tells the driver which file it is.
H5FD_t* open_output(const char*, unsigned, hid_t access, haddr_t) {
    const auto* const output =
        static_cast<const std::shared_ptr<Output>*>(H5Pget_driver_info(access));
    return new (std::nothrow) OpenFile(*output);
}

herr_t close_output(H5FD_t* file) {
    delete &of(file);
    return 0;
}

void* copy_of_output(const void* output) {
    return new (std::nothrow)
        std::shared_ptr<Output>(*static_cast<const std::shared_ptr<Output>*>(output));
}

herr_t forget_output(void* output) {
    delete static_cast<std::shared_ptr<Output>*>(output);
    return 0;
}

/// HDF5's memory driver has these features too.
herr_t features(const H5FD_t*, unsigned long* flags) {
    if (flags)
        *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA |
                 H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_AGGREGATE_SMALLDATA;
    return 0;
}

haddr_t allocated(const H5FD_t* file, H5FD_mem_t) { return of(file).allocated; }

herr_t allocate(H5FD_t* file, H5FD_mem_t, haddr_t end) {
    of(file).allocated = end;
    return 0;
}

haddr_t written(const H5FD_t* file, H5FD_mem_t) { return of(file).output->end; }

herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, size_t size, void* bytes) {
    Output& output = *of(file).output;
    const bool done = output.attempt([&] {
        output.descriptor.read_at(at, {static_cast<char*>(bytes), size});
    });
    return done ? 0 : -1;
}

herr_t write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, size_t size, const void* bytes) {
    Output& output = *of(file).output;
    output.attempt([&] {
        output.descriptor.write_at(at, {static_cast<const char*>(bytes), size});
    });
    output.end = std::max(output.end, at + size);
    return 0;
}

herr_t end_where_allocated(H5FD_t* file, hid_t, hbool_t) {
    Output& output = *of(file).output;
    output.attempt([&] { output.descriptor.resize(of(file).allocated); });
    output.end = of(file).allocated;
    return 0;
}

hid_t driver() {
    static const hid_t registered = [] {
        H5FD_class_t functions{};
        functions.name = "stratus";
        functions.maxaddr = std::numeric_limits<haddr_t>::max() / 2;
        functions.fc_degree = H5F_CLOSE_STRONG;
        functions.fapl_size = sizeof(std::shared_ptr<Output>);
        functions.fapl_copy = copy_of_output;
        functions.fapl_free = forget_output;
        functions.open = open_output;
        functions.close = close_output;
        functions.query = features;
        functions.get_eoa = allocated;
        functions.set_eoa = allocate;
        functions.get_eof = written;
        functions.read = read;
        functions.write = write;
        functions.truncate = end_where_allocated;
        constexpr H5FD_mem_t same[] = H5FD_FLMAP_DICHOTOMY;
        std::copy(std::begin(same), std::end(same), functions.fl_map);
        return H5FDregister(&functions);
    }();
    return checked(registered, "use a driver");
}

/// A new file of the driver. Its root keeps the order in which datasets and attributes are made, and
/// no times.
Handle create_file(const std::string& name, const Handle& access) {
    checked(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110),
            "choose the format version");
    const Handle creation = new_property_list(H5P_FILE_CREATE);
    checked(H5Pset_link_creation_order(creation, creation_order), "track the order of datasets");
    checked(H5Pset_attr_creation_order(creation, creation_order), "track the order of attributes");
    checked(H5Pset_obj_track_times(creation, false), "leave out times");
    return {H5Fcreate(name.c_str(), H5F_ACC_TRUNC, creation, access), H5Fclose, "create the file"};
}

}  // namespace

void write_file(const std::filesystem::path& path, const std::function<void(hid_t file)>& fill) {
    const auto output = std::make_shared<Output>(path);
    try {
        const Handle access = new_property_list(H5P_FILE_ACCESS);
        checked(H5Pset_driver(access, driver(), &output), "use a driver");
        Handle file = create_file(path.string(), access);
        fill(file);
        file.close("finish the file");
    } catch (...) {
        if (!output->failure) throw;
    }
    if (output->failure) std::rethrow_exception(output->failure);
    output->descriptor.close();
}

}  // namespace stratus::io::hdf5
