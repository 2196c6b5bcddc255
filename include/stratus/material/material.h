// Layers and stacks as material files of other renderers.
//
// A material is solved anew at the directions that a format samples, with the solver (solve.h,
// stack.h): no table's interpolation enters. What a format cannot hold is left out of the file and
// told in the notes; the beam that goes straight through, exp(-tau/mu), is in none of them. BRDF is
// R / pi, BTDF T / pi. docs/exports.md has the layouts.
#pragma once

#include <stratus/bake/stack_file.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace stratus {

/// A material to be written: all light alike, or red, green and blue.
struct Material {
    std::vector<Stack> colours;  // one or three
    std::string title;           // kept in files that have room for text

    /// Nothing is transmitted, in any colour: all of them end on a lower boundary or are of infinite
    /// depth.
    bool is_opaque() const;
};

enum class MaterialFormat {
    fourier,     // SCATFUN table .bsdf: reflection and transmission, lit from either side
    tensor,      // "tensor_file" .bsdf with wavelengths: reflection alone, as the two that
                 // follow
    tensor_rgb,  // the same with red, green and blue
    netcdf,      // Eradiate's mqdiffuse: one colour
    exr_atlas,   // an OpenEXR picture for shaders, and JSON that describes it: both sides, lit from
                 // above
    slice,       // arrays on even axes in the safetensors layout: both sides, lit from above, all
                 // orders and orders n >= 2
};

/// Names of the formats on the command line, in the order of MaterialFormat.
const std::vector<std::string>& material_format_names();

struct MaterialOptions {
    double tolerance = 1e-3;  // relative, of R and T (choose_nodes in solve_to_tolerance.h)
    int nodes = 0;            // Gauss nodes of the solver, [1, 512]; 0: as the tolerance needs
    bool accept = false;      // a tolerance that is out of reach is noted in place of refused
    int threads = 0;          // 0: all
    std::function<void(double done, const std::string& stage)> progress;
};

/// A material worked out for one format.
struct MaterialFile {
    std::function<void(const std::filesystem::path& path)> write;
    std::string json;                // of the atlas; empty for others
    std::vector<std::string> notes;  // for the user: what the format leaves out
    double error = 0;                // of R and T at cosines from 0.15 on, relative, estimated
    int nodes = 0;                   // of the solver
};

/// Solves a material at the directions of a format.
///
/// Errors   std::invalid_argument naming argument, range and value for a material that the format
///          cannot hold, std::runtime_error for a tolerance that is missed.
MaterialFile make_material(const Material& material, MaterialFormat format,
                           const MaterialOptions& options = {});

/// Writes it; a file appears whole or not at all. The JSON of an atlas lies beside it, under the
/// same name with the ending .json.
///
/// Errors   std::runtime_error "PATH: reason".
void write_material(const MaterialFile& file, const std::filesystem::path& path);

}  // namespace stratus
