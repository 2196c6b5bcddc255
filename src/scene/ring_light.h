// Rings: the area that a sample covers, then the light of a radius.
//
// Antialiasing of rings by area: a sample stands for a cell of the picture, and the light of every
// radius that the cell covers counts by its share of the cell, however narrow a ringlet is.
#pragma once

#include <stratus/base/axis.h>
#include <stratus/base/size.h>
#include <stratus/scene/layer_light.h>
#include <stratus/scene/scene.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace stratus {

/// The part of the picture that a sample stands for, in pixels.
struct Cell {
    const PictureRays& rays;
    double left, top, right, bottom;

    /// Through the middles of its sides: left, right, top, bottom.
    std::array<Ray, 4> sides() const;
};

/// How radii are distributed over a cell in which they change linearly: the sum of two uniform
/// distributions, one by columns, one by rows. Neighbouring cells share their sides, so that all
/// together count every radius once.
class RingFootprint {
  public:
    /// One radius alone.
    explicit RingFootprint(double radius) : centre_(radius) {}
    /// Radii at the middles of the cell's sides; infinite where the cell sees the plane end, which
    /// makes it a point.
    RingFootprint(double radius, const std::array<double, 4>& sides);

    double begin() const { return centre_ - (wide_ + narrow_) / 2; }
    double end() const { return centre_ + (wide_ + narrow_) / 2; }
    /// Share of the cell within a radius.
    double within(double radius) const;

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
        return size(next - radius.begin()) - 1;
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

/// The place of the lower end of the interval between ascending numbers in which one lies, or which is nearest.
inline std::size_t interval_with(const std::vector<double>& ends, double value) {
    const auto above = std::lower_bound(ends.begin() + 1, ends.end() - 1, value);
    return size(above - ends.begin()) - 1;
}

// Light of rings that a picture asks for at many places, tabulated beforehand: orders n >= 2 towards the
// camera, ringshine and planetshine.

struct View;

/// Where a point is seen from the z axis among `count` azimuths, the first along x: four of them, and
/// their weights.
struct AzimuthPlace {
    std::array<std::size_t, 4> column{};
    std::array<double, 4> weight{};

    AzimuthPlace() = default;
    AzimuthPlace(const Vector3& point, std::size_t count) {
        const double turn = std::atan2(point.y, point.x) / (2 * pi),
                     along = (turn - std::floor(turn)) * static_cast<double>(count),
                     first = std::floor(along), t = along - first;
        for (std::size_t k = 0; k < 4; ++k)
            column[k] = (static_cast<std::size_t>(first) + k + count - 1) % count;
        weight = {-t * (t - 1) * (t - 2) / 6, (t * t - 1) * (t - 2) / 2, -t * (t + 1) * (t - 2) / 2,
                  t * (t * t - 1) / 6};
    }

    /// Among uneven azimuths, ascending from 0 to less than 2 pi, as `azimuth` is.
    AzimuthPlace(double azimuth, const std::vector<double>& uneven) {
        const std::size_t count = uneven.size();
        const auto next = std::upper_bound(uneven.begin(), uneven.end(), azimuth);
        std::array<double, 4> at;
        for (std::size_t k = 0; k < 4; ++k) {
            const std::size_t turned = size(next - uneven.begin()) + k + count - 2;
            column[k] = turned % count;
            at[k] = uneven[column[k]] + 2 * pi * (static_cast<double>(turned / count) - 1);
        }
        weight.fill(1);  // of Lagrange
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t j = 0; j < 4; ++j)
                if (j != k) weight[k] *= (azimuth - at[j]) / (at[k] - at[j]);
    }

    /// Interpolates values at all azimuths.
    Rgb3 interpolated(const Rgb3* values) const {
        Rgb3 sum{};
        for (std::size_t k = 0; k < 4; ++k) sum += weight[k] * values[column[k]];
        return sum;
    }
};

// Orders n >= 2 of sunlight that rings scatter towards the camera, tabulated over radius and azimuth:
// each point of the rings is seen along one direction, and a picture asks for nearly the same radii
// in all of its samples.
class RingOrders {
  public:
    /// `light` must have tables.
    ///
    /// Accuracy a twentieth of the scene's tolerance where it is not empty.
    RingOrders(const Scene& scene, const Rings& rings, const LayerLight& light, int threads,
               LightDetail detail);

    /// Whether it has no values: of a camera so close that azimuths would have to be too many.
    bool empty() const { return grid_.empty(); }

    /// Returns the place of a point of the rings, for `light`.
    AzimuthPlace place(const Vector3& point) const { return {point, azimuth_count_}; }

    /// R or diffuse T, whichever the camera sees.
    Rgb3 light(const AzimuthPlace& place, double radius) const;

  private:
    Rgb3 at(const AzimuthPlace& place, std::size_t node) const;

    std::size_t azimuth_count_;
    std::vector<double>
        radius_;              // ends of intervals, in each of which a parabola joins three nodes
    std::vector<Rgb3> grid_;  // over node and azimuth
};

// Ringshine: diffuse light off and through rings that falls on their planet.
//
// The irradiance of the globe at p, with normal n, over the sun's on a surface that faces it, is the
// integral over the rings that rise above p's horizon, q with v = q - p and n v > 0:
//
//     E(p) = (1/pi) integral of I(q -> p) (n v / d) (|p_z| / d) / d^2 dA,   d = |v|
//
// I is pi times radiance over the sun's irradiance: mu0 R where p and the sun are on one side of the
// rings, else mu0 T, and 0 in the planet's shadow. Horizon and shadow bound the azimuths q may have
// at one radius: quadrature over radius and azimuth ends there. Light that rings scatter after the
// planet did is left out; so are opposition effects, which are narrower than the rings as the planet
// sees them, and the size of the sun.
class RingShine {
  public:
    /// Works E out on a grid of latitudes and local solar times. `layer` gives its
    /// orders n >= 2.
    ///
    /// Accuracy 5e-3 of E, 5e-6 where the rings hardly rise above the horizon; of light scattered
    ///          once for phase functions to asymmetry 0.9, of higher orders to 0.5. One radius stands
    ///          for a ringlet, 1/64 of all rings or less: not for a narrower one near the globe in a
    ///          wide ring that is fainter by up to 3e4.
    RingShine(const Scene& scene, const Rings& rings, const LayerLight& layer, int threads,
              LightDetail detail);

    /// E at a point of the globe, of a white sun, in parts: of the rings on either side of the point's
    /// meridian.
    static constexpr std::size_t parts = 2;
    using Sources = std::array<LightSource, parts>;
    Sources sources(const Vector3& point) const;

  private:
    struct Light;
    /// At the places of both hemispheres: above the lit side of the rings, and in darkness above the
    /// other. The sun is above the x axis, the place above the rings.
    PerSide<Sources> integrals(const Light& light, double latitude, double solar_time) const;

    Vector3 to_sun_;
    double sun_azimuth_, flattening_;
    bool shadows_;
    Axis latitude_, solar_time_;  // parametric, from the equator on; from the sun's meridian
    PerSide<std::array<std::vector<LightSource>, parts>> grid_;  // of either hemisphere
};

// Planetshine: light of a planet that falls on its rings.
//
// One half of the globe is above the rings and lights their upper face, the other their lower face.
// With L = pi I / F0 of the globe, by Lambert's law, ringshine included, a point of the rings adds
// to its radiance
//
//     (1/pi) integral of L(d) R(d, eye) |d_z| over directions d to the half on the eye's side,
//
// and the same with T over the other half. In units in which the globe is a sphere of radius 1, a
// point at radius r sees it within asin(1/r) of its centre; with sin(angle) = sin(chi) / r, chi in
// [0, pi/2], and the angle psi around the centre, nodes of Gauss crowd where light leaves the globe
// at grazing angles. Light that the rings return to the planet and back is left out.
//
// It is tabulated over radius and azimuth for all rings that one camera sees, as each of their points is
// seen along one direction.
class PlanetShine {
  public:
    /// `light` without planetshine.
    ///
    /// Accuracy 2e-3 of the rings' radiance, or of 5e-3 where they are darker.
    PlanetShine(const Scene& scene, const Rings& rings, const LayerLight& light, int threads,
                LightDetail detail);

    /// Light of the rings' matter at a radius, in the direction from their centre to `point`, where the
    /// view's ray meets them: for rays to the camera, interpolated.
    Rgb3 to_camera(const AzimuthPlace& place, double radius) const;
    AzimuthPlace place(const Vector3& point) const;

    /// For others, integrated.
    ///
    /// Range    directions that shine's table holds: those towards the camera, at least.
    static Rgb3 to_elsewhere(const Rings& rings, const View& view, const Vector3& point,
                             double radius, const Matter& matter);

  private:
    std::size_t azimuths_;
    double eye_azimuth_ = 0;
    std::vector<double> graded_azimuths_;  // of a close camera, from its own on; else they are even
    std::vector<double> radius_;  // every row of the profile, and between where light changes
    std::vector<Rgb3> grid_;      // over radius and azimuth
};

}  // namespace stratus
