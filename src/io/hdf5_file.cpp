#include "hdf5_parts.h"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <fcntl.h>
#include <iterator>
#include <limits>
#include <memory>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus::io::hdf5 {
namespace {

constexpr unsigned creation_order = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;

}  // namespace

void fail(const std::string& task) {
    std::string reason;
    const auto innermost = [](unsigned number, const H5E_error2_t* error, void* text) -> herr_t {
        if (number == 0 && error->desc) *static_cast<std::string*>(text) = error->desc;
        return 0;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, innermost, &reason);
    throw std::runtime_error("HDF5 cannot " + task + (reason.empty() ? "" : ": " + reason));
}

Handle new_property_list(hid_t kind) {
    return {H5Pcreate(kind), H5Pclose, "create a property list"};
}

Handle new_dataspace(Extents extents) {
    const std::vector<hsize_t> sizes(extents.begin(), extents.end());
    return {H5Screate_simple(int_size(sizes), sizes.data(), nullptr), H5Sclose,
            "create a dataspace"};
}

Handle new_dataset(hid_t file, const std::string& name, hid_t stored, Extents extents,
                   bool in_chunks) {
    const Handle space = new_dataspace(extents);
    const Handle creation = new_property_list(H5P_DATASET_CREATE);
    checked(H5Pset_obj_track_times(creation, false), "leave out times");
    checked(H5Pset_attr_creation_order(creation, creation_order), "track the order of attributes");
    if (in_chunks) set_chunks(creation, extents);
    return {H5Dcreate2(file, name.c_str(), stored, space, H5P_DEFAULT, creation, H5P_DEFAULT),
            H5Dclose, "write dataset " + name};
}

// ---- files

namespace {

/// Where an HDF5 file lies, and what went wrong with it. Once that is known all that HDF5 writes is
/// dropped, so that it can close its file.
struct Storage {
    explicit Storage(const fs::path& path) : output(Descriptor(path, O_RDWR | O_CREAT | O_TRUNC)) {}
    explicit Storage(const Bytes& bytes) : input(bytes), end(bytes.size()) {}

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

    void read_at(haddr_t at, std::span<char> bytes) const {
        if (output) return output->read_at(at, bytes);
        const std::span<const char> rest = input.subspan(std::min<haddr_t>(at, input.size()));
        const std::size_t held = std::min(bytes.size(), rest.size());
        std::fill(std::copy_n(rest.begin(), held, bytes.begin()), bytes.end(), '\0');
    }

    std::optional<Descriptor> output;  // a file of the system
    std::span<const char> input;       // or bytes, which are only read
    haddr_t end = 0, allocated = 0;
    std::exception_ptr failure;
};

/// An open file as HDF5 holds it and gives it to the functions below.
struct OpenFile : H5FD_t {
    std::shared_ptr<Storage> storage;
};

Storage& opened(const H5FD_t* file) { return *static_cast<const OpenFile*>(file)->storage; }

/// The property list tells the driver which file it is.
H5FD_t* open_storage(const char*, unsigned, hid_t access, haddr_t) {
    const auto* const storage =
        static_cast<const std::shared_ptr<Storage>*>(H5Pget_driver_info(access));
    return new (std::nothrow) OpenFile{{}, *storage};
}

herr_t close_storage(H5FD_t* file) {
    delete static_cast<OpenFile*>(file);
    return 0;
}

void* copy_of_storage(const void* storage) {
    return new (std::nothrow)
        std::shared_ptr<Storage>(*static_cast<const std::shared_ptr<Storage>*>(storage));
}

herr_t forget_storage(void* storage) {
    delete static_cast<std::shared_ptr<Storage>*>(storage);
    return 0;
}

/// HDF5's memory driver has these features too.
herr_t features(const H5FD_t*, unsigned long* flags) {
    if (flags)
        *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA |
                 H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_AGGREGATE_SMALLDATA;
    return 0;
}

haddr_t allocated(const H5FD_t* file, H5FD_mem_t) { return opened(file).allocated; }

herr_t allocate(H5FD_t* file, H5FD_mem_t, haddr_t end) {
    opened(file).allocated = end;
    return 0;
}

haddr_t written(const H5FD_t* file, H5FD_mem_t) { return opened(file).end; }

herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, size_t size, void* bytes) {
    Storage& storage = opened(file);
    const bool done = storage.attempt([&] {
        storage.read_at(at, {static_cast<char*>(bytes), size});
    });
    return done ? 0 : -1;
}

herr_t write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, size_t size, const void* bytes) {
    Storage& storage = opened(file);
    storage.attempt([&] {
        storage.output.value().write_at(at, {static_cast<const char*>(bytes), size});
    });
    storage.end = std::max(storage.end, at + size);
    return 0;
}

herr_t end_where_allocated(H5FD_t* file, hid_t, hbool_t) {
    Storage& storage = opened(file);
    storage.attempt([&] { storage.output.value().resize(storage.allocated); });
    storage.end = storage.allocated;
    return 0;
}

hid_t driver() {
    static const hid_t registered = [] {
        H5FD_class_t functions{};
        functions.name = "stratus";
        functions.maxaddr = std::numeric_limits<haddr_t>::max() / 2;
        functions.fc_degree = H5F_CLOSE_STRONG;  // objects, too, that HDF5 forgot in a damaged file
        functions.fapl_size = sizeof(std::shared_ptr<Storage>);
        functions.fapl_copy = copy_of_storage;
        functions.fapl_free = forget_storage;
        functions.open = open_storage;
        functions.close = close_storage;
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

/// A property list with which HDF5 opens files of the driver in `storage`.
Handle access_to(const std::shared_ptr<Storage>& storage) {
    Handle access = new_property_list(H5P_FILE_ACCESS);
    checked(H5Pset_driver(access, driver(), &storage), "use a driver");
    return access;
}

/// A new file. Its root keeps the order in which datasets and attributes are made, and no times.
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

Handle open_file(const Bytes& bytes) {
    const Handle access = access_to(std::make_shared<Storage>(bytes));
    return {H5Fopen("table", H5F_ACC_RDONLY, access), H5Fclose, "open the file"};
}

void write_file(const fs::path& path, const std::function<void(hid_t file)>& fill) {
    const auto storage = std::make_shared<Storage>(path);
    try {
        Handle file = create_file(path.string(), access_to(storage));
        fill(file);
        file.close("finish the file");
    } catch (...) {
        if (!storage->failure) throw;
    }
    if (storage->failure) std::rethrow_exception(storage->failure);
    storage->output->close();
}

namespace {

/// The attribute that netCDF-4 writes about itself.
constexpr const char* netcdf_properties = "_NCProperties";

void write_attribute(hid_t object, const std::string& name, hid_t stored_type, hid_t memory_type,
                     hid_t space, const void* data) {
    const std::string task = "write attribute " + name;
    const Handle attribute(
        H5Acreate2(object, name.c_str(), stored_type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
        task);
    checked(H5Awrite(attribute, memory_type, data), task);
}

Handle new_scalar() { return {H5Screate(H5S_SCALAR), H5Sclose, "create a dataspace"}; }

/// A fixed-length string type, of one zero byte for an empty text: HDF5 has no strings of length 0.
Handle text_type(std::size_t length) {
    const char* const task = "create a string type";
    Handle type(H5Tcopy(H5T_C_S1), H5Tclose, task);
    checked(H5Tset_size(type, std::max<std::size_t>(length, 1)), task);
    checked(H5Tset_strpad(type, H5T_STR_NULLPAD), task);
    checked(H5Tset_cset(type, H5T_CSET_UTF8), task);
    return type;
}

void write_entry(hid_t object, const std::string& name, const std::string& text) {
    const MetadataEntry::Type type = entry_type(name);
    if (type == MetadataEntry::text) return write_text(object, name, text);
    if (type == MetadataEntry::integer) {
        const int value = to_integer(name, text);
        return write_attribute(object, name, H5T_STD_I32LE, H5T_NATIVE_INT, new_scalar(), &value);
    }
    const std::vector<double> values = to_numbers(name, text);
    const std::size_t count = values.size();
    write_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                    type == MetadataEntry::number ? new_scalar() : new_dataspace({&count, 1}),
                    values.data());
}

/// Returns the size of an attribute, which must not exceed its file.
std::size_t checked_size(hid_t attribute, std::size_t element_size, const std::string& name) {
    const std::string task = "read attribute " + name;
    const Handle space(H5Aget_space(attribute), H5Sclose, task);
    const Handle file(H5Iget_file_id(attribute), H5Fclose, task);
    const std::size_t count = size(checked(H5Sget_simple_extent_npoints(space), task));
    hsize_t file_size = 0;
    checked(H5Fget_filesize(file, &file_size), task);
    if (element_size == 0 || count > file_size / element_size)
        throw std::runtime_error("attribute " + shown_text(name) + " is larger than the file");
    return count;
}

/// A text of fixed or variable length.
std::string read_string(hid_t attribute, hid_t type, const std::string& name) {
    const std::string task = "read attribute " + name;
    if (H5Tis_variable_str(type) > 0) {
        char* text = nullptr;
        checked(H5Aread(attribute, type, &text), task);
        const std::unique_ptr<char, herr_t (*)(void*)> owner(text, H5free_memory);
        return text ? text : "";
    }
    std::string text(H5Tget_size(type), '\0');
    checked(H5Aread(attribute, type, text.data()), task);
    text.erase(std::min(text.find('\0'), text.size()));
    if (H5Tget_strpad(type) == H5T_STR_SPACEPAD) text.erase(text.find_last_not_of(' ') + 1);
    return text;
}

template <class Number>
std::vector<Number> read_numbers(hid_t attribute, hid_t memory_type, std::size_t count,
                                 const std::string& name) {
    std::vector<Number> values(count);
    checked(H5Aread(attribute, memory_type, values.data()), "read attribute " + name);
    return values;
}

/// An attribute as text, of whatever type a program made it that rewrote the file; nothing if it is
/// neither text nor numbers.
std::optional<std::string> read_attribute(hid_t object, const std::string& name) {
    const std::string task = "read attribute " + name;
    const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, task);
    const Handle type(H5Aget_type(attribute), H5Tclose, task);
    const std::size_t count = checked_size(attribute, H5Tget_size(type), name);
    switch (H5Tget_class(type)) {
        case H5T_STRING:
            if (count > 1) return std::nullopt;
            return count == 0 ? "" : read_string(attribute, type, name);
        case H5T_INTEGER: {
            std::string text;
            for (const long long value :
                 read_numbers<long long>(attribute, H5T_NATIVE_LLONG, count, name)) {
                if (!text.empty()) text += ' ';
                text += std::to_string(value);
            }
            return text;
        }
        case H5T_FLOAT:
            return to_text(read_numbers<double>(attribute, H5T_NATIVE_DOUBLE, count, name));
        default: return std::nullopt;
    }
}

/// Appends a name to the list `names`; HDF5 stops iterating when it returns nonzero.
herr_t append_name(hid_t, const char* name, const H5A_info_t*, void* names) noexcept {
    try {
        static_cast<std::vector<std::string>*>(names)->emplace_back(name);
        return 0;
    } catch (const std::bad_alloc&) {
        return -1;
    }
}

/// Names in no particular order.
std::vector<std::string> attribute_names(hid_t object) {
    std::vector<std::string> names;
    checked(H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, append_name, &names),
            "list the attributes");
    return names;
}

/// The entries whose names stand in `checksum_covers`, itself included, and what else has a meaning;
/// all of a file that was written before there was a `checksum_covers`.
Metadata covered(const Metadata& metadata) {
    const auto names = metadata.find(checksum_covers);
    if (names == metadata.end()) return metadata;
    Metadata covered{*names};
    std::istringstream lines(names->second);
    for (std::string name; std::getline(lines, name);)
        if (const auto found = metadata.find(name); found != metadata.end()) covered.insert(*found);
    for (const auto& entry : metadata)
        if (is_of_the_format(entry.first)) covered.insert(entry);
    return covered;
}

}  // namespace

void write_text(hid_t object, const std::string& name, const std::string& text) {
    const Handle type = text_type(text.size());
    write_attribute(object, name, type, type, new_scalar(), text.c_str());
}

std::optional<std::string> read_text(hid_t object, const std::string& name) {
    if (!checked(H5Aexists(object, name.c_str()), "list the attributes")) return std::nullopt;
    return read_attribute(object, name);
}

void write_metadata(hid_t file, Metadata metadata) {
    std::string names;
    for (const auto& [name, text] : metadata) names += name + '\n';
    metadata[checksum_covers] = names;
    for (const auto& [name, text] : metadata) write_entry(file, name, text);
    write_text(file, checksum_name, checksum(metadata));
}

Metadata read_metadata(hid_t file, bool ignore_checksums) {
    Metadata metadata;
    for (const std::string& name : attribute_names(file))
        if (const auto text = read_attribute(file, name); text && name != netcdf_properties)
            metadata[name] = *text;
    check_format(metadata);
    const auto stored = take(metadata, checksum_name);
    if (!ignore_checksums) check_checksum("the metadata", stored, checksum(covered(metadata)));
    metadata.erase(checksum_covers);
    return metadata;
}

}  // namespace stratus::io::hdf5
