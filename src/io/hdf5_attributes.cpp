#include "hdf5_attributes.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <vector>

namespace stratus::io::hdf5 {
namespace {

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
    switch (entry_type(name)) {
        case EntryType::text: return write_text(object, name, text);
        case EntryType::integer: {
            const int value = to_integer(name, text);
            return write_attribute(object, name, H5T_STD_I32LE, H5T_NATIVE_INT, new_scalar(),
                                   &value);
        }
        case EntryType::number: {
            const double value = to_number(name, text);
            return write_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, new_scalar(),
                                   &value);
        }
        case EntryType::numbers: {
            const std::vector<double> values = to_numbers(name, text);
            const std::size_t count = values.size();
            return write_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                                   new_dataspace({&count, 1}), values.data());
        }
    }
}

/// Fills `values`, whose size the caller has checked, with elements of `memory_type`.
template <class Values>
Values read_elements(hid_t attribute, hid_t memory_type, Values values, const std::string& name) {
    checked(H5Aread(attribute, memory_type, values.data()), "read attribute " + name);
    return values;
}

struct TypedEntry {
    EntryType type;
    std::string text;
};

/// Reads an attribute of any type that the format uses.
TypedEntry read_attribute(hid_t object, const std::string& name, const Bytes& file_bytes) {
    const std::string task = "read attribute " + name;
    const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, task);
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
        std::string text = read_elements(attribute, type, std::string(size, '\0'), name);
        text.erase(std::min(text.find('\0'), text.size()));
        return {EntryType::text, text};
    }
    if (scalar && H5Tequal(type, H5T_STD_I32LE) > 0) {
        const auto value = read_elements(attribute, H5T_NATIVE_INT, std::array<int, 1>{}, name);
        return {EntryType::integer, std::to_string(value[0])};
    }
    if ((scalar || row) && H5Tequal(type, H5T_IEEE_F64LE) > 0) {
        const auto values =
            read_elements(attribute, H5T_NATIVE_DOUBLE, std::vector<double>(count), name);
        return {scalar ? EntryType::number : EntryType::numbers, to_text(values)};
    }
    throw std::runtime_error("attribute " + name + " is of a type that the format does not use");
}

/// Reads only what decides whether the rest may be read.
void check_format_of_file(hid_t file, const Bytes& file_bytes) {
    Metadata metadata;
    for (const char* name : {"format", "format_major", "format_minor"})
        if (checked(H5Aexists(file, name), "list the attributes"))
            metadata[name] = read_attribute(file, name, file_bytes).text;
    check_format(metadata);
}

}  // namespace

void write_text(hid_t object, const std::string& name, const std::string& text) {
    const Handle type = text_type(text.size());
    write_attribute(object, name, type, type, new_scalar(), text.c_str());
}

std::string read_text(hid_t object, const std::string& owner, const std::string& name,
                      const Bytes& file_bytes) {
    if (!checked(H5Aexists(object, name.c_str()), "list the attributes of " + owner))
        throw std::runtime_error(owner + " has no attribute " + name);
    const TypedEntry entry = read_attribute(object, name, file_bytes);
    if (entry.type != EntryType::text)
        throw std::runtime_error("attribute " + name + " of " + owner + " is not text");
    return entry.text;
}

void write_metadata(hid_t file, const Metadata& metadata) {
    for (const auto& [name, text] : metadata) write_entry(file, name, text);
    write_text(file, checksum_name, checksum(metadata));
}

Metadata read_metadata(hid_t file, const Bytes& file_bytes) {
    check_format_of_file(file, file_bytes);
    Metadata metadata;
    for (const std::string& name : attribute_names(file)) {
        const TypedEntry entry = read_attribute(file, name, file_bytes);
        // Attributes that a newer minor version adds may be of any type and are kept as text.
        if (entry_type(name) != EntryType::text && entry.type != entry_type(name))
            throw std::runtime_error("attribute " + name + " is of the wrong type");
        if (!metadata.emplace(name, entry.text).second)
            throw std::runtime_error("duplicate attribute " + shown(name));
    }
    check_and_remove_checksum(metadata);
    return metadata;
}

}  // namespace stratus::io::hdf5
