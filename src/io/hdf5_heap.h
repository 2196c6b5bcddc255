// Attributes and links that an HDF5 file keeps in a heap, and the B-trees that index them.
#pragma once

#include "hdf5_file_region.h"

#include <cstdint>
#include <functional>

namespace stratus::io {

using Check = std::function<void(const FileRegion&)>;

/// What the records of a B-tree refer to.
enum class TreeKind { huge_objects = 1, link_names = 5, attribute_names = 8 };

/// Checks the heap whose address an object header has at `at`, and the B-trees that index it: by
/// name, and where they are ordered by creation too.
///
/// Errors   RefusedStructure.
void check_heap(const FileRegion& message, std::uint64_t at, TreeKind names,
                const Check& check_message);

}  // namespace stratus::io
