// A table's portrait: one PNG that shows at a glance what was baked. scene/table_portrait.h
// computes its content.
//
// For some optical depths, side by side: lobes in the plane of incidence as in figure 8 of
// [Blinn82] (the radius is R mu_out above, T mu_out below, so that a thin layer draws its phase
// function and a white Lambert surface a circle), and a sphere covered with the layer, by single
// scattering and by all orders.
#pragma once

#include <stratus/io/image.h>
#include <stratus/picture/plots.h>

namespace stratus {

struct PortraitColumn {
    double optical_depth = 0;
    double beam_transmittance = 0;  // share of the beam that leaves the layer below
    // Radii above and below the layer; empty where the table has no such side.
    LobeCurve single;
    std::vector<LobeCurve> all;  // one an albedo
    // Radiance; squares of the same size, empty without reflection. The sphere fills its disc of
    // `sphere_radius` pixels about the centre.
    Image single_sphere, sphere;
};

struct Portrait {
    std::string title;
    std::vector<std::string> subtitles;  // two
    std::string orders;                  // in words, of what is in the table
    std::string lower_boundary;
    std::vector<double> albedos;  // up to three, descending; spheres have the first
    double beam_angle = 0;        // of the lobes, from the normal; radians
    double phase_angle = 0;       // of the spheres; radians
    bool has_reflection = false, has_transmission = false;
    std::vector<PortraitColumn> columns;  // up to four
    Image uncovered;  // share of each pixel of a sphere's square that is not on the disc
};

struct PictureSize {
    int width, height;  // pixels
};
PictureSize portrait_size(const Portrait& portrait);

/// Radius in pixels of the spheres of a portrait with so many columns.
double sphere_radius(std::size_t columns);

/// Draws to `png` itself; callers who need it whole or not at all wrap it.
///
/// Errors   std::runtime_error naming the path and the reason when the file cannot be written.
void draw_portrait(const Portrait& portrait, const std::filesystem::path& png);

}  // namespace stratus
