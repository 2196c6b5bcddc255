// `stratus verify`: compares lookups at random points with fresh solutions.
#include <stratus/bake/accuracy.h>
#include <stratus/base/constants.h>
#include <stratus/base/size.h>

#include "options.h"
#include "progress.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {
namespace {

struct VerifyCommand {
    std::string table;
    VerifyOptions options;
    bool quiet = false;
    ReadOptions reading;
};

/// Scattering angles between two bounds, degrees.
struct Region {
    const char* name;
    double from, to;
};

constexpr Region regions[] = {{"all directions", 0, 181},
                              {"within 10 degrees of forward", 0, 10},
                              {"10 to 30 degrees", 10, 30},
                              {"beyond 30 degrees", 30, 181}};

/// A row of the errors of one side at some scattering angles; none without values.
void print_row(const std::vector<ErrorSample>& all, Side side, const Region& region) {
    std::vector<ErrorSample> samples;
    for (const ErrorSample& sample : all) {
        const double angle = degrees(sample.scattering_angle);
        if (sample.side == side && angle >= region.from && angle < region.to)
            samples.push_back(sample);
    }
    if (samples.empty()) return;
    std::printf("%-13s %-29s %7zu %9.1e %9.1e %9.1e %9.1e\n",
                side == Side::reflection ? "reflection" : "transmission", region.name,
                samples.size(), error_quantile(samples, 0.5), error_quantile(samples, 0.99),
                error_quantile(samples, 0.999), error_quantile(samples, 1));
}

void print_errors(const Verification& verification) {
    for (const Side side : both_sides) {
        for (const Region& region : regions) print_row(verification.samples, side, region);
        print_row(verification.forward, side, {"drawn within 10 degrees", 0, 181});
        print_row(verification.grazing, side, {"drawn at cosines below 0.15", 0, 181});
    }
}

/// Percent of the values that are within the tolerance.
double percent_within(const std::vector<ErrorSample>& samples, double tolerance) {
    const auto within =
        std::count_if(samples.begin(), samples.end(),
                      [&](const ErrorSample& sample) { return sample.error <= tolerance; });
    return 100.0 * static_cast<double>(within) /
           static_cast<double>(std::max<std::size_t>(1, samples.size()));
}

void print_worst(const Verification& verification, const std::vector<FamilyAxis>& family) {
    std::string names;
    for (const FamilyAxis& axis : family)
        names += std::string(11 - std::string(axis.name()).size(), ' ') + axis.name();
    std::printf("\nworst points\n%-13s %9s %13s %8s %8s %11s %13s %13s %9s%s\n", "side", "albedo",
                "optical_depth", "mu_in", "mu_out", "azimuth_deg", "solved", "looked up", "error",
                names.c_str());
    const std::size_t shown = std::min<std::size_t>(5, verification.samples.size());
    for (std::size_t n = 0; n < shown; ++n) {
        const ErrorSample& at = verification.samples[verification.samples.size() - 1 - n];
        std::printf("%-13s %9.5f %13.5g %8.5f %8.5f %11.2f %13.6e %13.6e %9.1e",
                    at.side == Side::reflection ? "reflection" : "transmission", at.albedo,
                    at.optical_depth, at.geometry.mu_in, at.geometry.mu_out,
                    degrees(at.geometry.azimuth), at.expected, at.found, at.error);
        for (std::size_t k = 0; k < family.size(); ++k) std::printf(" %10.5f", at.member[k]);
        std::printf("\n");
    }
}

void run_verify(const VerifyCommand& command) {
    const AnyTable given = read_intact_table(command.table, command.reading);
    const Table& table = given.table();
    Progress progress(command.quiet);
    VerifyOptions options = command.options;
    options.packed = given.packed();
    options.progress = [&](double done) { progress.show(done, "verifying"); };
    Verification verification = verify(table, options);

    std::printf(
        "%d random points against the solver with %d nodes; error relative to the total, floor 1 "
        "%% of the largest value at the same depth and albedo\n\n",
        options.samples, verification.reference_nodes);
    std::printf("%-13s %-29s %7s %9s %9s %9s %9s\n", "side", "scattering angle", "values", "median",
                "99 %", "99.9 %", "worst");
    print_errors(verification);
    print_worst(verification, table.family);
    std::printf("\n");
    if (verification.energy_defect >= 0)
        std::printf("energy: at albedo 1 the stored fluxes close to %.1e\n",
                    verification.energy_defect);
    if (verification.furnace_defect >= 0)
        std::printf("white furnace: lookups integrate to the stored plane albedo within %.1e\n",
                    verification.furnace_defect);
    const double share = percent_within(verification.samples, table.tolerance);
    const double worst = error_quantile(verification.samples, 1);
    std::printf("tolerance %.2g: %.2f %% of values within it, worst %.2f times it\n",
                table.tolerance, share, worst / table.tolerance);
    const bool peaked = !verification.forward.empty() || !verification.grazing.empty();
    const double forward = percent_within(verification.forward, table.tolerance);
    const double grazing = percent_within(verification.grazing, table.tolerance);
    if (peaked)
        std::printf(
            "forward peak: %.2f %% of values within 10 degrees, %.2f %% at cosines below "
            "0.15 within the tolerance%s\n",
            forward, grazing,
            verification.judges_grazing ? "" : "; the latter are not judged: the path law misses");
    if (verification.meets(table.tolerance)) return;
    char missed[320];
    int length = std::snprintf(
        missed, sizeof missed,
        "99.9 %% of values must be within its tolerance %.2g and all within 5 times it, "
        "got %.3f %% and %.2f times",
        table.tolerance, share, worst / table.tolerance);
    if (peaked && !verification.judges_grazing)
        std::snprintf(missed + length, sizeof missed - size(length),
                      "; 99 %% within 10 degrees of forward, got %.2f %%", forward);
    else if (peaked)
        std::snprintf(missed + length, sizeof missed - size(length),
                      "; 99 %% within 10 degrees of forward and at cosines below 0.15, got %.2f %% "
                      "and %.2f %%",
                      forward, grazing);
    throw std::runtime_error("verify: " + command.table + ": " + missed);
}

}  // namespace

void add_verify(CLI::App& app) {
    auto command = std::make_shared<VerifyCommand>();
    CLI::App* verify =
        app.add_subcommand("verify", "Check a table against the solver at random points");
    add_table(*verify, command->table);
    verify->add_option("--samples", command->options.samples, "Random points")
        ->capture_default_str()
        ->check(whole_number(1, 100000000));
    verify->add_option("--seed", command->options.seed, "Seed of the random points")
        ->capture_default_str()
        ->check(whole_number(0, std::numeric_limits<unsigned>::max()));
    add_threads(*verify, command->options.threads);
    verify->add_flag("--bound", command->options.bound,
                     "Look up through bound slices, as renderers do, instead of five axes at once");
    verify->add_flag("--quiet", command->quiet, "No progress");
    add_max_memory(*verify, command->reading);
    verify->footer(
        "Exit code 1 when the table misses the tolerance that it states: 99.9 % of values within "
        "it, "
        "all within five times it. Peaked phase functions are also judged at points drawn near "
        "forward and at grazing pairs of directions, 99 % of either within it; of a narrow peak "
        "(Henyey-Greenstein: g from 0.84 on) directions with a cosine below 0.15 are shown apart "
        "and not judged.\nExample:\n"
        "  stratus verify saturn_rings.h5 --samples 2000");
    verify->callback([command] { run_verify(*command); });
}

}  // namespace stratus
