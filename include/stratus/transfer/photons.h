// Photons followed one by one through a homogeneous layer: a witness that shares nothing with the
// solver.
//
// Every photon carries a weight. Its flights are forced to end inside the layer, at each collision
// the share that would leave towards every asked direction without colliding again is booked
// (next-event estimation), and Russian roulette ends paths that hardly matter. One path serves all
// geometries of its mu_in. Order 1 of R and T is the closed form; photons estimate n >= 2.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <stratus/runtime/phase_function.h>
#include <stratus/runtime/single_scattering.h>
#include <stratus/transfer/solve.h>

namespace stratus {

/// Calls body(i) once for every i = 0 .. count - 1, in any order, on any threads.
using ParallelFor = std::function<void(int count, const std::function<void(int)>& body)>;

struct PhotonOptions {
    std::uint64_t photons = 1'000'000;  // for each distinct mu_in and once for uniform light, >= 2
    std::uint64_t seed = 1;
    int highest_order = 0;     // paths end after this many scatterings; 0: followed to their end
    ParallelFor parallel_for;  // none: one after another
};

/// A mean and its standard error, from the spread of single photons.
struct Estimate {
    double value = 0;
    double standard_error = 0;
};

/// R or T at one geometry.
struct PhotonValue {
    SolvedValue value{};        // single is the closed form; single + multiple = total
    double standard_error = 0;  // of multiple, hence of total
    Estimate single;            // the photons' own estimate of value.single
};

struct PhotonGeometry {
    Geometry geometry{};
    PhotonValue reflection, transmission;
};

/// Fluxes of all orders followed, as shares of the light that comes in.
struct PhotonFluxes {
    Estimate albedo;         // plane or spherical
    Estimate transmittance;  // diffuse
    Estimate absorptance;
    double direct_transmittance = 1;  // closed form
};

struct PhotonSolution {
    std::vector<PhotonGeometry> geometries;  // as asked
    std::vector<double> mu_in;               // the distinct ones, in order of appearance
    std::vector<PhotonFluxes> plane;         // at mu_in
    PhotonFluxes uniform;                    // under uniform illumination
};

/// R, T and fluxes of one layer from photons.
///
/// Range    albedo [0, 1]; optical_depth [0, inf], finite when every photon is followed to its end
///          without absorption; cosines (0, 1].
/// Errors   std::invalid_argument naming argument, range and value; std::runtime_error when a
///          photon has not ended after 1e8 collisions.
/// Accuracy unbiased for every phase function, negative lobes of moment series included. The
///          standard error is honest where no rare photon carries much: not within a few widths of
///          a forward peak of g > 0.9 and not at cosines below 0.01.
/// Cost     photons x collisions x geometries; collisions grow like the depth at w = 1.
/// Threads  the same bits with every `parallel_for`; a beam's numbers depend on its own mu_in only.
PhotonSolution solve_photons(const PhaseFunction& phase_function, double albedo,
                             double optical_depth, const std::vector<Geometry>& geometries,
                             const PhotonOptions& options = {});

}  // namespace stratus
