// Formats whose samples are evenly spaced: netCDF for Eradiate, pictures for shaders, arrays for any language.
//
// netCDF for Eradiate's mqdiffuse: the BRDF over (cos_theta_o, phi_d, cos_theta_i), evenly spaced.
//
// Both directions point away from the surface there, so that phi_d = 0 is back to the light:
// azimuth pi.
#include <stratus/bake/parallel.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/base/tensor_file.h>
#include <stratus/io/image.h>
#include <stratus/io/write_options.h>

#include "solved_stack.h"

#include <cmath>

namespace stratus {
namespace {

constexpr int mqdiffuse_cosines = 101, mqdiffuse_azimuths = 72;  // 72: over 2 pi, the end left out

/// Where both cosines are 0 f has no limit. A third of a step off it is such that lines between the
/// samples meet 1 / (mu + mu0) amid the first cell.
constexpr double corner = 1.0 / (3 * (mqdiffuse_cosines - 1));

}  // namespace

MaterialFile make_mqdiffuse(const Material& material, const MaterialOptions& options) {
    require(material.colours.size() == 1, "export", "colours of netcdf", "one, it holds grey",
            material.colours.size());
    MaterialFile file;
    note_transmission(material, file.notes);
    std::vector<double> mu{grazing}, cosines{0}, phi, azimuths;
    for (int k = 1; k < mqdiffuse_cosines; ++k) cosines.push_back(k / (mqdiffuse_cosines - 1.0));
    mu.insert(mu.end(), cosines.begin() + 1, cosines.end());
    mu.push_back(corner);
    for (int k = 0; k < mqdiffuse_azimuths; ++k) {
        phi.push_back(2 * pi * k / mqdiffuse_azimuths);
        azimuths.push_back(std::abs(pi - phi.back()));
    }
    const SolvedStack solved = std::move(solve_colours(material, mu, options)[0]);
    const auto count = size(mqdiffuse_cosines);
    std::vector<float> brdf(count * mqdiffuse_azimuths * count);
    parallel_for(mqdiffuse_cosines, options.threads, [&](int out) {
        for (int in = out; in < mqdiffuse_cosines; ++in) {
            const bool at_corner = in == 0 && out == 0;
            const std::vector<SolvedValue> values =
                solved.values(LitSide::reflection, at_corner ? mqdiffuse_cosines : in,
                              at_corner ? mqdiffuse_cosines : out, azimuths);
            for (std::size_t a = 0; a < mqdiffuse_azimuths; ++a) {
                const auto i = size(in), o = size(out);
                brdf[(o * mqdiffuse_azimuths + a) * count + i] =
                    brdf[(i * mqdiffuse_azimuths + a) * count + o] =
                        static_cast<float>(values[a].total / pi);
            }
        }
    });
    auto grid = std::make_shared<NetcdfGrid>();
    grid->dimensions = {
        {"cos_theta_o", "1", "cosine of the outgoing zenith angle", cosines},
        {"phi_d", "rad", "azimuth between the directions, both away from the layer", phi},
        {"cos_theta_i", "1", "cosine of the incoming zenith angle", cosines}};
    grid->name = "brdf";
    grid->units = "sr**-1";
    grid->long_name = "BRDF, the cosine left out";
    grid->values = std::move(brdf);
    grid->attributes = {{"title", describe(material)}};
    file.write = [grid](const std::filesystem::path& path) { write_netcdf(*grid, path); };
    return file;
}

// Pictures for shaders: tiles of f (mu_in + mu_out) pi over azimuth and mu_out, one column of tiles
// for each mu_in, one row for each side.

namespace {

/// Samples of one side over (colour, mu_in, mu_out, azimuth), times mu_in + mu_out.
struct Samples {
    std::vector<float> all_orders, multiple;
};

Samples sample(LitSide side, const SolvedColours& colours, const std::vector<double>& mu,
               const std::vector<double>& azimuths, int threads) {
    const int cosines = int_size(mu);
    const std::size_t row_size = mu.size() * azimuths.size(),
                      count = colours.size() * mu.size() * row_size;
    Samples samples{std::vector<float>(count), std::vector<float>(count)};
    parallel_for(int_size(colours) * cosines, threads, [&](int row) {
        const int in = row % cosines;
        const SolvedStack& colour = colours[size(row / cosines)];
        std::size_t at = size(row) * row_size;
        for (int out = 0; out < cosines; ++out) {
            const double sum = mu[size(in)] + mu[size(out)];
            for (const SolvedValue& value : colour.values(side, in, out, azimuths)) {
                samples.all_orders[at] = static_cast<float>(sum * value.total);
                samples.multiple[at++] = static_cast<float>(sum * value.multiple);
            }
        }
    });
    return samples;
}

constexpr int atlas_cosines = 64, atlas_azimuths = 64;

Image draw_tiles(const std::vector<LitSide>& rows, const SolvedColours& colours,
                 const std::vector<double>& mu, int threads) {
    const std::vector<double> azimuths = even_azimuths(atlas_azimuths);
    Image image(atlas_cosines * atlas_azimuths, int_size(rows) * atlas_cosines);
    for (int row = 0; row < int_size(rows); ++row) {
        const std::vector<float> values =
            sample(rows[size(row)], colours, mu, azimuths, threads).all_orders;
        for (std::size_t c = 0; c < 3; ++c) {
            const float* value =
                values.data() + c % colours.size() * values.size() / colours.size();
            for (int in = 0; in < atlas_cosines; ++in)
                for (int out = 0; out < atlas_cosines; ++out)
                    for (int a = 0; a < atlas_azimuths; ++a)
                        image.pixel(in * atlas_azimuths + a, row * atlas_cosines + out)[c] =
                            *value++;
        }
    }
    return image;
}

/// JSON has no infinity: null stands for it, of optical depths where nothing passes.
std::string list_json(const std::vector<double>& values) {
    std::vector<std::string> numbers;
    for (const double value : values)
        numbers.push_back(std::isinf(value) ? "null" : shortest_text(value));
    return "[" + joined(numbers) + "]";
}

/// One list for each colour.
std::string lists_json(const SolvedColours& colours,
                       std::vector<double> (SolvedStack::*fluxes)() const) {
    std::vector<std::string> lists;
    for (const SolvedStack& colour : colours) lists.push_back(list_json((colour.*fluxes)()));
    return "[\n    " + joined(lists, ",\n    ") + "\n  ]";
}

std::string atlas_json(const Material& material, const std::vector<LitSide>& rows,
                       const SolvedColours& colours, const std::vector<double>& mu) {
    std::vector<double> mu_in = mu;
    mu_in[0] = 0;
    std::vector<std::string> names;
    for (const LitSide row : rows) names.push_back(json_string(lit_side_name(row)));
    std::ostringstream json;
    json << "{\n  \"format\": \"stratus-atlas\",\n  \"version\": 1,\n  \"material\": "
         << json_string(describe(material)) << ",\n  \"rows\": [" << joined(names)
         << "],\n  \"columns\": " << atlas_cosines << ",\n  \"tile_width\": " << atlas_azimuths
         << ",\n  \"tile_height\": " << atlas_cosines
         << ",\n  \"texel\": \"pi f (mu_in + mu_out), f the BRDF or BTDF per steradian without the "
            "cosine; A is 1\",\n"
            "  \"column\": \"(columns - 1) asin(sqrt(mu_in)) 2 / pi; blend the two nearest\",\n"
            "  \"x\": \"0.5 + (tile_width - 1) azimuth / pi, in texels from the tile's left edge; "
            "azimuth 0 is forward\",\n"
            "  \"y\": \"0.5 + (tile_height - 1) asin(sqrt(mu_out)) 2 / pi, in texels from the "
            "tile's top edge\",\n"
            "  \"not_in_it\": \"the beam straight through, exp(-optical_depth / mu); light from "
            "below is transmitted as from above with mu_in and mu_out exchanged\",\n"
         << "  \"optical_depth\": " << list_json(beam_depths(material))
         << ",\n  \"mu_in\": " << list_json(mu_in)
         << ",\n  \"plane_albedo\": " << lists_json(colours, &SolvedStack::plane_albedo)
         << ",\n  \"diffuse_transmittance\": "
         << lists_json(colours, &SolvedStack::diffuse_transmittance) << "\n}\n";
    return json.str();
}

}  // namespace

MaterialFile make_atlas(const Material& material, const MaterialOptions& options) {
    MaterialFile file;
    const std::vector<double> mu = even_cosines(atlas_cosines);
    const SolvedColours colours = solve_colours(material, mu, options);
    const std::vector<LitSide> rows = lit_sides(material, colours);
    const auto image =
        std::make_shared<const Image>(draw_tiles(rows, colours, mu, options.threads));
    file.json = atlas_json(material, rows, colours, mu);
    file.write = [image, json = file.json](const std::filesystem::path& path) {
        write_exr_image(*image, {{"stratus:atlas", json}}, path, Alpha::opaque);
    };
    return file;
}

// R and T of one layer or stack on even axes, as named arrays in the safetensors layout: for
// lookups by straight lines, in any language.

namespace {

constexpr int slice_cosines = 64, slice_azimuths = 65;
constexpr auto cosines = size(slice_cosines), azimuths = size(slice_azimuths);

void set_strings(const Material& material, TensorWriter& file) {
    file.set("format", "stratus-slice");
    file.set("format_version", "1");
    file.set("material", describe(material));
    file.set("axes", "colour, mu_in, mu_out, azimuth; one colour, or red, green and blue");
    file.set("coordinates",
             "even from 0 to 1: asin(sqrt(mu_in)) 2 / pi, asin(sqrt(mu_out)) 2 / pi, azimuth / pi; "
             "azimuth 0 is forward, and light is even in it; straight lines between samples");
    file.set("values",
             "R or T times (mu_in + mu_out); BRDF or BTDF = value / (pi (mu_in + mu_out)), per "
             "steradian, without the cosine");
    file.set("orders",
             "reflection, transmission and reflection_below (lit from below): all orders; the same "
             "with _multiple: orders n >= 2");
    file.set("not_in_it",
             "the beam straight through, exp(-optical_depth / mu); light from below is transmitted "
             "as from above with mu_in and mu_out exchanged");
}

void add_fluxes(const SolvedColours& colours, TensorWriter& file) {
    std::vector<double> albedo, transmittance;
    for (const SolvedStack& colour : colours) {
        const std::vector<double> reflected = colour.plane_albedo(),
                                  transmitted = colour.diffuse_transmittance();
        albedo.insert(albedo.end(), reflected.begin(), reflected.end());
        transmittance.insert(transmittance.end(), transmitted.begin(), transmitted.end());
    }
    file.add("plane_albedo", {colours.size(), cosines}, albedo);
    file.add("diffuse_transmittance", {colours.size(), cosines}, transmittance);
}

}  // namespace

MaterialFile make_slice(const Material& material, const MaterialOptions& options) {
    MaterialFile file;
    const std::vector<double> mu = even_cosines(slice_cosines);
    const SolvedColours colours = solve_colours(material, mu, options);
    TensorWriter tensors;
    set_strings(material, tensors);
    std::vector<double> axis = mu;
    axis[0] = 0;
    tensors.add("mu_in", {cosines}, axis);
    tensors.add("mu_out", {cosines}, axis);
    const std::vector<double> around = even_azimuths(slice_azimuths);
    tensors.add("azimuth", {azimuths}, around);
    tensors.add("optical_depth", {colours.size()}, beam_depths(material));
    add_fluxes(colours, tensors);
    for (const LitSide side : lit_sides(material, colours)) {
        const Samples samples = sample(side, colours, mu, around, options.threads);
        const std::vector<std::size_t> shape{colours.size(), cosines, cosines, azimuths};
        const std::string name = lit_side_name(side);
        tensors.add(name, shape, samples.all_orders);
        tensors.add(name + "_multiple", shape, samples.multiple);
    }
    file.write = writing(tensors.finish());
    return file;
}

}  // namespace stratus
