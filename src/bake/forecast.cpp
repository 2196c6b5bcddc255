#include <stratus/bake/forecast.h>

#include <stratus/bake/accuracy.h>
#include <stratus/bake/axes.h>
#include <stratus/bake/parallel.h>
#include <stratus/base/number_text.h>

#include "recipe_sections.h"
#include "table_units.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <set>

namespace stratus {

namespace {

/// Sets an axis by its name in recipes.
void set(Discretisation& d, const std::string& name, double value) {
    const auto whole = static_cast<int>(std::min(value, 1e6));
    if (name == "nodes") d.nodes = whole;
    if (name == "mu_samples") d.mu_samples = whole;
    if (name == "azimuth_samples") d.azimuth_samples = whole;
    if (name == "optical_depth_samples_per_octave") d.optical_depth_samples_per_octave = whole;
    if (name == "albedo_samples") d.albedo_samples = whole;
}

Shortfall make_shortfall(const AxisAtCap& axis, const Resolution& resolution) {
    Shortfall shortfall{axis, resolution.max_error};
    if (axis.needed == 0) return shortfall;
    Recipe finer = resolution.recipe;
    set(finer.discretisation, axis.name, axis.needed);
    for (std::size_t k = 0; k < finer.family.size(); ++k)
        if (axis.name == samples_key(finer.family[k].parameter))
            finer.discretisation.family_samples[k] = static_cast<int>(std::min(axis.needed, 1e6));
    shortfall.needed_bytes = table_size(finer).bytes;
    if (axis.name == "nodes") shortfall.times_as_long = std::pow(axis.needed / axis.value, 3);
    return shortfall;
}

/// Seconds that one thread takes for the bake's own check. Its first ladders of depths are solved for
/// that, and kept in the log, where the bake finds them.
double predicted_check(const Recipe& resolved, const Table& header, const BakeOptions& options) {
    PointRange range = point_range(header, header.view());
    range.reflection = resolved.reflection;
    range.transmission = resolved.transmission;
    VerifyOptions check = check_of_first(options);
    check.threads = 1;
    check.log.find = nullptr;       // they are timed even where they are known
    constexpr double brief = 0.01;  // seconds; the first of brief ladders sets up what all share
    std::vector<double> times;
    check.log.stop = [&] {
        times.push_back(processor_seconds());
        const std::size_t solved = times.size() - 1;
        return solved > 1 || (solved == 1 && times[1] - times[0] >= brief);
    };
    try {
        solve_random_points(resolved.phase_function, range,
                            reference_solver(header, resolved.discretisation.nodes), check);
        times.push_back(processor_seconds());
    } catch (const WorkStopped&) {
    }
    const double seconds = times.back() - times[times.size() - 2];
    return seconds * std::ceil(static_cast<double>(check.samples) / points_of_ladder(range));
}

std::string text_of_bytes(double bytes) {
    char text[32];
    if (bytes < 1 << 20)
        std::snprintf(text, sizeof text, "%.1f KiB", bytes / (1 << 10));
    else if (bytes < 1 << 30)
        std::snprintf(text, sizeof text, "%.1f MiB", bytes / (1 << 20));
    else
        std::snprintf(text, sizeof text, "%.1f GiB", bytes / (1 << 30));
    return text;
}

}  // namespace

TableSize table_size(const Recipe& resolved) {
    const Discretisation& d = resolved.discretisation;
    const auto members = static_cast<double>(member_count(family_axes(resolved)));
    const double layers =
        members * static_cast<double>(
                      albedo_axis(resolved.albedo, d.albedo_samples, d.albedo_scale).values.size() *
                      optical_depth_axis(resolved.optical_depth, d.optical_depth_samples_per_octave,
                                         d.deepest_optical_depth)
                          .values.size());
    const double samples = layers * static_cast<double>(direction_axes(resolved).count());
    const double sides = (resolved.reflection ? 1 : 0) + (resolved.transmission ? 1 : 0);
    const double of_mu = is_narrow(resolved.mu_in, all_cosines) ? 0 : d.mu_samples;
    const double fluxes = layers * (of_mu * (resolved.transmission ? 2 : 1) + 1);
    return {layers, samples, sizeof(float) * (sides * samples + fluxes)};
}

bool Forecast::misses(double tolerance) const {
    return std::ranges::any_of(shortfalls,
                               [&](const Shortfall& axis) { return axis.error > tolerance; });
}

Forecast forecast(const Resolution& resolution, const BakeOptions& options) {
    Forecast forecast;
    forecast.resolved = resolution.recipe;
    const TableSize size = table_size(resolution.recipe);
    forecast.samples_a_side = size.samples_a_side;
    forecast.bytes = size.bytes;
    std::set<std::string> named;  // mixtures may share an axis at its cap
    for (const AxisAtCap& axis : resolution.at_cap)
        if (named.insert(axis.name).second)
            forecast.shortfalls.push_back(make_shortfall(axis, resolution));

    if (options.log.ranks != nullptr) return forecast;
    const auto started = Clock::now();
    const int threads = thread_count(options.threads);
    const TableUnits units(resolution.recipe);
    forecast.unit_seconds = units.predicted_seconds();
    // The last units leave threads idle.
    forecast.bake_seconds = std::max(
        forecast.unit_seconds.front(),
        std::accumulate(forecast.unit_seconds.begin(), forecast.unit_seconds.end(), 0.0) / threads);
    forecast.check_seconds = predicted_check(resolution.recipe, units.header(), options) / threads;
    forecast.timed_seconds = seconds_since(started);
    return forecast;
}

Forecast forecast(const Recipe& recipe, const BakeOptions& options) {
    return forecast(resolve_as_first(recipe, options), options);
}

std::string describe(const Shortfall& axis) {
    std::string sentence = axis.name + " is at its cap of " + short_number(axis.value) +
                           ", which alone misses " + short_number(axis.error) + " where " +
                           short_number(axis.allowed) + " is its share of the tolerance";
    if (axis.needed == 0) return sentence + "; no number is known that would do";
    sentence += "; by extrapolation " + short_number(axis.needed, 6) + " would do, ";
    if (axis.times_as_long > 1)
        return sentence + "and take about " + short_number(axis.times_as_long) + " times as long";
    return sentence + "in a table of " + text_of_bytes(axis.needed_bytes);
}

std::string sentence_of_cost(const Forecast& forecast) {
    char line[320];
    if (forecast.timed_seconds == 0)
        std::snprintf(line, sizeof line, "%.0f samples a side, %s in memory and uncompressed",
                      forecast.samples_a_side, text_of_bytes(forecast.bytes).c_str());
    else
        std::snprintf(
            line, sizeof line,
            "%.0f samples a side, %s in memory and uncompressed; about %.2g s to solve and "
            "%.2g s to check (a piece of both was timed for %.2g s)",
            forecast.samples_a_side, text_of_bytes(forecast.bytes).c_str(), forecast.bake_seconds,
            forecast.check_seconds, forecast.timed_seconds);
    return line;
}

}  // namespace stratus
