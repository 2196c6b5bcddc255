#include <stratus/material/material.h>

#include "indices.h"
#include "material_check.h"
#include "mqdiffuse_reader.h"
#include "refusal.h"

#include <gtest/gtest.h>

namespace stratus::test {
namespace {

MqdiffuseReader grid_of(const Stack& stack) {
    const TemporaryFolder folder;
    write_material(make_material({{stack}, ""}, MaterialFormat::netcdf), folder / "m.nc");
    return MqdiffuseReader(folder / "m.nc");
}

// phi_d is 0 back to the light: azimuth pi.
double reflected(const MqdiffuseReader& grid, const Geometry& at) {
    return pi * grid(at.mu_out, pi - at.azimuth, at.mu_in);
}

TEST(Mqdiffuse, IsTheSolverAtRandomPairs) {
    for (const Stack& stack :
         {layer("henyey_greenstein:g=0.5", 0.9, 1), layer("rayleigh", 1, infinity),
          over(layer("henyey_greenstein:g=0.7", 0.95, 0.5), 0.3)}) {
        const MqdiffuseReader grid = grid_of(stack);
        Errors errors;
        for (const Expected& at : random_geometries(stack, 500, 0.05)) {
            errors.add(reflected(grid, at.geometry), at.reflection);
            // the other way round, from the other side of the circle
            const double mirrored =
                pi * grid(at.geometry.mu_in, pi + at.geometry.azimuth, at.geometry.mu_out);
            EXPECT_NEAR(mirrored, reflected(grid, at.geometry), 1e-5 * mirrored);
        }
        EXPECT_LE(errors.quantile(0.5), 1e-3);
        EXPECT_LE(errors.quantile(0.99), 1e-2);
    }
}

TEST(Mqdiffuse, HasEvenAxes) {
    const MqdiffuseReader grid = grid_of(layer("isotropic", 0.9, 1));
    for (const std::size_t d : {std::size_t{0}, std::size_t{2}}) {
        const std::vector<double>& cosines = grid.axes[d];
        for (const auto k : indices(cosines))
            EXPECT_NEAR(cosines[k],
                        static_cast<double>(k) / static_cast<double>(cosines.size() - 1), 1e-15);
    }
    const std::vector<double>& phi = grid.axes[1];
    for (const auto k : indices(phi))
        EXPECT_NEAR(phi[k], 2 * pi * static_cast<double>(k) / static_cast<double>(phi.size()),
                    1e-14);
}

TEST(Mqdiffuse, LosesNoLightInAWhiteFurnace) {
    const MqdiffuseReader grid = grid_of(layer("henyey_greenstein:g=0.3", 1, infinity));
    for (const double mu_in : {0.1, 0.505, 0.93})
        EXPECT_NEAR(sent_out([&](double mu, double azimuth) {
                        return reflected(grid, {mu_in, mu, azimuth});
                    }),
                    1, 2e-4);
}

TEST(Mqdiffuse, RefusesColours) {
    const Stack grey = layer("isotropic", 0.9, 1);
    EXPECT_EQ(refusal([&] {
                  make_material({{grey, grey, grey}, ""}, MaterialFormat::netcdf);
              }),
              "export: colours of netcdf must be one, it holds grey, got 3");
}

}  // namespace
}  // namespace stratus::test
