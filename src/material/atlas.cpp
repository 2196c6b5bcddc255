// Pictures for shaders: tiles of f (mu_in + mu_out) pi over azimuth and mu_out, one column of tiles
// for each mu_in, one row for each side.
#include <stratus/bake/parallel.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/io/image.h>

#include "solved_stack.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>
#include <string>
#include <utility>

namespace stratus {
namespace {

constexpr int atlas_cosines = 64, atlas_azimuths = 64;

Image draw_tiles(const std::vector<LitSide>& rows, const std::vector<SolvedStack>& colours,
                 const std::vector<double>& mu, int threads) {
    const std::vector<double> azimuths = even_azimuths(atlas_azimuths);
    const int row_count = static_cast<int>(rows.size());
    Image image(atlas_cosines * atlas_azimuths, row_count * atlas_cosines);
    parallel_for(row_count * atlas_cosines, threads, [&](int y) {
        const LitSide& row = rows[size(y / atlas_cosines)];
        const int out = y % atlas_cosines;
        for (int in = 0; in < atlas_cosines; ++in) {
            const double sum = mu[size(in)] + mu[size(out)];
            for (std::size_t c = 0; c < 3; ++c) {
                const SolvedStack& colour = colours[colours.size() == 1 ? 0 : c];
                if (colours.size() == 1 && c > 0) {
                    for (int a = 0; a < atlas_azimuths; ++a) {
                        float* const pixel = image.pixel(in * atlas_azimuths + a, y);
                        pixel[c] = pixel[0];
                    }
                    continue;
                }
                const std::vector<SolvedValue> values = (colour.*row.values)(in, out, azimuths);
                for (int a = 0; a < atlas_azimuths; ++a)
                    image.pixel(in * atlas_azimuths + a, y)[c] =
                        static_cast<float>(sum * values[size(a)].total);
            }
        }
    });
    return image;
}

std::string quoted(const std::string& text) {
    std::string quoted = "\"";
    for (const char letter : text) {
        if (letter == '"' || letter == '\\') quoted += '\\';
        quoted += static_cast<unsigned char>(letter) < 0x20 ? ' ' : letter;
    }
    return quoted + '"';
}

/// JSON has no infinity: null stands for it, of optical depths where nothing passes.
std::string number_json(double value) { return std::isinf(value) ? "null" : shortest_text(value); }

template <class Values>
std::string list_json(const Values& values) {
    std::string text;
    for (const double value : values) text += (text.empty() ? "" : ", ") + number_json(value);
    return "[" + text + "]";
}

/// One list for each colour.
template <class OfColour>
std::string lists_json(const std::vector<SolvedStack>& colours, const OfColour& of_colour) {
    std::string text;
    for (const SolvedStack& colour : colours)
        text += (text.empty() ? "" : ",\n    ") + list_json(of_colour(colour));
    return "[\n    " + text + "\n  ]";
}

std::string atlas_json(const Material& material, const std::vector<LitSide>& rows,
                       const std::vector<SolvedStack>& colours, const std::vector<double>& mu) {
    std::vector<double> mu_in = mu;
    mu_in[0] = 0;
    std::string names;
    for (const LitSide& row : rows)
        names += (names.empty() ? "\"" : ", \"") + std::string(row.name) + '"';
    std::ostringstream json;
    json << "{\n  \"format\": \"stratus-atlas\",\n  \"version\": 1,\n  \"material\": "
         << quoted(describe(material)) << ",\n  \"rows\": [" << names
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
         << ",\n  \"mu_in\": " << list_json(mu_in) << ",\n  \"plane_albedo\": "
         << lists_json(colours, [](const SolvedStack& of) { return of.solution().plane_albedo; })
         << ",\n  \"diffuse_transmittance\": "
         << lists_json(colours,
                       [](const SolvedStack& of) {
                           const auto& shares = of.solution().diffuse_transmittance;
                           return of.is_transparent()
                                      ? std::vector<double>(shares.begin(), shares.end())
                                      : std::vector<double>(size(shares.size()));
                       })
         << "\n}\n";
    return json.str();
}

}  // namespace

MaterialFile make_atlas(const Material& material, const MaterialOptions& options) {
    MaterialFile file;
    note_beam(material, file.notes);
    const std::vector<double> mu = even_cosines(atlas_cosines);
    const std::vector<SolvedStack> colours = solve_colours(material, mu, options);
    const std::vector<LitSide> rows = lit_sides(material, colours);
    const auto image =
        std::make_shared<const Image>(draw_tiles(rows, colours, mu, options.threads));
    file.json = atlas_json(material, rows, colours, mu);
    file.write = [image, json = file.json](const std::filesystem::path& path) {
        write_exr_image(*image, {{"stratus:atlas", json}}, path, Alpha::opaque);
    };
    return file;
}

}  // namespace stratus
