// Cairo's objects, owned, and its failures as exceptions.
#pragma once

#include <cairo.h>

#include <cerrno>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>

namespace stratus {

struct CairoDelete {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* context) const { cairo_destroy(context); }
    void operator()(cairo_pattern_t* pattern) const { cairo_pattern_destroy(pattern); }
};
using Surface = std::unique_ptr<cairo_surface_t, CairoDelete>;
using Context = std::unique_ptr<cairo_t, CairoDelete>;
using Pattern = std::unique_ptr<cairo_pattern_t, CairoDelete>;

/// Reports a file that could not be read or written: with errno's reason or, where that is 0,
/// Cairo's.
///
/// Errors   std::system_error, in which write_atomically replaces the name of its temporary file by
///          the user's; std::runtime_error with Cairo's reason.
[[noreturn]] inline void fail(const std::filesystem::path& path, cairo_status_t status) {
    if (errno != 0) throw std::system_error(errno, std::generic_category(), path.string());
    throw std::runtime_error(path.string() + ": " + cairo_status_to_string(status));
}

}  // namespace stratus
