#include "hdf5_library.h"

#include <new>

namespace stratus::io::hdf5 {
namespace {

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

Handle create_file(const std::string& name, const Handle& access) {
    constexpr unsigned ordered = H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED;
    checked(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110),
            "choose the format version");
    const Handle creation = new_property_list(H5P_FILE_CREATE);
    checked(H5Pset_link_creation_order(creation, ordered), "track the order of datasets");
    checked(H5Pset_attr_creation_order(creation, ordered), "track the order of attributes");
    checked(H5Pset_obj_track_times(creation, false), "leave out times");
    return {H5Fcreate(name.c_str(), H5F_ACC_TRUNC, creation, access), H5Fclose, "create the file"};
}

std::vector<std::string> attribute_names(hid_t object) {
    std::vector<std::string> names;
    checked(H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, append_name, &names),
            "list the attributes");
    return names;
}

}  // namespace stratus::io::hdf5
