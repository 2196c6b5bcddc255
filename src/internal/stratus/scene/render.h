// Rendering: the radiance of each pixel of a scene.
//
// A pixel is the mean over a regular grid of samples in it; rings count by area, however narrow a
// ringlet is. The same bits on any number of threads, and for a pixel alone or with all others.
#pragma once

#include <stratus/picture/portrait.h>
#include <stratus/scene/layer_light.h>
#include <stratus/scene/scene.h>
#include <stratus/table/table.h>

#include <functional>

namespace stratus {

/// Radiance of one pixel, (0, 0) the upper left one, relative to a white Lambert surface that faces
/// the sun.
///
/// Threads  any number may share scene and light.
Rgb radiance(const Scene& scene, const LayerLight& light, int x, int y);

/// Along one ray, with the sun in one direction.
///
/// Range    directions that the light's tables hold: those baked for the scene may hold no more than
///          its camera sees (needed_recipes, layer_tables.h).
Rgb3 radiance_along(const Scene& scene, const LayerLight& light, const Ray& ray,
                    const Vector3& to_sun);

/// Directions to the sun: its centre, or equal parts of its disk, a multiple of the samples of a
/// pixel, which share them out.
std::vector<Vector3> sun_directions(const Scene& scene);

struct RenderOptions {
    int threads = 0;    // 0: all
    int row_step = 1;   // one row of so many; the others stay black
    bool finer = true;  // more samples where a pixel covers many waves of clouds or of a surface
    std::function<void(double done, const std::string& stage)> progress;
};

/// Rays and suns that are seen together in one row of so many: samples squared a pixel, a sun or several
/// each, and more where a pixel covers many waves of clouds or of a surface.
double sample_count(const Scene& scene, int row_step = 1);

/// The whole picture.
Image render(const Scene& scene, const LayerLight& light, const RenderOptions& options = {});

/// The panels of one of a film's frames, side by side, each in the light of its tables, which are those
/// of all_panels(film) (layer_tables.h).
Image render(const Film& film, int frame, const SceneTables& tables,
             const RenderOptions& options = {});

/// Pictures of one size side by side, row after row of `columns`.
Image side_by_side(const std::vector<Image>& pictures, int columns);

// The content of a table's portrait: lobes are looked up, spheres rendered as scenes.

/// The portrait of a table, by its header and its lookups; a family is shown at its middle.
///
/// Range    tables whose mu_in and mu_out have the same axis.
/// Threads  renders on all.
Portrait make_portrait(const Table& header, const TableView& whole);

}  // namespace stratus
