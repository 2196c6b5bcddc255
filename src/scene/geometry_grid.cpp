#include "geometry_grid.h"

#include <stratus/base/angle.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace stratus {
namespace {

std::vector<double> azimuths_over(const Range& range, int refinement) {
    const int count = 12 * refinement + 1;
    if (range.max - range.min < 1e-9) return {radians(range.max)};
    std::vector<double> azimuths;
    for (int k = 0; k < count; ++k)
        azimuths.push_back(radians(range.min + (range.max - range.min) * k / (count - 1)));
    return azimuths;
}

double scattering_angle(Side side, const Geometry& geometry) {
    const double cosine = side == Side::reflection ? cos_scattering_angle_reflected(geometry)
                                                   : cos_scattering_angle_transmitted(geometry);
    return degrees(std::acos(std::clamp(cosine, -1.0, 1.0)));
}

}  // namespace

std::vector<double> cosines_over(const Range& range, int refinement) {
    const int count = 8 * refinement + 1;
    const double least = std::max(range.min, 1e-3), most = std::max(range.max, least);
    if (most - least < 1e-9) return {most};
    std::vector<double> cosines;
    for (int k = 0; k < count; ++k) {
        const double x = std::cbrt(least) + (std::cbrt(most) - std::cbrt(least)) * k / (count - 1);
        cosines.push_back(std::min(1.0, x * x * x));
    }
    cosines.back() = most;
    return cosines;
}

LeastPhase::LeastPhase(const PhaseFunction& phase_function) {
    for (int k = 0; k <= count; ++k)
        curve_.push_back(phase_function(std::cos(radians(180.0 * k / count))));
}

double LeastPhase::between(const Range& degrees) const {
    const int first = std::clamp(static_cast<int>(degrees.min * count / 180), 0, count),
              last = std::clamp(static_cast<int>(std::ceil(degrees.max * count / 180)), 0, count);
    return *std::min_element(curve_.begin() + first, curve_.begin() + last + 1);
}

GeometryGrid grid_of(Side side, const SeenDirections& directions, const Range& scattering_angles,
                     const PhaseFunction& phase_function, const LeastPhase& least, int refinement) {
    GeometryGrid grid{side,
                      cosines_over(directions.mu_in, refinement),
                      cosines_over(directions.mu_out, refinement),
                      azimuths_over(directions.azimuth, refinement),
                      {},
                      {},
                      {}};
    std::vector<double> angle(grid.size());
    const auto each = [&](const auto& visit) {
        for (std::size_t i = 0; i < grid.mu_in.size(); ++i)
            for (std::size_t j = 0; j < grid.mu_out.size(); ++j)
                for (std::size_t k = 0; k < grid.azimuth.size(); ++k) visit(i, j, k);
    };
    each([&](std::size_t i, std::size_t j, std::size_t k) {
        const double here =
            scattering_angle(side, {grid.mu_in[i], grid.mu_out[j], grid.azimuth[k]});
        angle[grid.at(i, j, k)] = here;
        grid.phase.push_back(phase_function(std::cos(radians(here))));
    });
    each([&](std::size_t i, std::size_t j, std::size_t k) {
        Range near{180, 0};
        const auto around = [](std::size_t at, std::size_t count) {
            return std::pair(at > 0 ? at - 1 : at, std::min(at + 1, count - 1));
        };
        const auto [i0, i1] = around(i, grid.mu_in.size());
        const auto [j0, j1] = around(j, grid.mu_out.size());
        const auto [k0, k1] = around(k, grid.azimuth.size());
        for (std::size_t a = i0; a <= i1; ++a)
            for (std::size_t b = j0; b <= j1; ++b)
                for (std::size_t c = k0; c <= k1; ++c) widen(near, angle[grid.at(a, b, c)]);
        const Range both{std::max(near.min, scattering_angles.min),
                         std::min(near.max, scattering_angles.max)};
        grid.seen.push_back(both.min <= both.max);
        grid.least_phase.push_back(both.min <= both.max ? least.between(both) : 0);
    });
    return grid;
}

std::vector<double> rises(const GeometryGrid& grid, const std::vector<double>& value) {
    std::vector<double> rise(value.size(), 0);
    const std::size_t counts[] = {grid.mu_in.size(), grid.mu_out.size(), grid.azimuth.size()};
    const std::size_t strides[] = {counts[1] * counts[2], counts[2], 1};
    for (int axis = 0; axis < 3; ++axis) {
        const std::size_t count = counts[axis], stride = strides[axis];
        if (count < 3) continue;
        std::vector<double> second(value.size(), 0), widest(value.size(), 0);
        for (std::size_t n = 0; n < value.size(); ++n) {
            const std::size_t at = n / stride % count;
            const std::size_t middle = at == 0 ? n + stride : at + 1 == count ? n - stride : n;
            second[n] =
                std::abs(value[middle - stride] - 2 * value[middle] + value[middle + stride]) / 4;
        }
        for (std::size_t n = 0; n < value.size(); ++n) {
            const std::size_t at = n / stride % count;
            widest[n] = second[n];
            if (at > 0) widest[n] = std::max(widest[n], second[n - stride]);
            if (at + 1 < count) widest[n] = std::max(widest[n], second[n + stride]);
            rise[n] += widest[n];
        }
    }
    return rise;
}

}  // namespace stratus
