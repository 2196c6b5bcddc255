#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/scene/figure.h>
#include <stratus/transfer/solve.h>

#include <algorithm>
#include <cmath>

namespace stratus {
namespace {

// ---- lobes

constexpr double lobe_tolerance = 1e-3;  // less than a line's width
constexpr int angles = 61;               // three degrees each, horizon to horizon

/// A cosine for each angle between the horizons, then those of the incident rays.
std::vector<double> cosines(const LobeFigure& figure) {
    std::vector<double> mu;
    for (int k = 1; k < angles - 1; ++k) mu.push_back(std::cos(radians(3 * k - 90.0)));
    for (const double angle : figure.incident) mu.push_back(std::abs(std::cos(angle)));
    return mu;
}

LobeCurve lobe_curve(const LayerSolution& layer, int incident_node, bool from_above, bool single) {
    LobeCurve curve{std::vector<double>(angles), std::vector<double>(angles)};
    for (int k = 1; k < angles - 1; ++k) {
        const int out = k - 1;
        const double azimuth = k < angles / 2 ? pi : 0;
        const PerSide<SolvedValue> light{layer.reflection(incident_node, out, azimuth),
                                         layer.transmission(incident_node, out, azimuth)};
        for (const Side side : both_sides)
            (from_above == (side == Side::reflection) ? curve.above : curve.below)[size(k)] =
                4 * layer.mu(incident_node) * layer.mu(out) *
                (single ? light[side].single : light[side].total);
    }
    return curve;
}

// ---- beside Lambert's law

constexpr double lambert_tolerance = 1e-4;
constexpr int cosine_count = 101;        // 0.01 to 1, denser towards 0.01
constexpr int azimuth_count = 64;        // of a mean
constexpr double min_compared_mu = 0.2;  // below it, no cloud is plane-parallel

double mean_reflection(const LayerSolution& layer, int in, int out) {
    std::vector<double> azimuths(azimuth_count);
    for (int k = 0; k < azimuth_count; ++k) azimuths[size(k)] = pi * (k + 0.5) / azimuth_count;
    double sum = 0;
    for (const SolvedValue& value : layer.values(Side::reflection, in, out, azimuths))
        sum += value.total;
    return sum / azimuth_count;
}

}  // namespace

LobePlot plot_lobes(const LobeFigure& figure) {
    LobePlot plot;
    plot.title = figure.title.empty() ? "What a layer scatters, by optical depth and incident angle"
                                      : figure.title;
    plot.common_scale = figure.common_scale;
    plot.blocks = {{"scattered once", {}}, {"all orders", {}}};
    for (const double albedo : figure.albedos)
        plot.names.push_back("w = " + short_number(albedo, 4));
    SolverOptions options;
    options.tolerance = lobe_tolerance;
    const std::vector<double> mu = cosines(figure);
    for (const double depth : figure.optical_depths) {
        plot.row_titles.push_back("\u03c4 = " + short_number(depth, 4));
        std::vector<LayerSolution> layers;
        for (const double albedo : figure.albedos) {
            const ChosenNodes chosen =
                choose_nodes({{figure.phase_function, albedo, depth}}, {}, options);
            plot.error = std::max(plot.error, chosen.error);
            options.nodes = chosen.nodes;
            layers.push_back(solve_layer(figure.phase_function, albedo, depth, mu, options));
        }
        for (const bool single : {true, false}) {
            std::vector<LobePanel> row;
            for (std::size_t i = 0; i < figure.incident.size(); ++i) {
                row.push_back({figure.incident[i], {}});
                for (const LayerSolution& layer : layers)
                    row.back().curves.push_back(lobe_curve(layer, angles - 2 + static_cast<int>(i),
                                                           figure.incident[i] < pi / 2, single));
            }
            plot.blocks[single ? 0 : 1].rows.push_back(std::move(row));
        }
    }
    return plot;
}

LambertComparison compare_with_lambert(const LambertFigure& figure) {
    std::vector<double> mu;
    for (int k = 0; k < cosine_count; ++k) {
        const double share = static_cast<double>(k) / (cosine_count - 1);
        mu.push_back(0.01 + 0.99 * share * share);
    }
    mu.insert(mu.end(), figure.mu_in.begin(), figure.mu_in.end());
    SolverOptions options;
    options.tolerance = lambert_tolerance;
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
