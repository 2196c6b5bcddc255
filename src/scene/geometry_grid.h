// Grids over the directions that a scene sees, and what may lie between their points: the least value
// of a phase function, by its own curve, and the rise of a smooth function, by second differences.
#pragma once

#include <stratus/layer/single_scattering.h>
#include <stratus/phase/phase_function.h>
#include <stratus/scene/contents.h>

#include <cstddef>
#include <vector>

namespace stratus {

/// Grid points over a range of cosines, denser at grazing ones; 8 intervals a refinement, or one
/// point where the range is one value.
std::vector<double> cosines_over(const Range& range, int refinement);

/// The least value of a phase function between two scattering angles, from its curve.
class LeastPhase {
  public:
    explicit LeastPhase(const PhaseFunction& phase_function);

    double between(const Range& degrees) const;

  private:
    static constexpr int count = 3600;
    std::vector<double> curve_;
};

/// Geometries of one side on a grid: (mu_in, mu_out, azimuth).
struct GeometryGrid {
    Side side;
    std::vector<double> mu_in, mu_out, azimuth;
    std::vector<double> phase, least_phase;  // there, and between there and its neighbours
    std::vector<bool> seen;

    std::size_t at(std::size_t i, std::size_t j, std::size_t k) const {
        return (i * mu_out.size() + j) * azimuth.size() + k;
    }
    std::size_t size() const { return mu_in.size() * mu_out.size() * azimuth.size(); }
};

/// Over a box of directions; seen are points with one of the scattering angles (degrees) between
/// them and their neighbours.
GeometryGrid grid_of(Side side, const SeenDirections& directions, const Range& scattering_angles,
                     const PhaseFunction& phase_function, const LeastPhase& least, int refinement);

/// What a function may rise by between grid points: its second differences along each axis, of
/// points that are neighbours, over 4 (a parabola rises by their eighth).
std::vector<double> rises(const GeometryGrid& grid, const std::vector<double>& value);

}  // namespace stratus
