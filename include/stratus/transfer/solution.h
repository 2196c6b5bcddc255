// What the solver returns for one layer: its azimuthal modes, its fluxes, and R and T from them.
//
// The Fourier series carries orders n >= 2 of the truncated problem; single scattering is added in
// closed form with the exact phase function. Values at many directions: fourier_sum.h.
#pragma once

#include <stratus/runtime/lower_boundary.h>
#include <stratus/runtime/phase_function.h>
#include <stratus/runtime/single_scattering.h>
#include <stratus/transfer/forward_peak.h>
#include <stratus/transfer/truncation.h>

#include <Eigen/Core>

#include <memory>
#include <vector>

namespace stratus {

/// R or T at one geometry. single + multiple = total to rounding; single is the closed form of the
/// layer itself.
struct SolvedValue {
    double total;
    double single;
    double multiple;
};

/// What truncation took out at one pair of cosines: TMS less the closed form of the layer itself,
/// and what the peak scatters more than once (forward_peak.h). 0 without truncation.
struct PeakCorrection {
    double single = 0;  // per unit of phase function
    std::vector<double> legendre;

    double operator()(double phase_value, double cos_scattering_angle) const {
        return single * phase_value + sum_legendre(legendre, cos_scattering_angle);
    }
};

/// What every solution has at a list of cosines.
struct ModeSolution {
    Eigen::VectorXd mu;  // the cosines asked for; the Gauss nodes if none were
    LowerBoundary lower_boundary;
    Truncation boundary_truncation;

    // Orders n >= 2 of mode m of the problem after truncation, out of mu(i), into mu(j). T is 0 where
    // nothing is transmitted: at infinite depth and over a lower boundary.
    std::vector<Eigen::MatrixXd> reflection_modes;
    std::vector<Eigen::MatrixXd> transmission_modes;

    // Fluxes of all orders over the incident flux. [HT74] Over a lower boundary the transmitted ones
    // are those that fall on it, light thrown back and forth between it and the layer included.
    Eigen::VectorXd plane_albedo;           // at mu
    Eigen::VectorXd diffuse_transmittance;  // at mu
    double spherical_albedo = 0;            // URU
    double total_transmittance = 1;         // UTU: uniform illumination, diffuse and beam

    // What the lower boundary absorbs of the incident flux; empty and 0 without one.
    Eigen::VectorXd ground_absorptance;  // at mu
    double spherical_ground_absorptance = 0;
};

/// A layer of one albedo and depth. Over a lower boundary reflection is that of both, and `single`
/// then counts light scattered once, by the layer or by the boundary.
class LayerSolution : public ModeSolution {
  public:
    double albedo = 0;
    double optical_depth = 0;

    // weight of order n in everything here, w^n or 0; empty: all orders
    Eigen::VectorXd order_weights;

    /// R between mu(in) and mu(out) at an azimuth in radians, or at many, for which
    /// the corrections are computed once.
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

    PhaseFunction phase_function;
    Truncation truncation;
    std::shared_ptr<const ForwardPeak> peak;  // null unless truncation is narrow
};

}  // namespace stratus
