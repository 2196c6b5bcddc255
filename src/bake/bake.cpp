#include <stratus/bake/bake.h>

#include <stratus/bake/accuracy.h>
#include <stratus/bake/forecast.h>
#include <stratus/bake/parallel.h>
#include <stratus/base/instruction_set.h>
#include <stratus/base/number_text.h>
#include <stratus/io/write_options.h>
#include <stratus/table/packed_table.h>

#include "piece_of_work.h"
#include "solved_samples.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

namespace stratus {

namespace {

/// Share of the tolerance that every single choice may use up at the first attempt, and what it
/// shrinks by at each further one: the errors of the choices add up, though seldom at the same
/// point. Shares that change no choice are passed over.
constexpr double first_strictness = 0.5, stricter = 0.6, least_strictness = 0.05;
constexpr int max_attempts = 4;

/// The bake's own check must be met with this much to spare, or by all points between peaks, so that other
/// random points meet the tolerance too.
constexpr double margin = 0.8;

bool meets_with_margin(const Verification& check, double tolerance) {
    const bool all_meet = check.samples.empty() || check.samples.back().error <= tolerance;
    return check.meets_at_peaks(margin * tolerance) &&
           (all_meet || check.meets_between_peaks(margin * tolerance));
}

/// The bake's own check looks at other points than `verify`.
constexpr unsigned check_seed = 20260;

const std::map<std::string, std::string>& conventions() {
    static const std::map<std::string, std::string> sentences{
        {"convention_reflection",
         "reflection = pi I / (mu_in F0), F0 the irradiance on a plane facing the beam; a white "
         "Lambert surface has 1; BRDF = reflection / pi"},
        {"convention_transmission",
         "transmission is the diffuse part in the same normalisation; the directly "
         "transmitted beam is exp(-optical_depth / mu_in), kept apart"},
        {"convention_multiple",
         "reflection_multiple and transmission_multiple hold orders n >= 2 of the Neumann series, "
         "to highest_order if that is not 0; single scattering is added in closed form"},
        {"convention_azimuth",
         "azimuth is the angle between the two directions of propagation, 0 = forward side, "
         "radians"},
        {"convention_phase_function",
         "the phase function has spherical mean 1; g is the mean cosine of the scattering angle, "
         "positive for forward scattering"},
        {"convention_fluxes",
         "plane_albedo and diffuse_transmittance are fluxes over the incident flux, of all orders "
         "or to highest_order if that is not 0, spherical_albedo is for uniform illumination"},
    };
    return sentences;
}

/// The options of one attempt, whose pieces the log names by it.
BakeOptions attempt_options(BakeOptions options, int n) {
    options.log = nested_log(options.log, "attempt " + std::to_string(n));
    return options;
}

VerifyOptions check_options(const BakeOptions& of_attempt) {
    VerifyOptions check;
    check.samples = of_attempt.checked_points;
    check.seed = check_seed;
    check.threads = of_attempt.threads;
    check.fluxes = false;
    check.log = nested_log(of_attempt.log, "check");
    return check;
}

/// A resolved recipe's table and the result of the bake's own check.
struct Attempt {
    Table table;
    bool met = false;      // with a margin
    bool missed = true;    // the tolerance itself
    std::string at_peaks;  // what is said of errors there; empty without peaks
};

std::string sentence_of_miss(const Table& table, const std::string& at_peaks,
                             const std::vector<AxisAtCap>& at_cap) {
    std::string sentence = "the table misses its tolerance " + short_number(table.tolerance) +
                           ": 99.9 % of values are within " +
                           table.attributes.at("measured_error_99.9_percent") +
                           ", the largest error is " + short_number(table.measured_error, 3);
    if (!at_peaks.empty()) sentence += "; " + at_peaks;
    std::set<std::string> named;  // mixtures may share an axis at its cap
    for (const AxisAtCap& axis : at_cap)
        if (named.insert(axis.name).second)
            sentence += "; " + axis.name + " is at its cap of " + short_number(axis.value) +
                        ", which alone misses " + short_number(axis.error);
    return sentence;
}

Attempt attempt_bake(const Recipe& recipe, const Recipe& resolved, const BakeOptions& options) {
    Attempt attempt;
    Table& table = attempt.table;
    std::optional<SolvedSamples> samples;  // of a packed table, solved when they are asked for
    if (options.packed && !options.keeps_samples)
        samples.emplace(resolved, options, table);
    else
        table = solve_table(resolved, options);
    table.attributes = conventions();
    if (table.is_stack())
        table.attributes["convention_layers"] =
            "the table is of a stack of layers, top first, lit from above; single scattering, "
            "added in closed form, is that of each layer, attenuated by the others on the way in "
            "and out; phase_function, albedo and optical_depth are those of the mean layer";
    if (recipe.lower_boundary.is_present())
        table.attributes["convention_below"] =
            "reflection is that of the layer and its lower boundary; light scattered once, by "
            "either, is added in closed form and not in reflection_multiple";
    if (mixture_range(recipe) != nullptr)
        table.attributes["convention_mixture"] =
            "mixture is the share that phase_function has in all that is scattered, the rest is "
            "second_phase_function's: phi = mixture phi_1 + (1 - mixture) phi_2";
    if (!recipe.family.empty() && !is_mixture_alone(recipe))
        table.attributes["convention_family"] =
            "the first axes, named by family, are parameters of phase_function, whose own values "
            "of them do not count; lengths are in um; single scattering and the path law are those "
            "of the very parameters, datasets lie once for each member";
    if (table.path_law)
        table.attributes["convention_path_law"] =
            "reflection_multiple and transmission_multiple hold what the path law leaves of the "
            "orders n >= 2; the lookup adds it in closed form, from moments and path_law";
    table.attributes["title"] = recipe.title;
    table.attributes["recipe"] = recipe.text;
    table.attributes["resolved_recipe"] = resolved_text(resolved);
    table.attributes["nodes"] = std::to_string(resolved.discretisation.nodes);
    table.attributes["modes"] = std::to_string(resolved.discretisation.modes);
    table.attributes["program_version"] = STRATUS_VERSION;

    VerifyOptions check = check_options(options);
    if (options.samples && options.samples->has_room()) check.files = options.samples;
    if (options.progress) check.progress = [&](double done) { options.progress(done, "checking"); };
    std::optional<PackedTable> packed;
    if (options.packed) {
        *options.packed = samples                      ? pack(table, *samples)
                          : is_first_rank(options.log) ? pack(table)
                                                       : std::vector<char>{};
        if (is_first_rank(options.log)) {
            check.packed = &packed.emplace(*options.packed);
            *options.packed = std::vector<char>();  // it has its own copy
        }
    }
    trim_memory();
    Verification verification = verify(table, check);
    trim_memory();
    attempt.met = meets_with_margin(verification, recipe.tolerance);
    attempt.missed = !verification.meets(recipe.tolerance);
    const std::vector<char> verdict = shared(options.log, {attempt.met, attempt.missed});
    attempt.met = verdict[0] != 0;
    attempt.missed = verdict[1] != 0;
    if (!is_first_rank(options.log)) return attempt;
    const std::string median = short_number(error_quantile(verification.samples, 0.5), 3);
    const std::string most = short_number(error_quantile(verification.samples, 0.999), 3);
    table.measured_error = error_quantile(verification.samples, 1);
    table.attributes["measured_error_median"] = median;
    table.attributes["measured_error_99.9_percent"] = most;
    if (options.note)
        options.note("checked at " + std::to_string(options.checked_points) +
                     " random points: median " + median + ", 99.9 % within " + most + ", largest " +
                     short_number(table.measured_error, 3));
    if (!verification.forward.empty()) {
        const std::string forward = short_number(error_quantile(verification.forward, 0.99), 3);
        const std::string grazing = short_number(error_quantile(verification.grazing, 0.99), 3);
        table.attributes["measured_error_forward_99_percent"] = forward;
        table.attributes["measured_error_grazing_99_percent"] = grazing;
        const auto unless = [](bool judged) { return std::string(judged ? "" : " (not judged)"); };
        attempt.at_peaks = "near forward" + unless(verification.judges_forward) + " 99 % within " +
                           forward + ", at grazing " + (table.path_law ? "angles" : "pairs") +
                           unless(verification.judges_grazing) + " within " + grazing;
        if (options.note) options.note(attempt.at_peaks);
    }
    if (packed) *options.packed = restated(packed->file(), table);
    return attempt;
}

}  // namespace

std::string baking_program() {
#ifdef __clang__
    const std::string compiler = "clang " __clang_version__;
#else
    const std::string compiler = "g++ " __VERSION__;
#endif
    return "stratus " STRATUS_VERSION ", " + compiler + ", " +
           instruction_set_name(chosen_instruction_set());
}

Recipe resolve(const Recipe& recipe, const BakeOptions& options) {
    return resolve_to(recipe, first_strictness, options).recipe;
}

Resolution resolve_as_first(const Recipe& recipe, const BakeOptions& options) {
    return resolve_to(recipe, first_strictness, attempt_options(options, 0));
}

VerifyOptions check_of_first(const BakeOptions& options) {
    return check_options(attempt_options(options, 0));
}

namespace {

Table bake_on_its_threads(const Recipe& recipe, const BakeOptions& options) {
    auto note = [&](const std::string& line) {
        if (options.note) options.note(line);
    };
    Attempt attempt;
    std::vector<AxisAtCap> at_cap;
    std::string last;  // choices of the last attempt; the same again would give the same table
    double strictness = first_strictness;
    int baked = 0;
    for (int n = 0; baked < max_attempts && !attempt.met; ++n, strictness *= stricter) {
        if (strictness < least_strictness) {
            note("no choice can be refined further");
            break;
        }
        const BakeOptions of_attempt = attempt_options(options, n);
        const Resolution resolution = resolve_to(recipe, strictness, of_attempt);
        if (resolved_text(resolution.recipe) == last) continue;
        if (baked++ > 0)
            note("the tolerance is not met with a margin: baking again with these choices");
        last = resolved_text(resolution.recipe);
        at_cap = resolution.at_cap;
        if (options.note && n == 0) {
            const Forecast ahead = forecast(resolution, options);
            for (const Shortfall& axis : ahead.shortfalls) note("warning: " + describe(axis));
            note(sentence_of_cost(ahead));
        }
        attempt = attempt_bake(recipe, resolution.recipe, of_attempt);
        if (std::ranges::any_of(at_cap, [&](const AxisAtCap& axis) {
                return axis.error > margin * recipe.tolerance;
            }))
            break;  // no attempt will meet it
    }
    if (attempt.missed && is_first_rank(options.log)) {
        const std::string sentence = sentence_of_miss(attempt.table, attempt.at_peaks, at_cap);
        if (options.missed)
            options.missed(sentence);
        else
            note(sentence);
    }
    return std::move(attempt.table);
}

}  // namespace

Table bake(const Recipe& recipe, const BakeOptions& options) {
    Table table;
    // One team for all its loops, many of which take no longer than to start a thread.
    nested_parallel_for(1, options.threads,
                        [&](int) { table = bake_on_its_threads(recipe, options); });
    return table;
}

}  // namespace stratus
