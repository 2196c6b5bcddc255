#include <stratus/transfer/solution.h>

#include "options.h"
#include "orders.h"

namespace stratus {

namespace {

/// single_reflection or single_transmission.
using SingleScattering = double (*)(double phase_value, double albedo, double optical_depth,
                                    double mu_in, double mu_out);

/// TMS minus the closed form of the layer itself, per unit of phase function. [NT88]
double single_correction(const LayerSolution& layer, SingleScattering single_scattering,
                         OrderPath path, double in, double out) {
    if (layer.order_weights.size()) return sum_paths(path, layer, 2, in, out);
    const Truncation& truncation = layer.truncation;
    return single_scattering(1, truncation.single_scattering_albedo(layer.albedo),
                             truncation.optical_depth(layer.optical_depth, layer.albedo), in, out) -
           single_scattering(1, layer.albedo, layer.optical_depth, in, out);
}

}  // namespace

PeakCorrection LayerSolution::reflection_correction(int in, int out) const {
    if (truncation.fraction == 0) return {};
    const double x = mu(in), y = mu(out);
    return {single_correction(*this, single_reflection, reflected_path, x, y),
            peak ? peak->reflection(optical_depth, x, y, order_weights) : std::vector<double>{}};
}

PeakCorrection LayerSolution::transmission_correction(int in, int out) const {
    if (truncation.fraction == 0) return {};
    const double x = mu(in), y = mu(out);
    return {single_correction(*this, single_transmission, transmitted_path, x, y),
            peak ? peak->transmission(optical_depth, x, y, order_weights) : std::vector<double>{}};
}

double LayerSolution::boundary_correction(int in, int out) const {
    if (truncation.fraction == 0 && boundary_truncation.fraction == 0) return 0;
    const double depth = truncation.optical_depth(optical_depth, albedo);
    return single_reflection_of_boundary(truncated(lower_boundary, boundary_truncation), 1, depth,
                                         mu(in), mu(out)) -
           single_reflection_of_boundary(lower_boundary, 1, optical_depth, mu(in), mu(out));
}

}  // namespace stratus
