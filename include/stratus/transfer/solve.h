// The solver: reflection and transmission of a homogeneous plane-parallel layer at any geometry.
//
// All azimuthal modes are doubled from a thin layer to the depth asked for; single scattering is
// taken out of every mode in closed form and added again with the exact phase function, so that the
// Fourier series only carries orders n >= 2. Conventions of the project (README): R = pi I / (mu0
// F0), T its diffuse counterpart, f = f_0 + 2 sum f_m cos(m dphi).
#pragma once

#include <stratus/runtime/lower_boundary.h>
#include <stratus/runtime/phase_function.h>
#include <stratus/runtime/single_scattering.h>
#include <stratus/transfer/forward_peak.h>
#include <stratus/transfer/truncation.h>

#include <Eigen/Core>

#include <limits>
#include <memory>
#include <vector>

namespace stratus {

enum class Scheme {
    harmonic,  // doubling as an arithmetic-harmonic mean (lanes/doubling.cpp)
    classic,   // textbook doubling: LU of I - R R (classic.cpp)
};

/// The thin layer that textbook doubling starts from.
enum class ClassicStart {
    single,   // single scattering in closed form: error of the first order in its depth
    diamond,  // of the second order [W76]
};

/// What is done to a forward peak that the nodes do not resolve (truncation.h).
enum class Truncate {
    nothing,
    delta_m,  // delta-M, with the single-scattering correction
    smooth,   // large shares smoothly, with all that the peak scatters put back; in stacks and
              // over something that lies beneath sharply as well
};

struct SolverOptions {
    int nodes = 32;  // Gauss nodes in (0, 1), [1, 512]
    int modes = 0;   // azimuthal modes solved; 0: until only single scattering is left
    int orders = 0;  // [0, 200]; light scattered more often than that is left out; 0: all
    Scheme scheme = Scheme::harmonic;
    ClassicStart start = ClassicStart::diamond;  // classic only
    double start_depth = 0;  // classic only: start at tau / 2^n <= this, [1e-15, 1]; 0: at 1e-3 of
                             // the smallest cosine
    Truncate truncate = Truncate::smooth;
    double mode_tolerance = 1e-14;  // with modes = 0: what counts as nothing, relative to R and T
};

/// R or T at one geometry. single + multiple = total to rounding; single is the closed form of the
/// layer itself.
struct SolvedValue {
    double total;
    double single;
    double multiple;
};

/// What truncation took away, at one pair of cosines: TMS less the closed form of the layer itself,
/// and what the peak scatters more than once (forward_peak.h). Nothing without truncation.
struct PeakCorrection {
    double single = 0;  // per unit of phase function
    std::vector<double> legendre;

    double operator()(double phase_value, double cos_scattering_angle) const {
        return single * phase_value + sum_legendre(legendre, cos_scattering_angle);
    }
};

/// A layer of one albedo and depth, solved at a list of cosines. Over something that lies beneath
/// it transmission is 0, and reflection is that of both; `single` then counts light that met what
/// lies beneath once and nothing else.
class LayerSolution {
  public:
    double albedo = 0;
    double optical_depth = 0;
    Eigen::VectorXd mu;  // the cosines asked for; the Gauss nodes if none were

    // weight of order n in everything here, w^n or 0; empty: all orders
    Eigen::VectorXd order_weights;

    // Orders n >= 2 of mode m between mu(i) and mu(j), of the problem after truncation.
    std::vector<Eigen::MatrixXd> reflection_modes;
    std::vector<Eigen::MatrixXd> transmission_modes;

    // Fluxes of all orders. [HT74]
    Eigen::VectorXd plane_albedo;           // at mu
    Eigen::VectorXd diffuse_transmittance;  // at mu
    double spherical_albedo = 0;            // URU
    double total_transmittance = 1;         // UTU: uniform illumination, diffuse and beam

    /// R between mu(in) and mu(out) at an azimuth in radians, or at many: what truncation took out
    /// is then worked out once.
    SolvedValue reflection(int in, int out, double azimuth) const;
    std::vector<SolvedValue> reflection(int in, int out, const std::vector<double>& azimuths) const;
    /// Diffuse T likewise.
    SolvedValue transmission(int in, int out, double azimuth) const;
    std::vector<SolvedValue> transmission(int in, int out,
                                          const std::vector<double>& azimuths) const;

    /// How far below 0 R and T fall between any of mu at any azimuth, as a share of their largest
    /// value (both times mu + mu0, which takes out their growth at grazing angles); 0 when nowhere.
    ///
    /// Only a truncated phase series that is itself negative brings them there: more nodes help.
    double most_negative() const;

    // What truncation took out of R (out of T) between mu(in) and mu(out), to be added to the
    // modes.
    PeakCorrection reflection_correction(int in, int out) const;
    PeakCorrection transmission_correction(int in, int out) const;

    /// The same of light scattered once by the lower boundary, per unit of its phase function.
    double boundary_correction(int in, int out) const;
    Eigen::MatrixXd boundary_correction() const;

    PhaseFunction phase_function;
    Truncation truncation;
    LowerBoundary lower_boundary;
    Truncation boundary_truncation;
    std::shared_ptr<const ForwardPeak> peak;  // null unless truncation is narrow
};

/// Solves one layer at the cosines `mu`.
///
/// Range    albedo [0, 1]; optical_depth [0, inf]; mu in [1e-100, 1], none: at the Gauss nodes;
///          options as stated there.
/// Errors   std::invalid_argument naming argument, range and value.
/// Accuracy to rounding as nodes grow (README); energy is conserved to 1e-13 at w = 1 for every
///          depth.
/// Cost     2.3 N^3 operations a doubling and mode, N = nodes; some 30 doublings.
LayerSolution solve_layer(const PhaseFunction& phase_function, double albedo, double optical_depth,
                          const std::vector<double>& mu, const SolverOptions& options = {},
                          const LowerBoundary& boundary = {});

/// The Neumann orders 1 to `options.orders` one by one: result[n - 1] is the light scattered
/// exactly n times, w^n times the order of the series; its total_transmittance leaves out the beam.
///
/// Range    options.orders [1, 200], with the harmonic scheme; the rest as for solve_layer.
/// Accuracy every order to rounding, however weak (src/transfer/ordered_ladder.h).
std::vector<LayerSolution> solve_orders(const PhaseFunction& phase_function, double albedo,
                                        double optical_depth, const std::vector<double>& mu,
                                        const SolverOptions& options);

/// Depths that one run of doubling passes through: first, 2 first, 4 first, ... (`octaves` of
/// them), then infinity.
struct DepthLadder {
    double first = 1;
    int octaves = 1;
    bool to_infinity = false;
};

/// Solves several albedos at all depths of a ladder: result[a][d], infinity last. What lies beneath
/// is solved once and serves all depths.
std::vector<std::vector<LayerSolution>> solve_ladder(const PhaseFunction& phase_function,
                                                     const std::vector<double>& albedos,
                                                     const DepthLadder& ladder,
                                                     const std::vector<double>& mu,
                                                     const SolverOptions& options = {},
                                                     const LowerBoundary& boundary = {});

/// Diffusion exponent k: light deep inside an unbounded medium decays as exp(-k tau). 0 at w = 1.
///
/// Source   the smallest eigenvalue k^2 of B A in mode 0 (layer matrices), by inverse iteration.
double compute_diffusion_exponent(const PhaseFunction& phase_function, double albedo,
                                  const SolverOptions& options = {});

/// The same for several albedos: the phase kernels are worked out once.
std::vector<double> compute_diffusion_exponents(const PhaseFunction& phase_function,
                                                const std::vector<double>& albedos,
                                                const SolverOptions& options = {});

}  // namespace stratus
