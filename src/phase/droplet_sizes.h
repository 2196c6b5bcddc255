// The sizes that stand for a distribution of droplets.
#pragma once

#include <stratus/phase/mie.h>

#include "mie_scattering.h"

#include <vector>

namespace stratus {

constexpr int sizes_of_a_distribution = 2000;

/// Radii between which droplets count, over the effective radius.
struct RadiusRange {
    double min, max;
};

RadiusRange radius_range(const Droplets& droplets);

/// One sphere, or `count` of them uniform in the square root of the radius: dense where the droplets
/// are; large ones, which are few and costly, lie further apart.
std::vector<SphereSize> sphere_sizes(const Droplets& droplets, int count = sizes_of_a_distribution);

}  // namespace stratus
