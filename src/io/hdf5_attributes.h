// Attributes in HDF5 files: the metadata of a table, on the root, and texts on its datasets.
#pragma once

#include "hdf5_library.h"
#include "table_content.h"

#include <string>

namespace stratus::io::hdf5 {

void write_text(hid_t object, const std::string& name, const std::string& text);

/// The text attribute `name` of an object that messages call `owner`.
///
/// Errors   std::runtime_error when it is missing, not text, or larger than the file.
std::string read_text(hid_t object, const std::string& owner, const std::string& name,
                      const Bytes& file_bytes);

/// Writes each entry as an attribute of its type, and the checksum of all.
void write_metadata(hid_t file, const Metadata& metadata);

/// Errors   std::runtime_error for another format or version, which are checked before anything
///          else is read, for an attribute of the wrong type, and for a wrong checksum.
Metadata read_metadata(hid_t file, const Bytes& file_bytes);

}  // namespace stratus::io::hdf5
