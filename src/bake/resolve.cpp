#include <stratus/bake/forecast.h>

// From a recipe to its discretisation, one choice after the other: what the recipe gives stays,
// what an interrupted bake has chosen is taken from its log, the rest is measured on the probes.

#include <stratus/bake/axes.h>
#include <stratus/base/number_text.h>

#include "choices.h"
#include "recipe_sections.h"
#include "piece_of_work.h"

#include <algorithm>
#include <functional>
#include <optional>

namespace stratus {

namespace {

/// Puts choices into a discretisation, and keeps them in the log.
class Choices {
  public:
    explicit Choices(const BakeOptions& options) : options_(options) {}

    /// Settles `value` where it is open, by choose() unless the log knows it.
    template <class Value, class Choose>
    void settle(Value& value, const char* name, const Choose& choose) {
        if (value != 0) return;
        const std::string piece = std::string("choice of ") + name;
        Choice choice;
        if (const auto finished = find_finished<double>(options_.log, piece, 3)) {
            choice = {(*finished)[0], (*finished)[1], (*finished)[2]};
        } else {
            choice = choose();
            keep_finished(options_.log, piece,
                          std::vector<double>{choice.value, choice.error_at_cap, choice.needed});
        }
        value = static_cast<Value>(choice.value);
        if (choice.error_at_cap > 0)
            at_cap_.push_back({name, choice.value, choice.error_at_cap, choice.needed});
    }

    /// Settles the samples of an axis, and their scale with them; given samples have the `usual`
    /// scale unless theirs is given too.
    void settle_scaled(int& samples, std::optional<AxisScale>& scale, AxisScale usual,
                       const std::string& axis, const std::function<ScaledChoice()>& choose) {
        if (samples > 0) {
            scale = scale.value_or(usual);
            return;
        }
        const std::string scale_piece = "choice of " + axis + "_scale";
        settle(samples, (axis + "_samples").c_str(), [&] {
            const ScaledChoice choice = choose();
            keep_finished(options_.log, scale_piece, std::vector{static_cast<int>(choice.scale)});
            scale = choice.scale;
            return choice.samples;
        });
        if (const auto finished = find_finished<int>(options_.log, scale_piece, 1))
            scale = static_cast<AxisScale>((*finished)[0]);
    }

    const std::vector<AxisAtCap>& at_cap() const { return at_cap_; }

  private:
    const BakeOptions& options_;
    std::vector<AxisAtCap> at_cap_;
};

/// All choices of a recipe of one member.
Resolution resolve_one_member(const Recipe& recipe, double max_error, const BakeOptions& options) {
    Probes probes = place_probes(recipe, max_error, options);
    Discretisation& d = probes.recipe.discretisation;
    Choices choices(options);
    int made = 0;
    const auto show_progress = [&] {
        constexpr double count = 7;
        if (options.progress) options.progress(made++ / count, "measuring");
    };
    const auto settle = [&](auto& value, const char* name, Choice (*choose)(Probes&)) {
        show_progress();
        choices.settle(value, name, [&] { return choose(probes); });
    };
    settle(d.nodes, "nodes", choose_nodes);
    settle(d.modes, "modes", choose_modes);
    settle(d.mu_samples, "mu_samples", choose_mu_samples);
    show_progress();
    choices.settle_scaled(d.azimuth_samples, d.azimuth_scale, AxisScale::linear, "azimuth",
                          [&] { return choose_azimuth_samples(probes); });
    settle(d.deepest_optical_depth, "deepest_optical_depth", choose_deepest_optical_depth);
    settle(d.optical_depth_samples_per_octave, "optical_depth_samples_per_octave",
           choose_optical_depth_samples);
    show_progress();
    choices.settle_scaled(d.albedo_samples, d.albedo_scale, AxisScale::square_root_of_complement,
                          "albedo", [&] { return choose_albedo_samples(probes); });
    return {probes.recipe, choices.at_cap(), max_error};
}

/// The finer of two ways to sample, axis by axis.
Discretisation finer(const Discretisation& a, const Discretisation& b) {
    constexpr int Discretisation::*counts[] = {
        &Discretisation::nodes,          &Discretisation::modes,
        &Discretisation::mu_samples,     &Discretisation::azimuth_samples,
        &Discretisation::albedo_samples, &Discretisation::optical_depth_samples_per_octave};
    Discretisation both = a;
    for (const auto count : counts) both.*count = std::max(a.*count, b.*count);
    if (!both.azimuth_scale) both.azimuth_scale = b.azimuth_scale;
    if (!both.albedo_scale) both.albedo_scale = b.albedo_scale;
    both.deepest_optical_depth = std::max(a.deepest_optical_depth, b.deepest_optical_depth);
    return both;
}

/// Points of a family that serve all between them: the most and the least peaked of its corners,
/// and the middle, the most peaked first; just one where the recipe has no family.
std::vector<FamilyPoint> probed_points(const Recipe& recipe) {
    if (recipe.family.empty()) return {{}};
    std::vector<double> middle;
    for (const FamilyRange& range : recipe.family)
        middle.push_back(range.values.empty() ? ranging_axis(range, 3).axis.values[1]
                                              : range.values[range.values.size() / 2]);
    const std::vector<FamilyPoint> corners = corners_by_peak(recipe);
    return {corners.front(), FamilyPoint(middle), corners.back()};
}

/// "mixture 0.5", as pieces of work and notes name a point.
std::string point_name(const Recipe& recipe, const FamilyPoint& point, int digits) {
    std::vector<std::string> names;
    for (std::size_t k = 0; k < recipe.family.size(); ++k)
        names.push_back(std::string(parameter_name(recipe.family[k].parameter)) + " " +
                        short_number(point[k], digits));
    return joined(names);
}

}  // namespace

Resolution resolve_to(const Recipe& given, double strictness, const BakeOptions& options) {
    check_directions(given);
    const Recipe recipe = with_path_law_decided(given);
    const double max_error = strictness * recipe.tolerance;
    const bool has_family = !recipe.family.empty();
    const auto note_member = [&](const std::string& which) {
        if (has_family && options.note) options.note(which + ":");
    };
    Resolution resolved{recipe, {}, max_error};
    for (const FamilyPoint& point : probed_points(recipe)) {
        note_member(point_name(recipe, point, 2));
        BakeOptions at_point = options;
        if (has_family) at_point.log = nested_log(options.log, point_name(recipe, point, 17));
        Discretisation& d = resolved.recipe.discretisation;
        Recipe alone = at_member(recipe, point);
        alone.discretisation.azimuth_scale = d.azimuth_scale;  // one for all, the first's
        alone.discretisation.albedo_scale = d.albedo_scale;
        const Resolution one = resolve_one_member(alone, max_error, at_point);
        d = finer(d, one.recipe.discretisation);
        resolved.at_cap.insert(resolved.at_cap.end(), one.at_cap.begin(), one.at_cap.end());
    }
    if (!has_family) return resolved;
    note_member("all");
    Choices choices(options);
    for (std::size_t k = 0; k < recipe.family.size(); ++k) {
        if (!recipe.family[k].values.empty()) continue;
        choices.settle(resolved.recipe.discretisation.family_samples[k],
                       samples_key(recipe.family[k].parameter).c_str(), [&] {
                           return choose_family_samples(resolved.recipe, k, max_error, options);
                       });
    }
    resolved.at_cap.insert(resolved.at_cap.end(), choices.at_cap().begin(), choices.at_cap().end());
    return resolved;
}

}  // namespace stratus
