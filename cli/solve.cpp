// `stratus solve`: the solver without a table; R and T at exact geometries, or fluxes.
#include "allowed.h"
#include "commands.h"
#include "query.h"

#include <stratus/runtime/angle.h>
#include <stratus/runtime/phase_function.h>
#include <stratus/transfer/solve.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

namespace stratus {
namespace {

struct SolveCommand {
    std::string phase, query, output, scheme = "harmonic";
    double albedo = 0, optical_depth = 0;
    int nodes = 32;
    std::vector<double> mu_in;
    bool asked = false;  // a query was given
    bool quiet = false;
};

/// Cosines solved at once: extra directions cost as much as nodes do.
constexpr std::size_t most_cosines = 64;

LayerSolution solve_at(const SolveCommand& command, const PhaseFunction& phase,
                       const std::vector<double>& mu) {
    SolverOptions options;
    options.nodes = command.nodes;
    options.scheme = command.scheme == "classic" ? Scheme::classic : Scheme::harmonic;
    return solve_layer(phase, command.albedo, command.optical_depth, mu, options);
}

void write_row(std::ostream& out, const std::vector<double>& row, const SolvedValue& R,
               const SolvedValue& T) {
    for (std::size_t c = 0; c < row.size(); ++c) out << (c ? "," : "") << shortest_text(row[c]);
    for (double value : {R.total, T.total, R.single, T.single, R.multiple, T.multiple})
        out << ',' << full_text(value);
    out << '\n';
}

void answer_query(const SolveCommand& command, const PhaseFunction& phase) {
    require_different_files("solve", command.query, command.output);
    const CsvTable query = read_query(command.query, {"mu_in", "mu_out", "azimuth_deg"});
    const auto column = [&](const char* name) {
        return static_cast<std::size_t>(query.column(name));
    };
    const std::size_t in = column("mu_in"), out = column("mu_out"), azimuth = column("azimuth_deg");
    write_answer(command.output, [&](std::ostream& stream) {
        for (const std::string& name : query.columns) stream << name << ',';
        stream << "reflection,transmission,reflection_single,transmission_single,"
                  "reflection_multiple,transmission_multiple\n";
        for (std::size_t first = 0; first < query.rows.size();) {
            // As many rows as share a list of cosines of reasonable length.
            std::map<double, int> index;
            std::vector<double> mu;
            std::size_t last = first;
            for (; last < query.rows.size() && mu.size() + 2 <= most_cosines; ++last)
                for (const std::size_t c : {in, out})
                    if (index.try_emplace(query.rows[last][c], static_cast<int>(mu.size())).second)
                        mu.push_back(query.rows[last][c]);
            const LayerSolution solution = solve_at(command, phase, mu);
            for (; first < last; ++first) {
                const std::vector<double>& row = query.rows[first];
                const double phi = radians(row[azimuth]);
                write_row(stream, row, solution.reflection(index[row[in]], index[row[out]], phi),
                          solution.transmission(index[row[in]], index[row[out]], phi));
            }
        }
    });
}

void answer_fluxes(const SolveCommand& command, const PhaseFunction& phase) {
    const LayerSolution solution = solve_at(command, phase, command.mu_in);
    write_answer(command.output, [&](std::ostream& out) {
        const auto number = [](double value) {  // JSON has no infinity
            return std::isinf(value) ? std::string("\"inf\"") : full_text(value);
        };
        out << "{\n  \"albedo\": " << number(command.albedo)
            << ",\n  \"optical_depth\": " << number(command.optical_depth)
            << ",\n  \"spherical_albedo\": " << number(solution.spherical_albedo)
            << ",\n  \"total_transmittance\": " << number(solution.total_transmittance)
            << ",\n  \"absorptance\": "
            << number(command.albedo == 1
                          ? 0
                          : 1 - solution.spherical_albedo - solution.total_transmittance);
        if (!command.mu_in.empty()) {
            const auto list = [&](const char* name, auto&& value) {
                out << ",\n  \"" << name << "\": [";
                for (int i = 0; i < solution.mu.size(); ++i)
                    out << (i ? ", " : "") << number(value(i));
                out << ']';
            };
            list("mu_in", [&](int i) { return solution.mu(i); });
            list("plane_albedo", [&](int i) { return solution.plane_albedo(i); });
            list("diffuse_transmittance", [&](int i) { return solution.diffuse_transmittance(i); });
            list("direct_transmittance", [&](int i) {
                return direct_transmittance(command.optical_depth, solution.mu(i));
            });
        }
        out << "\n}\n";
    });
}

void run_solve(const SolveCommand& command) {
    std::vector<std::string> notes;
    const PhaseFunction phase = parse_phase_function(command.phase, "", &notes);
    if (!command.quiet)
        for (const std::string& note : notes) std::cerr << "stratus: note: " << note << '\n';
    if (command.asked)
        answer_query(command, phase);
    else
        answer_fluxes(command, phase);
}

}  // namespace

void add_solve(CLI::App& app) {
    auto command = std::make_shared<SolveCommand>();
    CLI::App* solve = app.add_subcommand("solve", "Solve one layer exactly, without a table");
    solve
        ->add_option("--phase", command->phase,
                     "Phase function: isotropic, rayleigh, anisotropic:x=X, lambert_sphere, "
                     "henyey_greenstein:g=G, "
                     "tabulated:file=F.csv, moments:file=F.csv, or a sum 0.6*NAME + 0.4*NAME")
        ->required();
    solve->add_option("--albedo", command->albedo, "Single-scattering albedo, [0, 1]")
        ->required()
        ->check(number("in [0, 1]", [](double albedo) { return albedo >= 0 && albedo <= 1; }));
    solve->add_option("--optical-depth", command->optical_depth, "Vertical optical depth, [0, inf]")
        ->required()
        ->check(number("in [0, inf]", [](double depth) { return depth >= 0; }));
    solve->add_option("--nodes", command->nodes, "Gauss nodes of the solver, [1, 512]")
        ->capture_default_str()
        ->check(whole_number(1, 512));
    solve
        ->add_option(
            "--scheme", command->scheme,
            "harmonic (doubling as an arithmetic-harmonic mean) or classic (textbook doubling)")
        ->capture_default_str()
        ->check(CLI::IsMember({"harmonic", "classic"}));
    CLI::Option* query = solve
                             ->add_option("--query", command->query,
                                          "CSV with columns mu_in, mu_out, azimuth_deg; - is "
                                          "standard input. Without: fluxes only")
                             ->check(file_name());
    solve
        ->add_option("--mu-in", command->mu_in,
                     "Cosines at which fluxes are given, (0, 1], comma between")
        ->delimiter(',')
        ->check(number("in (0, 1]", [](double mu) { return mu > 0 && mu <= 1; }))
        ->excludes(query);
    solve
        ->add_option("-o,--output", command->output, "File to write. Default or -: standard output")
        ->check(file_name());
    solve->add_flag("--quiet", command->quiet, "No notes");
    solve->footer(
        "Examples:\n"
        "  stratus solve --phase henyey_greenstein:g=0.75 --albedo 0.99 --optical-depth 8 --mu-in "
        "0.5,1\n"
        "  printf 'mu_in,mu_out,azimuth_deg\\n0.5,0.8,60\\n' \\\n"
        "    | stratus solve --phase rayleigh --albedo 1 --optical-depth 0.3 --query -");
    solve->callback([command, query] {
        command->asked = query->count() > 0;
        run_solve(*command);
    });
}

}  // namespace stratus
