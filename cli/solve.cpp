// `stratus solve`: the solver without a table; R and T at exact geometries, or fluxes, of one layer
// or of a stack; with --levels the light inside, as CSV.
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/transfer/solve_to_tolerance.h>

#include "methods.h"
#include "options.h"
#include "progress.h"

#include <cmath>
#include <ostream>
#include <set>

namespace stratus {
namespace {

struct SolveCommand {
    std::string phase, albedo, over, layers, query, output;
    SolveRequest request;
    std::vector<double> mu_in, levels;
    const CLI::App* given = nullptr;
    bool accept = false;
    bool quiet = false;
};

std::vector<double> row_values(const MethodRow& answer) {
    const auto& [R, T] = answer.value;
    std::vector<double> values{R.total, T.total, R.single, T.single, R.multiple, T.multiple};
    values.insert(values.end(), answer.more.begin(), answer.more.end());
    return values;
}

/// Remarks on the answers that users have to be told.
struct Findings {
    int negative = 0;  // values: they come from a phase series cut short
    double lowest = 0;
    std::size_t rows = 0, missing = 0;  // the tolerance
    std::string worst;                  // of those missing it
    double worst_error = 0;             // relative

    void look_at(const RowDirection& at, const MethodRow& row) {
        constexpr double rounding = 1e-15;
        bool misses = false;
        for (const Side side : both_sides) {
            if (at.side && at.side != side) continue;
            const double value = row.value[side].total;
            if (value < -rounding) {
                ++negative;
                lowest = std::min(lowest, value);
            }
            if (!row.misses[side]) continue;
            misses = true;
            const bool reflected = side == Side::reflection;
            const double error = relative_error(value, row.more[reflected ? 0 : 1]);
            if (error <= worst_error) continue;
            worst_error = error;
            const Geometry& geometry = at.geometry;
            worst = std::string(reflected ? "R" : "T") + " at mu_in " +
                    shortest_text(geometry.mu_in) + ", mu_out " + shortest_text(geometry.mu_out) +
                    ", azimuth_deg " +
                    shortest_text(std::round(degrees(geometry.azimuth) * 1e9) / 1e9);
        }
        ++rows;
        missing += misses;
    }
};

Findings answer_query(const SolveCommand& command, const Method& method) {
    const Query query = read_query(command.query, {});
    std::vector<std::string> columns{"reflection",          "transmission",
                                     "reflection_single",   "transmission_single",
                                     "reflection_multiple", "transmission_multiple"};
    columns.insert(columns.end(), method.more_columns.begin(), method.more_columns.end());
    Findings findings;
    write_answer(command.output, [&](std::ostream& stream) {
        write_answer_header(stream, query, columns);
        for (std::size_t first = 0; first < query.directions.size();) {
            // Rows are taken together as long as their list of cosines keeps a reasonable length.
            std::set<double> cosines;
            std::vector<Geometry> geometries;
            for (std::size_t row = first;
                 row < query.directions.size() && cosines.size() <= method.max_cosines - 2; ++row) {
                geometries.push_back(query.directions[row].geometry);
                cosines.insert({geometries.back().mu_in, geometries.back().mu_out});
            }
            for (const MethodRow& answer : method.rows(geometries)) {
                write_answer_row(stream, query, first, columns, row_values(answer));
                findings.look_at(query.directions[first++], answer);
            }
        }
    });
    return findings;
}

/// JSON has no infinity.
std::string json_number(double value) { return std::isinf(value) ? "\"inf\"" : full_text(value); }

/// `medium`: what the layer or the stack is, as far as numbers tell.
/// Returns whether they miss the tolerance.
bool answer_fluxes(const SolveCommand& command, const Method& method,
                   const std::vector<std::pair<std::string, double>>& medium) {
    const MethodFluxes fluxes = method.fluxes(command.mu_in);
    std::vector<std::string> fields;
    const auto add = [&](const std::string& name, const std::string& value) {
        fields.push_back("\n  \"" + name + "\": " + value);
    };
    for (const auto* const numbers : {&medium, &fluxes.uniform})
        for (const auto& [name, value] : *numbers) add(name, json_number(value));
    for (const auto& [name, values] : fluxes.lists) {
        std::vector<std::string> numbers;
        for (const double value : values) numbers.push_back(json_number(value));
        add(name, "[" + joined(numbers) + "]");
    }
    write_answer(command.output,
                 [&](std::ostream& out) { out << '{' << joined(fields, ",") << "\n}\n"; });
    return fluxes.misses;
}

/// A number, or the albedo of the droplets.
double read_albedo(const std::string& text, const PhaseFunction& phase_function) {
    double albedo = 0;
    if (read_number(text, albedo) == text.size()) return albedo;
    const std::optional<double> own = phase_function.albedo();
    require(own.has_value(), "solve", "--albedo",
            "a number unless --phase is of droplets (mie) or has a geometric_albedo", text);
    return *own;
}

/// The stack of a file, or the one layer that options describe.
Stack make_stack(SolveCommand& command, std::vector<std::string>& notes) {
    if (!command.layers.empty()) return read_stack(command.layers, &notes);
    SolveRequest& request = command.request;
    request.phase_function = read_phase_function(command.phase, "", &notes);
    request.albedo = read_albedo(command.albedo, request.phase_function);
    return {{{request.phase_function, request.albedo, request.optical_depth}},
            command.over.empty() ? LowerBoundary() : read_over("solve", command.over)};
}

/// Describes the stack by its numbers.
std::vector<std::pair<std::string, double>> describe_medium(const SolveCommand& command,
                                                            const Stack& stack) {
    if (command.layers.empty())
        return {{"albedo", command.request.albedo},
                {"optical_depth", command.request.optical_depth}};
    return {{"optical_depth", stack.optical_depth()}};
}

/// The largest relative error of what the rows ask for.
double worst_error(const SolvedGeometries& solved, const Query& query) {
    double worst = 0;
    for (std::size_t r = 0; r < solved.at.size(); ++r) {
        const SolvedGeometry& at = solved.at[r];
        const std::optional<Side> side = query.directions[r].side;
        if (side != Side::transmission)
            worst = std::max(worst, relative_error(at.reflection.total, at.reflection_error));
        if (side != Side::reflection)
            worst = std::max(worst, relative_error(at.transmission.total, at.transmission_error));
    }
    return worst;
}

/// Writes fluxes at every level for every mu_in. Returns what misses the tolerance, in words; "" where
/// nothing does.
std::string answer_fluxes_inside(const SolveCommand& command, const Stack& stack) {
    const std::vector<double> mu_in =
        command.mu_in.empty() ? std::vector<double>{1} : command.mu_in;
    const SolverOptions options = make_options(command.request);
    const SolvedInside solved =
        solve_fluxes_inside(stack.layers, stack.lower_boundary, command.levels, mu_in, options);
    write_answer(command.output, [&](std::ostream& out) {
        out << "level,mu_in,direct_flux,diffuse_flux,upward_flux,actinic_flux,heating_rate,error\n";
        for (const FluxesAtLevel& at : solved.levels)
            for (std::size_t i = 0; i < mu_in.size(); ++i) {
                out << shortest_text(at.optical_depth) << ',' << shortest_text(mu_in[i]);
                for (const double value : {at.direct[i], at.diffuse[i], at.upward[i], at.actinic[i],
                                           at.heating_rate[i], solved.error})
                    out << ',' << full_text(value);
                out << '\n';
            }
    });
    const double tolerance = options.tolerance;
    return tolerance > 0 && solved.relative_error > tolerance ? "see error" : "";
}

/// Writes radiance at every level for every row of the query, and returns what misses likewise.
std::string answer_query_inside(const SolveCommand& command, const Stack& stack) {
    const SolverOptions options = make_options(command.request);
    const std::vector<std::string> columns{
        "level",           "upward",          "downward",          "upward_single",
        "downward_single", "upward_multiple", "downward_multiple", "upward_error",
        "downward_error"};
    const Query query = read_query(command.query, {});
    std::vector<Geometry> geometries;
    for (const RowDirection& direction : query.directions) geometries.push_back(direction.geometry);
    double worst = 0;
    write_answer(command.output, [&](std::ostream& out) {
        write_answer_header(out, query, columns);
        for (const double level : command.levels) {
            const SolvedGeometries solved = solve_geometries_inside(
                stack.layers, stack.lower_boundary, level, geometries, options);
            worst = std::max(worst, worst_error(solved, query));
            for (std::size_t r = 0; r < geometries.size(); ++r) {
                const auto& [up, down, up_error, down_error] = solved.at[r];
                write_answer_row(out, query, r, columns,
                                 {level, up.total, down.total, up.single, down.single, up.multiple,
                                  down.multiple, up_error, down_error});
            }
        }
    });
    const double tolerance = options.tolerance;
    if (tolerance == 0 || worst <= tolerance) return "";
    return "the largest relative error is some " + short_number(worst);
}

/// Options that some schemes alone know.
struct SchemeOption {
    const char* name;
    std::vector<std::string> schemes;
};

/// Refuses options that the scheme does not know, and a layer that is not described in full.
void check_given(const CLI::App& solve, const std::string& scheme) {
    const auto given = [&](const char* name) { return solve.get_option(name)->count() > 0; };
    for (const char* needed : {"--phase", "--albedo", "--optical-depth"})
        if (!given("--layers") && !given(needed)) throw CLI::RequiredError(needed);
    for (const auto& [name, schemes] : {SchemeOption{"--tolerance", {"harmonic"}},
                                        {"--levels", {"harmonic"}},
                                        {"--over", {"harmonic"}},
                                        {"--orders", {"harmonic", "markov", "photons"}},
                                        {"--start", {"classic"}},
                                        {"--start-depth", {"classic"}},
                                        {"--sublayers", {"markov"}},
                                        {"--photons", {"photons"}},
                                        {"--seed", {"photons"}},
                                        {"--backward-collisions", {"photons"}},
                                        {"--threads", {"photons"}}})
        require(!given(name) || is_listed(scheme, schemes), "solve", "--scheme",
                joined(schemes, " or ") + " with " + name, scheme);
}

void run_solve(SolveCommand command) {
    check_given(*command.given, command.request.scheme);
    require_different_files("solve", {command.query, command.layers}, {command.output});
    std::vector<std::string> notes;
    const auto note = [&](const std::string& text) {
        if (!command.quiet) say("note: " + text);
    };
    const SolveRequest& request = command.request;
    const Stack stack = make_stack(command, notes);
    for (const std::string& text : notes) note(text);
    const auto refuse_unless_accepted = [&](const std::string& missing) {
        if (missing.empty() || command.accept) return;
        throw std::runtime_error("solve: the tolerance of " + shortest_text(request.tolerance) +
                                 " is missed, and 512 nodes would not reach it: " + missing +
                                 " (--accept: exit code 0)");
    };
    if (!command.levels.empty())
        return refuse_unless_accepted(command.query.empty() ? answer_fluxes_inside(command, stack)
                                                            : answer_query_inside(command, stack));
    const bool is_layer = command.layers.empty() && command.over.empty();
    const Method method = is_layer ? make_method(request) : make_method(stack, request);
    if (command.query.empty()) {
        const bool misses = answer_fluxes(command, method, describe_medium(command, stack));
        return refuse_unless_accepted(misses ? "see error" : "");
    }
    const Findings findings = answer_query(command, method);
    if (findings.negative > 0)
        note(std::to_string(findings.negative) + " values are negative, down to " +
             shortest_text(findings.lowest) +
             (request.scheme == "photons"
                  ? ": chance, see their errors"
                  : ": the phase function's series is, as far as these --nodes reach"));
    if (findings.missing > 0)
        refuse_unless_accepted("by " + std::to_string(findings.missing) + " of " +
                               std::to_string(findings.rows) + " rows, most by " + findings.worst +
                               ", whose relative error is some " +
                               short_number(findings.worst_error));
}

void add_layer_options(CLI::App& solve, SolveCommand& command) {
    add_text(solve, "--phase", command.phase, "a phase function",
             "Phase function, one of\n" + phase_function_help());
    const CLI::Validator albedo =
        number("in [0, 1], or phase_function", [](double w) { return w >= 0 && w <= 1; });
    solve
        .add_option("--albedo", command.albedo,
                    "Single-scattering albedo, [0, 1]; phase_function: of droplets (mie)")
        ->check([albedo](const std::string& text) {
            return text == "phase_function" ? std::string() : albedo(text);
        });
    solve
        .add_option("--optical-depth", command.request.optical_depth,
                    "Vertical optical depth, [0, inf]")
        ->check(number_in("[0, inf]"));
    add_text(solve, "--over", command.over, "a ground",
             "The ground that the layer lies on: albedo of a Lambert surface, [0, 1], or\n" +
                 ground_help())
        ->type_name("GROUND");
    add_accuracy(solve, command.request.nodes, command.request.tolerance, command.accept,
                 ". Default of other schemes: classic 32, h-function 64, markov 16");
    solve
        .add_option("--scheme", command.request.scheme,
                    "harmonic (doubling as an arithmetic-harmonic mean), or a reference solver: "
                    "classic (textbook doubling), h-function (Chandrasekhar's H, X and Y; "
                    "isotropic only), markov (Markov chain), photons (Monte Carlo)")
        ->capture_default_str()
        ->check(CLI::IsMember({"harmonic", "classic", "h-function", "markov", "photons"}));
}

/// Options that some schemes know.
void add_scheme_options(CLI::App& solve, SolveCommand& command) {
    add_whole_number(solve, "--orders", command.request.orders, 1, 200,
                     "Light scattered at most this often, [1, 200]; harmonic and markov tell "
                     "every order");
    solve
        .add_option("--start", command.request.start,
                    "classic: diamond (default) or single, the thin layer's start")
        ->check(CLI::IsMember({"single", "diamond"}));
    solve
        .add_option("--start-depth", command.request.start_depth,
                    "classic: optical depth of the thin layer at most, [1e-15, 1]. Default: "
                    "1e-3 of the smallest cosine")
        ->check(number_in("[1e-15, 1]"));
    add_whole_number(solve, "--sublayers", command.request.sublayers, 4, 1024,
                     "markov: sublayers, even, [4, 1024]. Default: 32");
    add_whole_number(solve, "--photons", command.request.photons, 2, 1'000'000'000'000,
                     "photons: how many for each mu_in, [2, 1e12]. Default: 1000000");
    add_whole_number(solve, "--seed", command.request.seed, 0, 1'000'000'000'000'000'000,
                     "photons: another draw. Default: 1");
    add_whole_number(solve, "--backward-collisions", command.request.backward_collisions, 0, 100,
                     "photons: of paths also followed back from the exits, [0, 100]; 8 for narrow "
                     "peaks. Default: 0");
    add_whole_number(solve, "--threads", command.request.threads, 0, 1024,
                     "photons: threads; 0: one for each processor. The answer is the same");
}

/// Stacks, and what is asked.
void add_request_options(CLI::App& solve, SolveCommand& command) {
    add_file(solve, "--layers", command.layers,
             "TOML file of a stack: tables [[layers]], top first, with phase_function, "
             "albedo, optical_depth; and [below], the lower boundary, with lambert_albedo, "
             "with ground (as --over), or with phase_function and albedo")
        ->excludes("--phase", "--albedo", "--optical-depth", "--over", "--scheme");
    add_file(solve, "--query", command.query,
             "CSV with columns " + direction_columns_help +
                 "; - is standard input. Without: fluxes only");
    add_numbers(solve, "--mu-in", command.mu_in, "(0, 1]",
                "Cosines at which fluxes are given, (0, 1], comma between")
        ->excludes("--query");
    add_numbers(solve, "--levels", command.levels, "[0, inf)",
                "Optical depths, from the top, at which the light inside is given as CSV: fluxes "
                "at --mu-in (default 1), or with --query radiance. Comma between, in [0, the whole "
                "depth]")
        ->excludes("--orders");
    add_file(solve, "-o,--output", command.output, "File to write. Default or -: standard output");
    solve.add_flag("--quiet", command.quiet, "No notes");
}

}  // namespace

void add_solve(CLI::App& app) {
    const auto [command, options] = add_command<SolveCommand>(
        app, "solve", "Solve a layer or a stack exactly, without a table", run_solve);
    options.given = &command;
    add_layer_options(command, options);
    add_scheme_options(command, options);
    add_request_options(command, options);
    command.footer(
        observed_angles_help +
        "Answers of the side that a row of such angles does not see are nan.\n"
        "With --levels fluxes are over the incident flux: direct_flux, exp(-level / mu_in), and "
        "diffuse_flux go down, upward_flux goes up. actinic_flux is 4 pi times the mean intensity, "
        "beam included; heating_rate is what is absorbed of it per unit of optical depth, (1 - w) "
        "actinic_flux, between two layers with w of the lower one. Radiances are pi I / (mu_in "
        "F0), "
        "as R and T are, going up and down, without the beam.\n"
        "Examples:\n"
        "  stratus solve --phase henyey_greenstein:g=0.75 --albedo 0.99 --optical-depth 8 --mu-in "
        "0.5,1\n"
        "  printf 'mu_in,mu_out,azimuth_deg\\n0.5,0.8,60\\n' \\\n"
        "    | stratus solve --phase rayleigh --albedo 1 --optical-depth 0.3 --query -\n"
        "  printf 'incidence_deg,emission_deg,phase_deg\\n60,35,40\\n60,120,90\\n' \\\n"
        "    | stratus solve --phase rayleigh --albedo 1 --optical-depth 0.3 --query -\n"
        "  stratus solve --scheme photons --photons 200000 --phase isotropic --albedo 0.9 "
        "--optical-depth 1\n"
        "  stratus solve --layers tables/stacks/haze_over_ground.toml --mu-in 0.5,1\n"
        "  stratus solve --layers tables/stacks/haze_over_ground.toml --mu-in 0.5 --levels "
        "0,0.1,0.2");
}

}  // namespace stratus
