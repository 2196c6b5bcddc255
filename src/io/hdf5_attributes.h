// Attributes in HDF5 files: the metadata of a table, on the root, and texts on its datasets.
#pragma once

#include "hdf5_library.h"
#include "table_content.h"

#include <optional>
#include <string>

namespace stratus::io::hdf5 {

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

}  // namespace stratus::io::hdf5
