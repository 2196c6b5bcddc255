// Damage is noticed three times. A seal at the file's end, where HDF5 does not look, covers all
// bytes before it. Every structure within is of the kind that HDF5 1.10 brought, because those
// carry checksums, which are compared before the library follows a pointer, even in a file whose
// seal another program has cut off. The checksums of samples and metadata go with them wherever
// they are copied.
//
// Forgery, structures made up together with all checksums, is met before the library decodes them:
// HDF5 1.10 believes what it reads and can crash on it (hdf5_structures.h).
#include "hdf5_structures.h"
#include "table_content.h"

#include <hdf5.h>
#include <hdf5_hl.h>
#include <libdeflate.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

namespace stratus::io {
namespace {

constexpr unsigned deflate_level = 4;
constexpr std::size_t target_chunk_bytes = std::size_t{1} << 19;

/// Most samples that an axis may have; far more than any table, far less than what would hurt.
constexpr std::size_t longest_axis = 1 << 20;

/// Most chunks that a dataset may have: what 8 GiB take, which is the most that one may hold. HDF5
/// goes through all of them to find one.
constexpr std::size_t max_chunks = 1 << 15;

// --- The C library's objects and errors ---

/// Keeps HDF5 from printing its errors, for as long as this lives.
class QuietErrors {
  public:
    QuietErrors() {
        H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    }
    ~QuietErrors() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
    QuietErrors(const QuietErrors&) = delete;
    QuietErrors& operator=(const QuietErrors&) = delete;

  private:
    H5E_auto2_t print_ = nullptr;
    void* data_ = nullptr;
};

/// What HDF5 says went wrong, at its innermost.
std::string library_reason() {
    std::string reason;
    const auto innermost = [](unsigned number, const H5E_error2_t* error, void* text) -> herr_t {
        if (number == 0 && error->desc) *static_cast<std::string*>(text) = error->desc;
        return 0;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, innermost, &reason);
    return reason;
}

/// Throws "HDF5 cannot TASK: reason" unless the library's answer is one of success; hands it on
/// otherwise.
template <class Answer>
Answer checked(Answer answer, const std::string& task) {
    if (answer >= 0) return answer;
    const std::string reason = library_reason();
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

    /// Closes now, where failing to matters.
    void close(const std::string& task) {
        checked(close_(std::exchange(id_, H5I_INVALID_HID)), task);
    }

  private:
    hid_t id_;
    Close close_;
};

Handle new_properties(hid_t kind) { return {H5Pcreate(kind), H5Pclose, "make a property list"}; }

Handle new_space(std::span<const std::size_t> extents) {
    const std::vector<hsize_t> sizes(extents.begin(), extents.end());
    return {H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr), H5Sclose,
            "make a dataspace"};
}

// --- A file in memory, to write ---

// HDF5's memory driver works directly on a `Bytes` that outlives the file: it is never copied, and
// holds the finished file once that is closed. (H5Fget_file_image would leave a superblock with a
// wrong checksum.)

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

/// Properties of a file that is to lie in `bytes`.
Handle access_to_write(Bytes& bytes) {
    constexpr size_t increment = 1;  // the file ends where the bytes end
    Handle access = new_properties(H5P_FILE_ACCESS);
    H5FD_file_image_callbacks_t callbacks{image_allocate, image_copy,   image_grow, image_keep,
                                          image_owner,    image_disown, &bytes};
    checked(H5Pset_fapl_core(access, increment, false), "use its memory driver");
    checked(H5Pset_file_image_callbacks(access, &callbacks), "use its memory driver");
    checked(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110), "choose its version");
    return access;
}

/// HDF5 wants a name for every file and tells open files apart by it: one that nothing on the disk
/// can have, and that no other file in memory had.
std::string name_in_memory() {
    static std::atomic<unsigned long> counter{0};
    return "/dev/null/" + std::to_string(counter++);
}

/// An empty file whose root remembers the order in which things were made and no times.
Handle create_file(Bytes& bytes) {
    constexpr unsigned ordered = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
    const Handle access = access_to_write(bytes);
    const Handle creation = new_properties(H5P_FILE_CREATE);
    checked(H5Pset_link_creation_order(creation, ordered), "track the order of datasets");
    checked(H5Pset_attr_creation_order(creation, ordered), "track the order of attributes");
    checked(H5Pset_obj_track_times(creation, false), "leave out times");
    return {H5Fcreate(name_in_memory().c_str(), H5F_ACC_TRUNC, creation, access), H5Fclose,
            "create the file"};
}

// --- A file in memory, to read ---

// A driver of our own: it never changes the bytes, reads nothing that does not lie in the file, and
// has none of the buffers that HDF5 puts before its own drivers, which it extends by whatever size
// a forged file names.

struct BytesFile : H5FD_t {
    explicit BytesFile(const Bytes& file) : H5FD_t{}, bytes(file), structures(file) {}

    const Bytes& bytes;
    Hdf5Structures structures;
    haddr_t end_of_addresses = 0;  // what the library sets and asks for
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
    if (const char* const fault = reading.structures.fault(kind, address, size)) {
        H5Epush2(H5E_DEFAULT, __FILE__, __func__, __LINE__, H5E_ERR_CLS, H5E_FILE, H5E_READERROR,
                 "%s", fault);
        return -1;
    }
    if (address > bytes.size() || size > bytes.size() - address) return -1;
    std::memcpy(to, bytes.data() + address, size);
    return 0;
}

herr_t bytes_write(H5FD_t*, H5FD_mem_t, hid_t, haddr_t, size_t, const void*) { return -1; }

/// The driver, which must outlive the files that it has opened.
Handle new_driver() {
    H5FD_class_t reading{};
    reading.name = "stratus-bytes";
    reading.maxaddr = std::numeric_limits<std::ptrdiff_t>::max();
    reading.fc_degree = H5F_CLOSE_STRONG;
    reading.fapl_size = sizeof(const Bytes*);
    reading.open = bytes_open;
    reading.close = bytes_close;
    reading.get_eoa = bytes_end_of_addresses;
    reading.set_eoa = bytes_set_end_of_addresses;
    reading.get_eof = bytes_end_of_file;
    reading.read = bytes_read;
    reading.write = bytes_write;
    return {H5FDregister(&reading), H5FDunregister, "take a driver"};
}

Handle open_file(hid_t driver, const Bytes& bytes) {
    const Handle access = new_properties(H5P_FILE_ACCESS);
    const Bytes* const from = &bytes;
    checked(H5Pset_driver(access, driver, &from), "take a driver");
    return {H5Fopen("table", H5F_ACC_RDONLY, access), H5Fclose, "open the file"};
}

// --- The seal ---

// With the seal the library never sees what is damaged. Opening a file for writing removes the
// seal, which is no damage.

constexpr std::string_view seal_start = "\nstratus-table ";

std::string seal_of(std::span<const char> bytes) {
    return std::string(seal_start) + checksum(bytes) + '\n';
}

void append_seal(Bytes& bytes) {
    const std::string seal = seal_of(bytes);
    bytes.insert(bytes.end(), seal.begin(), seal.end());
}

void check_seal(std::span<const char> bytes) {
    const std::size_t length = seal_of({}).size();
    if (bytes.size() < length) return;
    const auto found = bytes.last(length);
    const std::string_view seal(found.data(), found.size());
    if (seal.starts_with(seal_start) && seal != seal_of(bytes.first(bytes.size() - length)))
        throw std::runtime_error("is damaged: its bytes are not those that were written");
}

// --- Attributes ---

void write_attribute(hid_t object, const std::string& name, hid_t stored_type, hid_t memory_type,
                     hid_t space, const void* data) {
    const std::string task = "write attribute " + name;
    const Handle attribute(
        H5Acreate2(object, name.c_str(), stored_type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
        task);
    checked(H5Awrite(attribute, memory_type, data), task);
}

/// A string type of `length` bytes, at least one: HDF5 has no empty strings but pads with zero
/// bytes.
Handle text_type(std::size_t length) {
    Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "make a text type");
    checked(H5Tset_size(type, std::max<std::size_t>(length, 1)), "make a text type");
    checked(H5Tset_strpad(type, H5T_STR_NULLPAD), "make a text type");
    checked(H5Tset_cset(type, H5T_CSET_UTF8), "make a text type");
    return type;
}

void write_text(hid_t object, const std::string& name, const std::string& text) {
    const Handle scalar(H5Screate(H5S_SCALAR), H5Sclose, "make a dataspace");
    const Handle type = text_type(text.size());
    write_attribute(object, name, type, type, scalar, text.c_str());
}

/// An entry of the metadata, typed as its kind says.
void write_entry(hid_t object, const std::string& name, const std::string& text) {
    const Handle scalar(H5Screate(H5S_SCALAR), H5Sclose, "make a dataspace");
    switch (kind_of(name)) {
        case Kind::text: return write_text(object, name, text);
        case Kind::integer: {
            const int value = to_integer(name, text);
            return write_attribute(object, name, H5T_STD_I32LE, H5T_NATIVE_INT, scalar, &value);
        }
        case Kind::number: {
            const double value = to_number(name, text);
            return write_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, scalar, &value);
        }
        case Kind::numbers: {
            const std::vector<double> values = to_numbers(name, text);
            const std::size_t count = values.size();
            return write_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                                   new_space({&count, 1}), values.data());
        }
    }
}

void write_metadata(hid_t file, const Metadata& metadata) {
    for (const auto& [name, text] : metadata) write_entry(file, name, text);
    write_text(file, checksum_name, checksum(metadata));
}

/// Reads all of an attribute whose size, `count` elements of type `memory_type`, has been checked.
template <class Values>
Values read_attribute(hid_t attribute, hid_t memory_type, Values values, const std::string& name) {
    checked(H5Aread(attribute, memory_type, values.data()), "read attribute " + name);
    return values;
}

struct Entry {
    Kind kind;
    std::string text;
};

/// An attribute of any kind that the format uses, as text.
Entry read_any(hid_t attribute, const std::string& name, const Bytes& file_bytes) {
    const std::string task = "read attribute " + name;
    const Handle type(H5Aget_type(attribute), H5Tclose, task);
    const Handle space(H5Aget_space(attribute), H5Sclose, task);
    const bool scalar = H5Sget_simple_extent_type(space) == H5S_SCALAR;
    const bool row = H5Sget_simple_extent_ndims(space) == 1;
    const std::size_t count =
        static_cast<std::size_t>(checked(H5Sget_simple_extent_npoints(space), task));
    const std::size_t size = H5Tget_size(type);
    if (size == 0 || count > file_bytes.size() / size)
        throw std::runtime_error("attribute " + name + " is larger than the file");

    if (scalar && H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0) {
        std::string text = read_attribute(attribute, type, std::string(size, '\0'), name);
        text.erase(std::min(text.find('\0'), text.size()));
        return {Kind::text, text};
    }
    if (scalar && H5Tequal(type, H5T_STD_I32LE) > 0) {
        const auto value = read_attribute(attribute, H5T_NATIVE_INT, std::array<int, 1>{}, name);
        return {Kind::integer, std::to_string(value[0])};
    }
    if ((scalar || row) && H5Tequal(type, H5T_IEEE_F64LE) > 0) {
        const auto values =
            read_attribute(attribute, H5T_NATIVE_DOUBLE, std::vector<double>(count), name);
        return {scalar ? Kind::number : Kind::numbers, to_text(values)};
    }
    throw std::runtime_error("attribute " + name + " is of a type that the format does not use");
}

std::string read_text(hid_t object, const std::string& owner, const std::string& name,
                      const Bytes& file_bytes) {
    if (!checked(H5Aexists(object, name.c_str()), "list the attributes of " + owner))
        throw std::runtime_error(owner + " lacks its attribute " + name);
    const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose,
                           "open attribute " + name);
    const Entry entry = read_any(attribute, name, file_bytes);
    if (entry.kind != Kind::text)
        throw std::runtime_error("attribute " + name + " of " + owner + " is not text");
    return entry.text;
}

// Names are asked for in whatever order they lie: to sort them the library makes lists of its own,
// which it frees unmade where a damaged file ends them early.

/// Adds a name to a list that C code hands through; not 0 when there is no memory for it.
template <class Info>
herr_t append_name(hid_t, const char* name, const Info*, void* names) noexcept {
    try {
        static_cast<std::vector<std::string>*>(names)->emplace_back(name);
        return 0;
    } catch (const std::bad_alloc&) {
        return -1;
    }
}

std::vector<std::string> attribute_names(hid_t object) {
    std::vector<std::string> names;
    checked(H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, append_name<H5A_info_t>,
                        &names),
            "list the attributes");
    return names;
}

std::vector<std::string> link_names(hid_t group) {
    std::vector<std::string> names;
    checked(
        H5Literate(group, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, append_name<H5L_info_t>, &names),
        "list the datasets");
    return names;
}

/// Format and version alone, which decide whether the rest may be looked at.
void check_format_of_file(hid_t file, const Bytes& bytes) {
    Metadata metadata;
    for (const char* name : {"format", "format_major", "format_minor"}) {
        if (!checked(H5Aexists(file, name), "list the attributes")) continue;
        const Handle attribute(H5Aopen(file, name, H5P_DEFAULT), H5Aclose, "open an attribute");
        metadata[name] = read_any(attribute, name, bytes).text;
    }
    check_format(metadata);
}

Metadata read_metadata(hid_t file, const Bytes& bytes) {
    check_format_of_file(file, bytes);
    Metadata metadata;
    for (const std::string& name : attribute_names(file)) {
        const Handle attribute(H5Aopen(file, name.c_str(), H5P_DEFAULT), H5Aclose,
                               "open an attribute");
        const Entry entry = read_any(attribute, name, bytes);
        // A newer minor version may add entries of any kind; they are kept as text.
        if (kind_of(name) != Kind::text && entry.kind != kind_of(name))
            throw std::runtime_error("attribute " + name + " is of the wrong type");
        if (!metadata.emplace(name, entry.text).second)
            throw std::runtime_error("attribute " + shown(name) + " is there twice");
    }
    take_checksum(metadata);
    return metadata;
}

// --- Datasets ---

/// What differs between the two element types of the format.
template <class Number>
struct Element;
template <>
struct Element<float> {
    static hid_t stored() { return H5T_IEEE_F32LE; }
    static hid_t memory() { return H5T_NATIVE_FLOAT; }
};
template <>
struct Element<double> {
    static hid_t stored() { return H5T_IEEE_F64LE; }
    static hid_t memory() { return H5T_NATIVE_DOUBLE; }
};

/// Extents of a chunk: as many of the fastest dimensions as fit the target whole, the next one cut
/// into even parts.
std::vector<hsize_t> chunk_extents(std::span<const std::size_t> extents) {
    std::vector<hsize_t> chunk(extents.size());
    std::size_t bytes = sizeof(float);
    for (std::size_t d = extents.size(); d-- > 0;) {
        const std::size_t fitting =
            std::clamp(target_chunk_bytes / bytes, std::size_t{1}, extents[d]);
        const std::size_t parts = (extents[d] + fitting - 1) / fitting;
        chunk[d] = (extents[d] + parts - 1) / parts;
        bytes *= chunk[d];
    }
    return chunk;
}

/// Compressed chunks for large datasets; small ones stay as they are.
Handle creation_properties(std::span<const std::size_t> extents) {
    Handle creation = new_properties(H5P_DATASET_CREATE);
    checked(H5Pset_obj_track_times(creation, false), "leave out times");
    checked(H5Pset_attr_creation_order(creation, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED),
            "track the order of attributes");
    if (extents.size() < axis_fields.size()) return creation;
    const std::vector<hsize_t> chunk = chunk_extents(extents);
    checked(H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data()), "set chunks");
    checked(H5Pset_shuffle(creation), "set a filter");
    checked(H5Pset_deflate(creation, deflate_level), "set a filter");
    return creation;
}

/// Writes a dataset over the first axes, with what describes it.
template <class Number>
Handle write_dataset(hid_t file, const std::string& name, const std::string& long_name,
                     const std::string& units, std::span<const std::size_t> extents,
                     const std::vector<Number>& values) {
    const std::string task = "write dataset " + name;
    const Handle space = new_space(extents);
    const Handle creation = creation_properties(extents);
    Handle dataset(H5Dcreate2(file, name.c_str(), Element<Number>::stored(), space, H5P_DEFAULT,
                              creation, H5P_DEFAULT),
                   H5Dclose, task);
    checked(
        H5Dwrite(dataset, Element<Number>::memory(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
        task);
    write_text(dataset, "long_name", long_name);
    write_text(dataset, "units", units);
    write_text(dataset, checksum_name, checksum(std::span(values)));
    return dataset;
}

void write_axis(hid_t file, const AxisField& field, const Axis& axis) {
    const std::size_t count = axis.values.size();
    const Handle dataset =
        write_dataset(file, field.name, field.long_name, field.units, {&count, 1}, axis.values);
    write_text(dataset, "scale", axis_scale_name(axis.scale));
    checked(H5DSset_scale(dataset, field.name), std::string("make a dimension of ") + field.name);
}

/// Names the dimensions of a dataset by the axes that it runs over, `axes` and no more than it has.
void attach_axes(hid_t file, hid_t dataset, std::span<const AxisField> axes) {
    for (std::size_t d = 0; d < axes.size(); ++d) {
        const std::string task = std::string("attach axis ") + axes[d].name;
        const Handle axis(H5Dopen2(file, axes[d].name, H5P_DEFAULT), H5Dclose, task);
        checked(H5DSattach_scale(dataset, axis, static_cast<unsigned>(d)), task);
    }
}

/// Whether a dataset lies in chunks; otherwise its bytes lie as they are, in the file itself: what
/// lies in other files is refused before (hdf5_structures.h).
bool is_chunked(hid_t creation, const std::string& name) {
    return checked(H5Pget_layout(creation), "look at " + shown(name)) == H5D_CHUNKED;
}

/// Only the filters that this format uses are run on a file's bytes, and none twice.
void check_filters(hid_t creation, const std::string& name) {
    const auto filter = [&](unsigned number) {
        std::size_t values = 0;
        return H5Pget_filter2(creation, number, nullptr, &values, nullptr, 0, nullptr, nullptr);
    };
    const int count = checked(H5Pget_nfilters(creation), "list the filters of " + name);
    for (int i = 0; i < count; ++i)
        if (const H5Z_filter_t met = filter(static_cast<unsigned>(i));
            met != H5Z_FILTER_SHUFFLE && met != H5Z_FILTER_DEFLATE)
            throw std::runtime_error(name + " uses a filter other than shuffle and deflate");
    if (count != 2 || filter(0) != H5Z_FILTER_SHUFFLE || filter(1) != H5Z_FILTER_DEFLATE)
        throw std::runtime_error(name + " is not shuffled and deflated, once each");
}

/// Checks that all that the file names is a dataset of its own: a table has no groups, named types
/// or links to elsewhere, and none is followed.
void check_objects(hid_t file) {
    for (const std::string& name : link_names(file)) {
        H5L_info_t link;
        checked(H5Lget_info(file, name.c_str(), &link, H5P_DEFAULT), "look at " + shown(name));
        if (link.type != H5L_TYPE_HARD)
            throw std::runtime_error(shown(name) + " is a link to elsewhere");
        H5O_info_t object;
        checked(H5Oget_info_by_name2(file, name.c_str(), &object, H5O_INFO_BASIC, H5P_DEFAULT),
                "look at " + shown(name));
        if (object.type != H5O_TYPE_DATASET)
            throw std::runtime_error(shown(name) + " is not a dataset");
        if (object.rc != 1) throw std::runtime_error(shown(name) + " has two names");
    }
}

Handle open_dataset(hid_t file, const std::string& name) {
    if (!checked(H5Lexists(file, name.c_str(), H5P_DEFAULT), "list the datasets"))
        throw std::runtime_error("dataset " + name + " is missing");
    return {H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose, "open dataset " + name};
}

std::vector<std::size_t> dataset_extents(hid_t dataset, const std::string& name, std::size_t rank) {
    const Handle space(H5Dget_space(dataset), H5Sclose, "read the extents of " + name);
    if (H5Sget_simple_extent_type(space) != H5S_SIMPLE ||
        H5Sget_simple_extent_ndims(space) != static_cast<int>(rank))
        throw std::runtime_error(name + " must have " + std::to_string(rank) + " dimensions");
    std::vector<hsize_t> sizes(rank);
    checked(H5Sget_simple_extent_dims(space, sizes.data(), nullptr), "read the extents of " + name);
    return {sizes.begin(), sizes.end()};
}

/// Chunks that are runs of neighbouring samples, as this program writes them.
struct Runs {
    std::vector<hsize_t> extents, chunk;
    std::size_t cut;    // the dimension that chunks cut: one at a time before it, whole behind it
    std::size_t inner;  // samples behind it

    std::size_t length() const { return chunk[cut] * inner; }
};

Runs runs_of(hid_t creation, const std::string& name, std::span<const std::size_t> extents) {
    Runs runs{{extents.begin(), extents.end()}, std::vector<hsize_t>(extents.size()), 0, 1};
    const int rank = static_cast<int>(extents.size());
    if (H5Pget_chunk(creation, rank, runs.chunk.data()) != rank)
        throw std::runtime_error(name + " has chunks of another rank than its own");
    for (std::size_t d = 0; d < extents.size(); ++d)
        if (runs.chunk[d] > extents[d])
            throw std::runtime_error(name + " has chunks beyond its extents");
    while (runs.cut + 1 < extents.size() && runs.chunk[runs.cut] == 1) ++runs.cut;
    for (std::size_t d = runs.cut + 1; d < extents.size(); ++d) {
        if (runs.chunk[d] != extents[d])
            throw std::runtime_error(name + " has chunks that are no runs of samples");
        runs.inner *= extents[d];
    }
    const std::size_t count =
        std::accumulate(extents.begin(), extents.end(), std::size_t{1}, std::multiplies<>()) /
        runs.length();
    if (count > max_chunks) throw std::runtime_error(name + " has more chunks than any table");
    return runs;
}

/// Turns the bytes of floats, all first ones before all second ones and so on, back.
void unshuffle(std::span<const unsigned char> bytes, std::span<float> values) {
    const unsigned char* const plane = bytes.data();
    const std::size_t count = bytes.size() / sizeof(float);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = std::bit_cast<float>(
            std::uint32_t{plane[i]} | std::uint32_t{plane[count + i]} << 8 |
            std::uint32_t{plane[2 * count + i]} << 16 | std::uint32_t{plane[3 * count + i]} << 24);
}

/// What a chunk holds, shuffled still: inflated into `room`, or as it lies in the file where
/// deflating it would not have made it smaller.
std::span<const unsigned char> inflate(libdeflate_decompressor* decompressor, hid_t dataset,
                                       const std::string& name, const std::vector<hsize_t>& at,
                                       const Bytes& file_bytes, std::span<unsigned char> room) {
    constexpr unsigned not_deflated = 2;  // the second filter was left out
    unsigned skipped_filters = 0;
    haddr_t address = HADDR_UNDEF;
    hsize_t size = 0;
    checked(H5Dget_chunk_info_by_coord(dataset, at.data(), &skipped_filters, &address, &size),
            "find a chunk of " + name);
    if (address == HADDR_UNDEF) throw std::runtime_error(name + " lacks a chunk");
    if (address > file_bytes.size() || size > file_bytes.size() - address)
        throw std::runtime_error(name + " has a chunk beyond the end of the file");
    const auto* const stored = reinterpret_cast<const unsigned char*>(file_bytes.data()) + address;
    if (skipped_filters == not_deflated && size == room.size()) return {stored, room.size()};
    if (skipped_filters != 0 ||
        libdeflate_zlib_decompress(decompressor, stored, size, room.data(), room.size(), nullptr) !=
            LIBDEFLATE_SUCCESS)
        throw std::runtime_error(name + " has a damaged chunk");
    return room;
}

/// Fills `values` from all chunks.
void read_runs(hid_t dataset, const std::string& name, const Runs& runs, const Bytes& file_bytes,
               MemoryLimit limit, std::vector<float>& values) {
    const std::size_t chunk_bytes = runs.length() * sizeof(float);
    limit.take("a chunk of " + name, chunk_bytes);  // given back at the end
    std::vector<unsigned char> room(chunk_bytes);
    std::vector<hsize_t> at(runs.extents.size(), 0);
    const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)>
        decompressor(libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
    if (!decompressor) throw std::bad_alloc();
    for (std::size_t done = 0; done < values.size();) {
        const std::size_t rows =
            std::min(runs.chunk[runs.cut], runs.extents[runs.cut] - at[runs.cut]);
        unshuffle(inflate(decompressor.get(), dataset, name, at, file_bytes, room),
                  std::span(values).subspan(done, rows * runs.inner));
        done += rows * runs.inner;
        at[runs.cut] += rows;
        for (std::size_t d = runs.cut; d > 0 && at[d] == runs.extents[d]; --d) {
            at[d] = 0;
            ++at[d - 1];
        }
    }
}

/// Reads a dataset whose extents the caller has compared with what they must be. HDF5 itself copies
/// bytes at most: it would inflate a chunk to whatever size it takes.
template <class Number>
std::vector<Number> read_values(hid_t dataset, const std::string& name,
                                std::span<const std::size_t> extents, const Bytes& file_bytes,
                                const MemoryLimit& limit) {
    const Handle type(H5Dget_type(dataset), H5Tclose, "read the type of " + name);
    if (H5Tequal(type, Element<Number>::stored()) <= 0)
        throw std::runtime_error(name + " must hold little-endian floating-point numbers of " +
                                 std::to_string(sizeof(Number)) + " bytes");
    const Handle creation(H5Dget_create_plist(dataset), H5Pclose, "read the layout of " + name);
    const bool chunked = is_chunked(creation, name);
    if (chunked && !std::is_same_v<Number, float>)
        throw std::runtime_error(name + " lies in chunks, which only samples do");
    std::optional<Runs> runs;
    if (chunked) {
        check_filters(creation, name);
        runs = runs_of(creation, name, extents);
    }
    const std::uintmax_t stored =
        std::min<std::uintmax_t>(H5Dget_storage_size(dataset), file_bytes.size());
    const std::size_t count = checked_count(name, extents, sizeof(Number), stored);
    if (!chunked && count * sizeof(Number) > stored)
        throw std::runtime_error(name + " is larger than what the file holds");
    std::vector<Number> values(count);
    if constexpr (std::is_same_v<Number, float>)
        if (runs) read_runs(dataset, name, *runs, file_bytes, limit, values);
    if (!runs)
        checked(H5Dread(dataset, Element<Number>::memory(), H5S_ALL, H5S_ALL, H5P_DEFAULT,
                        values.data()),
                "read dataset " + name);
    check_checksum(name, read_text(dataset, name, checksum_name, file_bytes),
                   checksum(std::span<const Number>(values)));
    return values;
}

template <class Number>
std::vector<Number> read_over_axes(hid_t file, const std::string& name,
                                   const std::vector<std::size_t>& extents, const Bytes& bytes,
                                   const MemoryLimit& limit) {
    const Handle dataset = open_dataset(file, name);
    if (dataset_extents(dataset, name, extents.size()) != extents)
        throw std::runtime_error("extents of " + name + " are not those of its axes");
    return read_values<Number>(dataset, name, extents, bytes, limit);
}

void read_axis(hid_t file, const AxisField& field, Axis& axis, const Bytes& bytes,
               const MemoryLimit& limit) {
    const Handle dataset = open_dataset(file, field.name);
    const std::vector<std::size_t> extents = dataset_extents(dataset, field.name, 1);
    if (extents[0] > longest_axis)
        throw std::runtime_error(std::string(field.name) + " has more samples than any axis");
    check_scale(field.name, axis, read_text(dataset, field.name, "scale", bytes));
    axis.values = read_values<double>(dataset, field.name, extents, bytes, limit);
}

}  // namespace

Bytes encode_hdf5(const Table& table, const Metadata& metadata) {
    constexpr std::uint64_t root_at = 48;  // right behind the superblock
    const QuietErrors quiet;
    Bytes bytes;
    Handle file = create_file(bytes);
    const std::vector<AxisField> axes = axis_fields_of(table);
    for (const AxisField& field : axes) write_axis(file, field, table.*field.axis);
    const auto write_over_axes = [&](const char* name, const char* long_name, std::size_t rank,
                                     const auto& values) {
        const std::vector<std::size_t> sizes = extents(table, rank);
        attach_axes(file, write_dataset(file, name, long_name, "1", sizes, values),
                    std::span(axes).first(sizes.size()));
    };
    write_over_axes(diffusion_exponent_name, diffusion_exponent_long_name, 1,
                    table.diffusion_exponent);
    for (const SampleField& field : listed_samples(metadata))
        write_over_axes(field.name, field.long_name, field.rank, table.*field.samples);
    write_metadata(file, metadata);
    file.close("finish the file");
    if (const char* const fault = Hdf5Structures(bytes).fault(H5FD_MEM_OHDR, root_at, bytes.size()))
        throw std::runtime_error(std::string("cannot keep all attributes: ") + fault);
    append_seal(bytes);
    return bytes;
}

Table decode_hdf5(const Bytes& bytes, MemoryLimit limit, std::vector<std::string>* notes) {
    check_seal(bytes);
    const QuietErrors quiet;
    const Handle driver = new_driver();
    const Handle file = open_file(driver, bytes);
    const Metadata metadata = read_metadata(file, bytes);
    check_objects(file);
    Table table;
    take_metadata(metadata, table);
    note_version(metadata, notes);
    const std::vector<AxisField> axes = axis_fields_of(metadata);
    if (axes.size() == axis_fields.size() && H5Lexists(file, mixture_field.name, H5P_DEFAULT) > 0)
        entry(metadata, "second_phase_function");  // refuses: none is there
    for (const AxisField& field : axes) read_axis(file, field, table.*field.axis, bytes, limit);
    table.diffusion_exponent =
        read_over_axes<double>(file, diffusion_exponent_name, extents(table, 1), bytes, limit);
    const std::vector<SampleField> listed = listed_samples(metadata);
    take_memory(table, listed, bytes.size(), limit);
    for (const SampleField& field : listed)
        table.*field.samples =
            read_over_axes<float>(file, field.name, extents(table, field.rank), bytes, limit);
    prepare(table);
    return table;
}

}  // namespace stratus::io
