// The objects behind the handles of the C interface, and how its functions fail: what they throw becomes a
// status, and a text that stratus_last_error() returns.
#pragma once

#include <stratus/base/argument.h>
#include <stratus/bsdf/any_slice.h>
#include <stratus/io/table_file.h>
#include <stratus/layer/stack_layers.h>
#include <stratus/stratus.h>

#include <cstddef>
#include <cstring>
#include <exception>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus::c {

// ---- failures

/// A callback of the program asked for an end.
class Stopped : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Keeps a text for stratus_last_error(), and returns the status.
int failed(int status, const char* what) noexcept;

/// A pointer that the caller must give, and its name.
struct Given {
    const void* pointer;
    const char* name;
};

/// Apart from what calls it, which is short where nothing is null: lookups take some 40 ns.
[[noreturn]] void refuse_null(const char* function, const char* argument);

inline void require_given(const char* function, std::initializer_list<Given> arguments) {
    for (const auto& [pointer, name] : arguments)
        if (pointer == nullptr) refuse_null(function, name);
}

/// Runs a function of the interface, whose `arguments` must be given.
template <class Body>
int run_guarded(const char* function, std::initializer_list<Given> arguments,
                const Body& body) noexcept {
    try {
        require_given(function, arguments);
        body();
        return STRATUS_OK;
    } catch (const std::invalid_argument& error) {
        return failed(STRATUS_INVALID_ARGUMENT, error.what());
    } catch (const std::bad_alloc&) {
        return failed(STRATUS_OUT_OF_MEMORY, "out of memory");
    } catch (const Stopped& error) {
        return failed(STRATUS_STOPPED, error.what());
    } catch (const std::exception& error) {
        return failed(STRATUS_FAILED, error.what());
    } catch (...) {
        return failed(STRATUS_FAILED, "unknown exception");
    }
}

/// Runs a function that makes a handle, make(), of arguments that must be given; null where it fails.
template <class Handle, class Make>
int make_guarded(const char* function, Handle** handle, const char* name,
                 std::initializer_list<Given> arguments, const Make& make) noexcept {
    return run_guarded(function, {{handle, name}}, [&] {
        *handle = nullptr;
        require_given(function, arguments);
        *handle = make();
    });
}

/// Arrays of `count`, which may be null when that is 0.
inline void require_arrays(std::size_t count, std::initializer_list<const void*> arrays,
                           const char* function) {
    if (count == 0) return;
    for (const void* array : arrays) require_given(function, {{array, "every array"}});
}

/// Checks the size that a caller states: this header's, or that of an older one.
template <class Struct>
void require_size(const Struct& met, const char* function, const char* argument,
                  std::size_t oldest = sizeof(Struct)) {
    const std::string older = oldest < sizeof(Struct) ? std::to_string(oldest) + " or " : "";
    require(met.size == oldest || met.size == sizeof(Struct), function,
            std::string(argument) + ".size", older + std::to_string(sizeof(Struct)), met.size);
}

/// A struct of this header's size: what an older caller does not know is 0.
template <class Struct>
Struct completed(const Struct& met) noexcept {
    Struct whole{};
    std::memcpy(&whole, &met, met.size);
    return whole;
}

/// Fills as much of a caller's struct as it has room for.
template <class Struct>
void fill(Struct& to, Struct from) noexcept {
    from.size = to.size;
    std::memcpy(&to, &from, to.size);
}

// ---- handles

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
StackLayers make_layers(const stratus_layer* layers, std::size_t count, const char* function);

/// Checks that a table of a family is seen at one point of it.
void require_member(const stratus_table& table, const char* function);

}  // namespace stratus::c

struct stratus_table {
    std::shared_ptr<const stratus::c::SharedTable> shared;
    stratus::TableView view;
};

struct stratus_slice {
    stratus::AnySlice own;
};

/// The handle of its slice is the same one.
struct stratus_bsdf : stratus_slice {};

namespace stratus::c {

/// A handle of a table.
stratus_table* make_handle(AnyTable table);

inline void write(float from, float* value) { *value = from; }

inline void write(const Rgb& from, float* value) {
    value[0] = from.r;
    value[1] = from.g;
    value[2] = from.b;
}

}  // namespace stratus::c
