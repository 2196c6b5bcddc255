// Monte Carlo in a homogeneous layer: a reference solver that shares nothing with the solver but
// the closed form of single scattering.
//
// Photons carry a weight; their flights are forced to end inside the layer, and Russian roulette
// ends paths of low weight. Before each flight the expected contribution of its collision to every
// requested direction is tallied (next-event estimation), averaged over the whole flight: a flight
// is a beam onto the part of the layer ahead, which scatters it once. One path serves all
// geometries of its mu_in. Order 1 is the closed form; photons estimate n >= 2.
//
// In a forward peak few photons fly nearly towards an exit, and those few count thousands of times.
// Paths are therefore also followed back from the exits, against the light, and each flight of a
// photon is joined to each of theirs by one collision. The layer is plane, so that flights which
// overlap in depth meet: the joint is single scattering by what both cross. A path of n collisions
// arises in several ways, joined at one or another of its last collisions. Each way counts with the
// share (1/phi at the joint) / (sum of 1/phi over these collisions); the shares of a path sum to 1
// and no way counts more than the smallest phi.
#pragma once

#include <stratus/layer/single_scattering.h>
#include <stratus/phase/phase_function.h>
#include <stratus/transfer/solve.h>

#include <cstdint>
#include <functional>
#include <vector>

namespace stratus {

/// Calls body(i) once for every i = 0 .. count - 1, in any order, on any threads.
using ParallelFor = std::function<void(int count, const std::function<void(int)>& body)>;

struct PhotonOptions {
    std::uint64_t photons = 1'000'000;  // per distinct mu_in and for uniform illumination, >= 2
    std::uint64_t seed = 1;
    int highest_order = 0;        // paths end after this many scatterings; 0: followed to their end
    int backward_collisions = 0;  // of paths from the exits, [0, 100]; 0: next-event estimation
    ParallelFor parallel_for;     // none: serial
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
    Estimate single;  // the photons' estimate of value.single, from their first collisions
};

struct PhotonGeometry {
    Geometry geometry{};
    PhotonValue reflection, transmission;
};

/// Fluxes of all orders followed, relative to the incident flux.
struct PhotonFluxes {
    Estimate albedo;         // plane or spherical
    Estimate transmittance;  // diffuse
    Estimate absorptance;
    double direct_transmittance = 1;  // closed form
};

struct PhotonSolution {
    std::vector<PhotonGeometry> geometries;  // as requested
    std::vector<double> mu_in;               // the distinct ones, in order of appearance
    std::vector<PhotonFluxes> plane;         // at mu_in
    PhotonFluxes uniform;                    // under uniform illumination
};

/// R, T and fluxes of one layer from photons.
///
/// Range    albedo [0, 1]; optical_depth [0, inf], finite at albedo 1 when all orders are followed;
///          cosines (0, 1].
/// Errors   std::invalid_argument naming argument, range and value; std::runtime_error when a
///          photon has not ended after 1e8 collisions.
/// Accuracy unbiased for every phase function, negative lobes of moment series included. Standard
///          errors are reliable (spread over seeds within 20 % of them from 5000 photons on) up to
///          g = 0.75, grazing cosines and layers of 1e-6 included; up to g = 0.99 and for a water
///          cloud's 768 moments from 10,000 photons on with 8 backward collisions. They are too
///          small where few photons carry the answer: forward peaks without backward collisions
///          (g = 0.99: 1e6 photons are not enough), T of absorbing layers below 1e-5 (below 1e-4
///          where paths end after a few orders), and, for `single` alone, cosines below 0.02.
///          Legendre series are tabulated, to 1e-7 of their values.
/// Cost     photons x collisions x geometries x (1 + backward_collisions); collisions grow like the
///          depth at w = 1.
/// Threads  bit-identical with every `parallel_for`; results of a beam depend on its mu_in only, with
///          backward collisions on its geometries too.
PhotonSolution solve_photons(const PhaseFunction& phase_function, double albedo,
                             double optical_depth, const std::vector<Geometry>& geometries,
                             const PhotonOptions& options = {});

}  // namespace stratus
