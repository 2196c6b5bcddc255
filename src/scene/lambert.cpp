#include <stratus/base/angle.h>
#include <stratus/base/number_text.h>
#include <stratus/scene/figure.h>
#include <stratus/transfer/solve.h>
#include <stratus/transfer/solve_to_tolerance.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

constexpr double solver_tolerance = 1e-4;
constexpr int cosine_count = 101;        // 0.01 to 1, denser towards 0.01
constexpr int azimuth_count = 64;        // of a mean
constexpr double min_compared_mu = 0.2;  // below it, no cloud is plane-parallel

double mean_reflection(const LayerSolution& layer, int in, int out) {
    std::vector<double> azimuths(azimuth_count);
    for (int k = 0; k < azimuth_count; ++k)
        azimuths[static_cast<std::size_t>(k)] = pi * (k + 0.5) / azimuth_count;
    double sum = 0;
    for (const SolvedValue& value : layer.values(Side::reflection, in, out, azimuths))
        sum += value.total;
    return sum / azimuth_count;
}

}  // namespace

LambertComparison compare_with_lambert(const LambertFigure& figure) {
    std::vector<double> mu;
    for (int k = 0; k < cosine_count; ++k) {
        const double share = static_cast<double>(k) / (cosine_count - 1);
        mu.push_back(0.01 + 0.99 * share * share);
    }
    mu.insert(mu.end(), figure.mu_in.begin(), figure.mu_in.end());
    SolverOptions options;
    options.tolerance = solver_tolerance;
    const ChosenNodes chosen =
        choose_nodes({{figure.phase_function, figure.albedo, figure.optical_depth}}, {}, options);
    options.nodes = chosen.nodes;
    const LayerSolution layer =
        solve_layer(figure.phase_function, figure.albedo, figure.optical_depth, mu, options);

    LambertComparison made;
    made.error = chosen.error;
    made.plot = {figure.title.empty() ? "Light reflected by a deep cloud, beside Lambert's law"
                                      : figure.title,
                 "cosine of emission \u03bc",
                 "R / plane albedo",
                 1,
                 2,
                 {{"Lambert's law", true, {{0, 1}, {1, 1}}}}};
    auto compare = [&](Line& line, int in, int out, double value, double& worst, double& at) {
        const double ratio = value / layer.plane_albedo(in), cosine = layer.mu(out);
        line.points.emplace_back(cosine, ratio);
        if (cosine < min_compared_mu || std::abs(ratio - 1) <= worst) return false;
        worst = std::abs(ratio - 1);
        at = cosine;
        return true;
    };
    for (std::size_t i = 0; i < figure.mu_in.size(); ++i) {
        Line line{"\u03bc\u2080 = " + short_number(figure.mu_in[i], 3), false, {}};
        const int in = cosine_count + static_cast<int>(i);
        for (int out = 0; out < cosine_count; ++out)
            if (compare(line, in, out, mean_reflection(layer, in, out), made.deviation, made.mu))
                made.mu_in = figure.mu_in[i];
        made.plot.lines.push_back(std::move(line));
    }
    Line disk{"full disk, \u03bc\u2080 = \u03bc", true, {}};
    for (int k = 0; k < cosine_count; ++k)
        compare(disk, k, k, layer.reflection(k, k, pi).total, made.disk_deviation, made.disk_mu);
    made.plot.lines.push_back(std::move(disk));
    return made;
}

}  // namespace stratus
