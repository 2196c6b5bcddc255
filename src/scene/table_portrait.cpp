#include <stratus/scene/render.h>

#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/picture/plots.h>
#include <stratus/table/lookup.h>

#include <algorithm>
#include <cstdio>

namespace stratus {
namespace {

constexpr double beam_angle = radians(60);                       // of the lobes, from the normal
constexpr double phase_angle = radians(40), tilt = radians(25);  // of the spheres' sun
constexpr int lobe_samples = 721;
constexpr int sphere_samples = 2;  // along both sides of a pixel

// ---- Depths and albedos

/// Finite depths, evenly spread in the logarithm over the part of the axis where layers differ
/// (below 0.1 nearly all light is transmitted, above 32 hardly any, and 10 is close to infinity),
/// at the roundest numbers that keep them apart.
std::vector<double> shown_finite_depths(const AxisView& axis) {
    if (axis.count == 0) return {};
    if (axis.lowest == axis.highest) return {axis.lowest};
    double min = std::max(axis.lowest, 0.1);
    double max = std::min(axis.highest, axis.ends_at_infinity ? 10.0 : 32.0);
    if (!(min < max)) {
        min = axis.lowest;
        max = axis.highest;
    }
    const int count = axis.ends_at_infinity ? 3 : 4;
    std::vector<double> depths(size(count));
    for (int digits = 1; digits <= 4; ++digits) {
        for (int k = 0; k < count; ++k) {
            const double depth = min * std::pow(max / min, k / (count - 1.0));
            depths[size(k)] = std::clamp(rounded(depth, digits), axis.lowest, axis.highest);
        }
        if (std::ranges::adjacent_find(depths) == depths.end()) return depths;
    }
    return {axis.lowest, axis.highest};
}

/// Up to four optical depths, ascending, with infinity where the table has it.
std::vector<double> shown_depths(const AxisView& axis) {
    std::vector<double> depths = shown_finite_depths(axis);
    if (axis.ends_at_infinity) depths.push_back(infinity);
    return depths;
}

/// Up to three albedos, descending from the table's highest, spread as its axis is; the darkest
/// third of it shows little.
std::vector<double> shown_albedos(const AxisView& axis) {
    const double brightest = std::sqrt(1 - axis.highest), darkest = std::sqrt(1 - axis.lowest);
    std::vector<double> albedos{axis.highest};
    for (const double share : {0.35, 0.7}) {
        const double loss = std::pow(brightest + share * (darkest - brightest), 2);
        const double albedo = std::clamp(1 - rounded(loss), axis.lowest, axis.highest);
        if (albedo < albedos.back()) albedos.push_back(albedo);
    }
    return albedos;
}

// ---- Words

std::string accuracy_words(const Table& table, const PhaseFunction& phase_function) {
    std::string words =
        "Mean cosine of scattering g = " + short_number(phase_function.asymmetry(), 3);
    if (table.measured_error > 0) {
        char error[32];
        std::snprintf(error, sizeof error, "%.1e", table.measured_error);
        words += ";  largest relative error measured at the bake " + std::string(error);
    }
    return words;
}

std::string lower_boundary_words(const LowerBoundary& boundary) {
    const std::string albedo = " of albedo " + short_number(boundary.albedo, 3);
    switch (boundary.kind) {
        case LowerBoundary::Kind::surface: return "over a Lambert surface" + albedo;
        case LowerBoundary::Kind::ground: return "over " + boundary.law->text();
        case LowerBoundary::Kind::layer: return "over a semi-infinite layer" + albedo;
        default: return "black below it";
    }
}

// ---- Lobes

/// R mu_out and T mu_out in the plane of incidence.
LobeCurve make_lobes(const TableView& table, double albedo, double optical_depth, bool single) {
    LobeCurve lobes;
    for (int k = 0; k < lobe_samples; ++k) {
        const double angle = pi * (k / (lobe_samples - 1.0) - 0.5);
        const Geometry geometry{std::cos(beam_angle), std::max(std::cos(angle), least_cosine),
                                angle >= 0 ? 0 : pi};
        const auto radius = [&](const Scattered& light) {
            return (single ? light.single : light.total()) * geometry.mu_out;
        };
        if (table.has_reflection())
            lobes.above.push_back(radius(reflection(table, albedo, optical_depth, geometry)));
        if (table.has_transmission())
            lobes.below.push_back(radius(transmission(table, albedo, optical_depth, geometry)));
    }
    return lobes;
}

// ---- Spheres

/// A planet seen from far away that fills a disc of `radius` pixels; dark before a white background
/// until it is given a sun and a layer.
Scene sphere_scene(double radius) {
    Scene scene;
    scene.width = scene.height = 2 * static_cast<int>(std::ceil(radius)) + 2;
    scene.samples = sphere_samples;
    scene.camera.position = {2, 0, 0};
    scene.camera.orthographic = true;
    scene.camera.width = scene.width / radius;
    scene.to_sun = {-1, 0, 0};
    scene.background.colour = {1, 1, 1};
    scene.effects.background = false;  // no ground
    scene.subject = Planet{};
    return scene;
}

Image render_sphere(const TableView& table, Scene scene, double albedo, double optical_depth,
                    bool single) {
    scene.to_sun = {std::cos(phase_angle), std::sin(phase_angle) * std::cos(tilt),
                    std::sin(phase_angle) * std::sin(tilt)};
    scene.background.colour = {0, 0, 0};
    scene.layer.albedo = {albedo, albedo, albedo};
    scene.layer.optical_depth.max = optical_depth;
    scene.effects.multiple = !single;
    return render(scene, LayerLight(scene, table));
}

}  // namespace

Portrait make_portrait(const Table& table, const TableView& whole) {
    std::vector<double> middles;
    for (const FamilyAxis& axis : table.family) {
        const std::vector<double>& values = axis.axis.values;
        middles.push_back(is_mixture(table.family) ? (values.front() + values.back()) / 2
                                                   : values[values.size() / 2]);
    }
    const TableView view = whole.at(FamilyPoint(middles));
    const PhaseFunction phase_function = view.chosen_phase_function();
    const std::vector<double> depths = shown_depths(view.optical_depth);
    const auto title = table.attributes.find("title");

    Portrait portrait;
    portrait.title = title != table.attributes.end() && !title->second.empty()
                         ? title->second
                         : "A table of scattered light";
    portrait.subtitles = {"Phase function: " + phase_function.caption(),
                          accuracy_words(table, phase_function)};
    portrait.orders = table.highest_order == 0
                          ? "all orders"
                          : "orders 1 to " + std::to_string(table.highest_order);
    portrait.lower_boundary = lower_boundary_words(table.lower_boundary);
    portrait.albedos = shown_albedos(view.albedo);
    portrait.beam_angle = beam_angle;
    portrait.phase_angle = phase_angle;
    portrait.has_reflection = view.has_reflection();
    portrait.has_transmission = view.has_transmission();

    const Scene sphere = sphere_scene(sphere_radius(depths.size()));
    if (portrait.has_reflection) portrait.uncovered = render(sphere, LayerLight(sphere, view));
    for (const double depth : depths) {
        const double albedo = portrait.albedos.front();
        PortraitColumn column;
        column.optical_depth = depth;
        if (!view.has_lower_boundary())
            column.beam_transmittance = direct_transmittance(depth, std::cos(beam_angle));
        column.single = make_lobes(view, albedo, depth, true);
        for (const double each : portrait.albedos)
            column.all.push_back(make_lobes(view, each, depth, false));
        if (portrait.has_reflection) {
            column.single_sphere = render_sphere(view, sphere, albedo, depth, true);
            column.sphere = render_sphere(view, sphere, albedo, depth, false);
        }
        portrait.columns.push_back(std::move(column));
    }
    return portrait;
}

}  // namespace stratus
