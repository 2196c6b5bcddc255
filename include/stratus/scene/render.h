// Rendering: what light each pixel of a scene sends to the camera.
//
// A pixel is the mean over a regular grid of samples in it. The same bits on any number of
// threads, and whether a pixel is asked for alone or with all others.
#pragma once

#include <stratus/io/image.h>
#include <stratus/scene/layer_light.h>
#include <stratus/scene/scene.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace stratus {

/// Radiance of one pixel, (0, 0) the upper left one, over that of a white Lambert surface that
/// faces the sun.
///
/// Threads  any number may share scene and light.
Rgb radiance(const Scene& scene, const LayerLight& light, int x, int y);

/// Along one ray, with the sun in one direction.
Rgb3 radiance_along(const Scene& scene, const LayerLight& light, const Ray& ray,
                    const Vector3& to_sun);

/// Directions to a sun: its centre, or equal shares of its disk, a whole number of them for each
/// sample of a pixel, which share them out.
std::vector<Vector3> sun_directions(const Scene& scene);

struct RenderOptions {
    int threads = 0;  // 0: all
    std::function<void(double done, const std::string& stage)> progress;
};

/// A whole picture.
Image render(const Scene& scene, const LayerLight& light, const RenderOptions& options = {});

/// Pictures of one size side by side, row after row of `columns`.
Image side_by_side(const std::vector<Image>& pictures, int columns);

}  // namespace stratus
