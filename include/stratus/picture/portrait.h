// A table's portrait: one PNG that shows at a glance what was baked.
//
// For up to four optical depths spread over the table, side by side: the light that leaves the
// layer in the plane of incidence for a beam from 60 degrees, drawn as in figure 8 of [Blinn82]
// (the radius is R mu_out above, T mu_out below, so that a thin layer draws its phase function and
// a white Lambert surface a circle), and a sphere covered with the layer, lit once and through all
// orders (I/F = mu_in R). Every value comes from the runtime lookup.
#pragma once

#include <stratus/runtime/table.h>

#include <filesystem>

namespace stratus {

/// In pixels.
struct PictureSize {
    int width;
    int height;
};

/// Size of a table's portrait: 1600 wide, as high as what the table holds needs.
PictureSize portrait_size(const Table& table);

/// Draws the portrait of a prepared table to `png` itself; callers who need it whole or not at all
/// wrap it.
///
/// Errors   std::runtime_error naming the path and the reason when the file cannot be written.
void draw_portrait(const Table& table, const std::filesystem::path& png);

}  // namespace stratus
