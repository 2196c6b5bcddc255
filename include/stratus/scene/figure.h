// Figures: plots that a scene file may ask for instead of a picture, solved exactly, with no table.
#pragma once

#include <stratus/picture/line_plot.h>
#include <stratus/picture/lobe_plot.h>
#include <stratus/runtime/phase_function.h>

#include <variant>
#include <vector>

namespace stratus {

/// Figure 8 of [Blinn82]: polar plots of what a layer scatters, for incident angles from its
/// normal; beyond 90 degrees it is lit from below.
///
///     [lobes]
///     phase_function = "isotropic"
///     incident_deg = [36.0, 72.0, 108.0, 144.0]
///     optical_depths = [1000.0, 2.0, 0.5, 0.1]
///     albedos = [0.5, 0.9, 1.0]
struct LobeFigure {
    PhaseFunction phase_function;
    std::vector<double> incident;  // radians
    std::vector<double> optical_depths, albedos;
};

/// R of a deep cloud against the emission cosine, beside Lambert's law. [Blinn82] 5.3
///
///     [lambert]
///     phase_function = "henyey_greenstein:g=0.75"
///     albedo = 1.0
///     optical_depth = inf
///     mu_in = [1.0, 0.8, 0.5, 0.2]
struct LambertFigure {
    PhaseFunction phase_function;
    double albedo = 1, optical_depth = 0;
    std::vector<double> mu_in;
};

using Figure = std::variant<LobeFigure, LambertFigure>;

/// Radii B mu = 4 mu0 mu R, and T likewise on the far side, as the paper has them: in the left
/// block of light scattered once, in the right one of all orders.
LobePlot plot_lobes(const LobeFigure& figure);

/// R(mu_in, mu), the mean over azimuths, and R of a disk seen with the sun behind the eye.
struct LambertComparison {
    LinePlot plot;
    double deviation = 0;  // largest |R / A - 1|, A the plane albedo, over mu in [0.2, 1]; in the
    double mu_in = 0, mu = 0;                // mean over azimuths, here
    double disk_deviation = 0, disk_mu = 0;  // of the disk
};
LambertComparison compare_with_lambert(const LambertFigure& figure);

}  // namespace stratus
