// Cairo's objects, owned, and how a picture gets into its file.
#pragma once

#include <cairo.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>

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

[[noreturn]] inline void fail(const std::filesystem::path& path, const std::string& reason) {
    throw std::runtime_error(path.string() + ": " + reason);
}

}  // namespace stratus
