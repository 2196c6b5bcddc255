#include <stratus/base/direction.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

double sine(double cosine) noexcept {
    return std::sqrt(std::max(0.0, (1 - cosine) * (1 + cosine)));
}

double horizontal_part(const Geometry& geometry) noexcept {
    return sine(geometry.mu_in) * sine(geometry.mu_out) * std::cos(geometry.azimuth);
}

}  // namespace

double cos_scattering_angle_reflected(const Geometry& geometry) noexcept {
    return std::clamp(horizontal_part(geometry) - geometry.mu_in * geometry.mu_out, -1.0, 1.0);
}

double cos_scattering_angle_transmitted(const Geometry& geometry) noexcept {
    return std::clamp(horizontal_part(geometry) + geometry.mu_in * geometry.mu_out, -1.0, 1.0);
}

}  // namespace stratus
