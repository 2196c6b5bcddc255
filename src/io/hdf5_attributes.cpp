#include "hdf5_parts.h"

#include <algorithm>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace stratus::io::hdf5 {
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
    switch (entry_type(name)) {
        case MetadataEntry::Type::text: return write_text(object, name, text);
        case MetadataEntry::Type::integer: {
            const int value = to_integer(name, text);
            return write_attribute(object, name, H5T_STD_I32LE, H5T_NATIVE_INT, new_scalar(),
                                   &value);
        }
        case MetadataEntry::Type::number: {
            const double value = to_number(name, text);
            return write_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, new_scalar(),
                                   &value);
        }
        case MetadataEntry::Type::numbers: {
            const std::vector<double> values = to_numbers(name, text);
            const std::size_t count = values.size();
            return write_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                                   new_dataspace({&count, 1}), values.data());
        }
    }
}

/// Returns the size of an attribute, which must not exceed its file.
std::size_t checked_size(hid_t attribute, std::size_t element_size, const std::string& name) {
    const std::string task = "read attribute " + name;
    const Handle space(H5Aget_space(attribute), H5Sclose, task);
    const Handle file(H5Iget_file_id(attribute), H5Fclose, task);
    const auto count = static_cast<std::size_t>(checked(H5Sget_simple_extent_npoints(space), task));
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
