// Antialiasing of rings by area: a sample stands for a cell of the picture, and the light of every
// radius that the cell covers counts by its share of the cell, however narrow a ringlet is.
#pragma once

#include <stratus/base/constants.h>
#include <stratus/scene/scene.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace stratus {

/// The part of the picture that a sample stands for, in pixels.
struct Cell {
    const PictureRays& rays;
    double left, top, right, bottom;

    /// Through the middles of its sides: left, right, top, bottom.
    std::array<Ray, 4> sides() const noexcept;
};

/// How radii are distributed over a cell in which they change linearly: the sum of two uniform
/// distributions, one by columns, one by rows. Neighbouring cells share their sides, so that all
/// together count every radius once.
class RingFootprint {
  public:
    /// One radius alone.
    explicit RingFootprint(double radius) noexcept : centre_(radius) {}
    /// Radii at the middles of the cell's sides; infinite where the cell sees the plane end, which
    /// makes it a point.
    RingFootprint(double radius, const std::array<double, 4>& sides) noexcept;

    double begin() const noexcept { return centre_ - (wide_ + narrow_) / 2; }
    double end() const noexcept { return centre_ + (wide_ + narrow_) / 2; }
    /// Share of the cell within a radius.
    double within(double radius) const noexcept;

    /// Calls visit(matter, radius, share), shares of the cell whose sum is 1, so that a mean over them is
    /// that over the cell: between two rows of the profile two Gauss nodes for each unit of
    /// `slant` times the change of optical depth, up to 16, so that light falling off as
    /// exp(-slant tau) is right to 3e-4. Where more than 8 pairs of rows are covered, one radius,
    /// at a place that varies, stands for each pair, and where more than 64, for several of them.
    /// The mean of many cells is right then too; that of one has a standard deviation of that of the
    /// light within what a radius stands for, over the root of their number.
    template <class Visit>
    void visit(const RingProfile& profile, const Rgb3& tint, double slant,
               const Visit& visit) const;

  private:
    static constexpr std::size_t max_exact_pairs = 8, max_places = 64;

    double centre_, wide_ = 0, narrow_ = 0;  // widths of the two distributions
};

template <class Visit>
void RingFootprint::visit(const RingProfile& profile, const Rgb3& tint, double slant,
                          const Visit& visit) const {
    if (wide_ == 0) return visit(profile.at(centre_, tint), centre_, 1.0);
    const auto& radius = profile.radius;
    const double from = std::max(begin(), profile.inner()), to = std::min(end(), profile.outer());
    const double inside = from < to ? within(to) - within(from) : 0;
    if (inside < 1) visit(Matter{}, infinity, 1 - inside);
    if (inside <= 0) return;
    auto row_before = [&](double at) {
        const auto next = std::upper_bound(radius.begin() + 1, radius.end() - 1, at);
        return static_cast<std::size_t>(next - radius.begin()) - 1;
    };
    const std::size_t first = row_before(from),
                      last = to <= radius[first + 1] ? first + 1 : row_before(to) + 1;
    const std::size_t pairs = last - first, together = (pairs + max_places - 1) / max_places;
    double place = centre_ * 1e5;  // of the radius that stands for others
    for (std::size_t k = first; k < last; k += together) {
        const double lo = std::max(from, radius[k]),
                     hi = std::min(to, radius[std::min(k + together, last)]);
        if (pairs > max_exact_pairs) {
            place += std::numbers::phi;
            const double at = lo + (place - std::floor(place)) * (hi - lo);
            visit(profile.at(at, tint), at, within(hi) - within(lo));
            continue;
        }
        const auto& depth = profile.optical_depth;
        const double change =
            slant * std::abs(depth[k + 1] - depth[k]) * (hi - lo) / (radius[k + 1] - radius[k]);
        if (!(change >= 0.1)) {
            const double at = (lo + hi) / 2;
            visit(profile.after(k, at, tint), at, within(hi) - within(lo));
            continue;
        }
        const int panels = static_cast<int>(std::clamp(std::ceil(change), 1.0, 8.0));
        const double width = (hi - lo) / panels;
        for (int p = 0; p < panels; ++p) {
            const double middle = lo + (p + 0.5) * width;
            const double share = within(middle + width / 2) - within(middle - width / 2);
            for (const double side : {-0.5, 0.5}) {
                const double at = middle + side * width * std::numbers::inv_sqrt3;
                visit(profile.after(k, at, tint), at, share / 2);
            }
        }
    }
}

}  // namespace stratus
