// The objects behind the handles of the C interface.
#pragma once

#include <stratus/bsdf/bsdf.h>
#include <stratus/bsdf/slice.h>
#include <stratus/io/table_file.h>
#include <stratus/layer/stack_layers.h>
#include <stratus/stratus.h>

#include <cstddef>
#include <memory>
#include <mutex>
#include <string>
#include <variant>
#include <vector>

namespace stratus::c {

/// A table as it was read or made, shared by the handles of its mixtures.
struct SharedTable {
    explicit SharedTable(AnyTable table);

    AnyTable own;
    std::string phase_function, second_phase_function;
    std::vector<std::string> layer_texts;  // of a stack
    std::vector<stratus_layer> layers;
};

/// Held while HDF5 is called, which is not thread-safe.
std::unique_lock<std::mutex> hdf5_lock();

/// The layers of a stack.
///
/// Errors   std::invalid_argument for null, and for texts that are no phase functions.
std::vector<StackLayer> make_layers(const stratus_layer* layers, std::size_t count,
                                    const char* function);

/// Checks that a table of a family is seen at one point of it.
void require_member(const stratus_table& table, const char* function);

}  // namespace stratus::c

struct stratus_table {
    std::shared_ptr<const stratus::c::SharedTable> shared;
    stratus::TableView view;
};

struct stratus_slice {
    std::variant<std::monostate, stratus::Slice, stratus::RgbSlice> own;  // nothing: a BSDF's
    const stratus::Slice* one = nullptr;  // one of the two, by channels
    const stratus::RgbSlice* three = nullptr;
};

struct stratus_bsdf {
    std::variant<std::monostate, stratus::Bsdf, stratus::RgbBsdf> own;
    stratus_slice slice;
};

namespace stratus::c {

/// A handle of a table.
stratus_table* make_handle(std::shared_ptr<const SharedTable> shared);

/// Calls `use` with the slice or BSDF of either kind.
template <class Use>
auto with(const stratus_slice& slice, const Use& use) {
    return slice.one != nullptr ? use(*slice.one) : use(*slice.three);
}
template <class Use>
auto with(const stratus_bsdf& bsdf, const Use& use) {
    const auto* const one = std::get_if<Bsdf>(&bsdf.own);
    return one != nullptr ? use(*one) : use(std::get<RgbBsdf>(bsdf.own));
}

inline void write(float from, float* value) { *value = from; }

inline void write(const Rgb& from, float* value) {
    value[0] = from.r;
    value[1] = from.g;
    value[2] = from.b;
}

}  // namespace stratus::c
