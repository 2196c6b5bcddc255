// Figures: plots that a scene file may contain instead of a picture, computed by the solver without
// tables.
#pragma once

#include <stratus/phase/phase_function.h>
#include <stratus/picture/plots.h>

namespace stratus {

/// Figure 8 of [Blinn82]: polar plots of the light that a layer scatters. Incident angles are
/// from the upper normal; beyond 90 degrees the layer is lit from below.
struct LobeFigure {
    PhaseFunction phase_function;
    std::vector<double> incident;  // radians
    std::vector<double> optical_depths, albedos;
    bool common_scale = false;  // of all depths, on which thin layers are dim; else each its own
    std::string title{};        // empty: one that says what is shown
};

/// R of a deep cloud against the cosine of emission, beside Lambert's law. [Blinn82] 5.3
struct LambertFigure {
    PhaseFunction phase_function;
    double albedo = 1, optical_depth = 0;
    std::vector<double> mu_in;
    std::string title{};  // empty: one that says what is shown
};

using Figure = std::variant<LobeFigure, LambertFigure>;

/// Radii B mu = 4 mu0 mu R, and T likewise on the other side, as in the paper; single scattering in
/// the left block, all orders in the right one.
LobePlot plot_lobes(const LobeFigure& figure);

/// R(mu_in, mu) averaged over azimuth, and R over a disk at full phase.
struct LambertComparison {
    LinePlot plot;
    // Largest |R / A - 1| for mu in [0.2, 1], A the plane albedo, and where it is.
    double deviation = 0, mu_in = 0, mu = 0;  // of the mean over azimuth
    double disk_deviation = 0, disk_mu = 0;   // of the disk
    double error = 0;                         // of the solver, relative, estimated
};
LambertComparison compare_with_lambert(const LambertFigure& figure);

}  // namespace stratus
