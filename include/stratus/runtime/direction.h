// Directions at a surface, as slices and BSDFs take them.
#pragma once

namespace stratus {

/// A direction in the local frame of a surface, z along its normal; of unit length, to which no
/// lookup brings it, pointing away from the surface: towards the light, or towards the eye.
struct Vector {
    float x, y, z;
};

}  // namespace stratus
