#include "ring_footprint.h"

namespace stratus {

std::array<Ray, 4> Cell::sides() const noexcept {
    const double x = (left + right) / 2, y = (top + bottom) / 2;
    return {rays.through(left, y), rays.through(right, y), rays.through(x, top),
            rays.through(x, bottom)};
}

RingFootprint::RingFootprint(double radius, const std::array<double, 4>& sides) noexcept
    : centre_(radius) {
    const double sum = sides[0] + sides[1] + sides[2] + sides[3];
    if (!std::isfinite(sum)) return;
    const double by_columns = std::abs(sides[1] - sides[0]),
                 by_rows = std::abs(sides[3] - sides[2]);
    centre_ = sum / 4;
    wide_ = std::max(by_columns, by_rows);
    narrow_ = std::min(by_columns, by_rows);
}

double RingFootprint::within(double radius) const noexcept {
    const double beyond = std::abs(radius - centre_), flat = (wide_ - narrow_) / 2,
                 edge = (wide_ + narrow_) / 2;
    double outside = 0.5 - beyond / wide_;  // share farther out on the same side
    if (beyond >= edge)
        outside = 0;
    else if (beyond > flat)
        outside = (edge - beyond) * (edge - beyond) / (2 * wide_ * narrow_);
    return radius < centre_ ? outside : 1 - outside;
}

}  // namespace stratus
