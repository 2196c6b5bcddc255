// Keys of scene files, with units, ranges and defaults; docs/scenes.md shows them.
#pragma once

#include <stratus/bake/keys.h>

namespace stratus {

/// Tables that may stand under several keys have rows of their own: "surface" is that of
/// planet.surface, rings.surface and slab.surface.
Keys scene_keys();

}  // namespace stratus
