// Cairo's objects, owned, and how a picture gets into its file.
#pragma once

#include <cairo.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>

namespace stratus {

struct CairoDelete {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* context) const { cairo_destroy(context); }
};
using Surface = std::unique_ptr<cairo_surface_t, CairoDelete>;
using Context = std::unique_ptr<cairo_t, CairoDelete>;

/// A cairo_write_func_t; `file` is a std::ofstream.
inline cairo_status_t append_to_file(void* file, const unsigned char* bytes, unsigned int count) {
    auto& stream = *static_cast<std::ofstream*>(file);
    stream.write(reinterpret_cast<const char*>(bytes), static_cast<std::streamsize>(count));
    return stream ? CAIRO_STATUS_SUCCESS : CAIRO_STATUS_WRITE_ERROR;
}

/// Says why `path` could not be written: what the system (errno) or else Cairo says.
///
/// Errors   std::system_error, so that write_atomically names the file that the user knows;
/// std::runtime_error with Cairo's reason.
[[noreturn]] inline void fail(const std::filesystem::path& path, cairo_status_t status) {
    if (errno != 0) throw std::system_error(errno, std::generic_category(), path.string());
    throw std::runtime_error(path.string() + ": " + cairo_status_to_string(status));
}

/// Writes a picture as PNG.
inline void write_surface(cairo_surface_t* surface, const std::filesystem::path& png) {
    errno = 0;
    if (const cairo_status_t status = cairo_surface_status(surface); status != CAIRO_STATUS_SUCCESS)
        fail(png, status);
    std::ofstream file(png, std::ios::binary);
    if (!file) fail(png, CAIRO_STATUS_WRITE_ERROR);
    const cairo_status_t status = cairo_surface_write_to_png_stream(surface, append_to_file, &file);
    file.close();
    if (status != CAIRO_STATUS_SUCCESS || !file) fail(png, status);
}

}  // namespace stratus
