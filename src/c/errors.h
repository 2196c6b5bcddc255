// How functions of the C interface fail: what they throw becomes a status, and a text that
// stratus_last_error() returns.
#pragma once

#include <stratus/base/argument.h>
#include <stratus/stratus.h>

#include <cstddef>
#include <cstring>
#include <exception>
#include <initializer_list>
#include <new>
#include <stdexcept>
#include <string>

namespace stratus::c {

/// A callback of the program asked for an end.
class Stopped : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Keeps a text for stratus_last_error(), and returns the status.
int failed(int status, const char* what) noexcept;

/// Runs a function of the interface.
template <class Body>
int run_guarded(const Body& body) noexcept {
    try {
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

inline void require_given(const void* pointer, const char* function, const char* argument) {
    if (pointer != nullptr) return;  // before any text is made
    require(false, function, argument, "given", "null");
}

/// Arrays of `count`, which may be null when that is 0.
inline void require_arrays(std::size_t count, std::initializer_list<const void*> arrays,
                           const char* function) {
    if (count == 0) return;
    for (const void* array : arrays) require_given(array, function, "every array");
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

}  // namespace stratus::c
