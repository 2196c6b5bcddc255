// netCDF for Eradiate's mqdiffuse: the BRDF over (cos_theta_o, phi_d, cos_theta_i), evenly spaced.
//
// Both directions point away from the surface there, so that phi_d = 0 is back to the light:
// azimuth pi.
#include <stratus/bake/parallel.h>
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/size.h>
#include <stratus/io/write_options.h>

#include "solved_stack.h"

#include <cmath>
#include <memory>
#include <utility>

namespace stratus {
namespace {

constexpr int mqdiffuse_cosines = 101, mqdiffuse_azimuths = 72;  // 72: over 2 pi, the end left out

/// Where both cosines are 0 f has no limit. A third of a step off it is such that lines between the
/// samples meet 1 / (mu + mu0) amid the first cell.
constexpr double corner = 1.0 / (3 * (mqdiffuse_cosines - 1));

}  // namespace

MaterialFile make_mqdiffuse(const Material& material, const MaterialOptions& options) {
    require(material.colours.size() == 1, "export", "colours of netcdf", "one, it holds grey",
            material.colours.size());
    MaterialFile file;
    note_beam(material, file.notes);
    note_transmission(material, file.notes);
    std::vector<double> mu{grazing}, cosines{0}, phi, azimuths;
    for (int k = 1; k < mqdiffuse_cosines; ++k) cosines.push_back(k / (mqdiffuse_cosines - 1.0));
    mu.insert(mu.end(), cosines.begin() + 1, cosines.end());
    mu.push_back(corner);
    for (int k = 0; k < mqdiffuse_azimuths; ++k) {
        phi.push_back(2 * pi * k / mqdiffuse_azimuths);
        azimuths.push_back(std::abs(pi - phi.back()));
    }
    const SolvedStack solved = std::move(solve_colours(material, mu, options)[0]);
    const auto count = size(mqdiffuse_cosines);
    std::vector<float> brdf(count * mqdiffuse_azimuths * count);
    parallel_for(mqdiffuse_cosines, options.threads, [&](int out) {
        for (int in = out; in < mqdiffuse_cosines; ++in) {
            const bool at_corner = in == 0 && out == 0;
            const std::vector<SolvedValue> values = solved.reflection(
                at_corner ? mqdiffuse_cosines : in, at_corner ? mqdiffuse_cosines : out, azimuths);
            for (std::size_t a = 0; a < mqdiffuse_azimuths; ++a) {
                const auto i = size(in), o = size(out);
                brdf[(o * mqdiffuse_azimuths + a) * count + i] =
                    brdf[(i * mqdiffuse_azimuths + a) * count + o] =
                        static_cast<float>(values[a].total / pi);
            }
        }
    });
    auto grid = std::make_shared<NetcdfGrid>();
    grid->dimensions = {
        {"cos_theta_o", "1", "cosine of the outgoing zenith angle", cosines},
        {"phi_d", "rad", "azimuth between the directions, both away from the layer", phi},
        {"cos_theta_i", "1", "cosine of the incoming zenith angle", cosines}};
    grid->name = "brdf";
    grid->units = "sr**-1";
    grid->long_name = "BRDF, the cosine left out";
    grid->values = std::move(brdf);
    grid->attributes = {{"title", describe(material)}};
    file.write = [grid](const std::filesystem::path& path) { write_netcdf(*grid, path); };
    return file;
}

}  // namespace stratus
