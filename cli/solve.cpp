// `stratus solve`: the solver without a table; R and T at exact geometries, or fluxes, of one layer
// or of a stack.
#include "allowed.h"
#include "commands.h"
#include "query.h"

#include <stratus/bake/stack_file.h>
#include <stratus/runtime/angle.h>
#include <stratus/runtime/phase_function.h>
#include <stratus/transfer/solve.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

namespace stratus {
namespace {

struct SolveCommand {
    std::string phase, layers, query, output, scheme = "harmonic";
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

StackSolution solve_stack_at(const SolveCommand& command, const Stack& stack,
                             const std::vector<double>& mu) {
    SolverOptions options;
    options.nodes = command.nodes;
    return solve_stack(stack.layers, stack.below, mu, options);
}

void write_row(std::ostream& out, const std::vector<double>& row, const SolvedValue& R,
               const SolvedValue& T) {
    for (std::size_t c = 0; c < row.size(); ++c) out << (c ? "," : "") << shortest_text(row[c]);
    for (double value : {R.total, T.total, R.single, T.single, R.multiple, T.multiple})
        out << ',' << full_text(value);
    out << '\n';
}

/// `solve(mu)` is a LayerSolution or a StackSolution.
template <class Solve>
void answer_query(const SolveCommand& command, Solve solve) {
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
            const auto solution = solve(mu);
            for (; first < last; ++first) {
                const std::vector<double>& row = query.rows[first];
                const double phi = radians(row[azimuth]);
                write_row(stream, row, solution.reflection(index[row[in]], index[row[out]], phi),
                          solution.transmission(index[row[in]], index[row[out]], phi));
            }
        }
    });
}

/// JSON of numbers and lists, one a line.
class Json {
  public:
    explicit Json(std::ostream& out) : out_(out) { out_ << '{'; }

    void number(const char* name, double value) { begin(name) << text(value); }

    /// value(i) of every cosine.
    template <class Value>
    void list(const char* name, Eigen::Index count, Value value) {
        begin(name) << '[';
        for (Eigen::Index i = 0; i < count; ++i) out_ << (i ? ", " : "") << text(value(i));
        out_ << ']';
    }

    void end() { out_ << "\n}\n"; }

  private:
    static std::string text(double value) {  // JSON has no infinity
        return std::isinf(value) ? std::string("\"inf\"") : full_text(value);
    }

    std::ostream& begin(const char* name) {
        out_ << (first_ ? "" : ",") << "\n  \"" << name << "\": ";
        first_ = false;
        return out_;
    }

    std::ostream& out_;
    bool first_ = true;
};

/// What layers and stacks have in common.
template <class Solution>
void write_fluxes(Json& json, const Solution& solution, bool is_conservative) {
    json.number("spherical_albedo", solution.spherical_albedo);
    json.number("total_transmittance", solution.total_transmittance);
    json.number("absorptance",
                is_conservative ? 0 : 1 - solution.spherical_albedo - solution.total_transmittance);
}

template <class Solution>
void write_fluxes_at_cosines(Json& json, const Solution& solution, double depth) {
    const Eigen::Index count = solution.mu.size();
    json.list("mu_in", count, [&](auto i) { return solution.mu(i); });
    json.list("plane_albedo", count, [&](auto i) { return solution.plane_albedo(i); });
    json.list("diffuse_transmittance", count,
              [&](auto i) { return solution.diffuse_transmittance(i); });
    json.list("direct_transmittance", count,
              [&](auto i) { return direct_transmittance(depth, solution.mu(i)); });
}

void answer_fluxes(const SolveCommand& command, const PhaseFunction& phase) {
    const LayerSolution solution = solve_at(command, phase, command.mu_in);
    write_answer(command.output, [&](std::ostream& out) {
        Json json(out);
        json.number("albedo", command.albedo);
        json.number("optical_depth", command.optical_depth);
        write_fluxes(json, solution, command.albedo == 1);
        if (!command.mu_in.empty()) write_fluxes_at_cosines(json, solution, command.optical_depth);
        json.end();
    });
}

void answer_fluxes(const SolveCommand& command, const Stack& stack) {
    const StackSolution solution = solve_stack_at(command, stack, command.mu_in);
    double depth = 0;
    bool is_conservative = !stack.below.is_something() || stack.below.albedo == 1;
    for (const StackLayer& layer : stack.layers) {
        depth += layer.optical_depth;
        is_conservative = is_conservative && layer.albedo == 1;
    }
    write_answer(command.output, [&](std::ostream& out) {
        Json json(out);
        json.number("optical_depth", depth);
        write_fluxes(json, solution, is_conservative);
        if (stack.below.is_something())
            json.number("ground_absorptance", solution.spherical_ground_absorptance);
        if (!command.mu_in.empty()) {
            const double infinity = std::numeric_limits<double>::infinity();
            write_fluxes_at_cosines(json, solution, solution.is_opaque() ? infinity : depth);
            if (stack.below.is_something())
                json.list("plane_ground_absorptance", solution.mu.size(),
                          [&](auto i) { return solution.ground_absorptance(i); });
        }
        json.end();
    });
}

void run_solve(const SolveCommand& command) {
    std::vector<std::string> notes;
    const auto say_notes = [&] {
        if (command.quiet) return;
        for (const std::string& note : notes) std::cerr << "stratus: note: " << note << '\n';
    };
    const auto answer = [&](const auto& medium, auto solve) {
        say_notes();
        if (command.asked)
            answer_query(command,
                         [&](const std::vector<double>& mu) { return solve(command, medium, mu); });
        else
            answer_fluxes(command, medium);
    };
    if (command.layers.empty())
        answer(parse_phase_function(command.phase, "", &notes), solve_at);
    else
        answer(read_stack(command.layers, &notes), solve_stack_at);
}

}  // namespace

void add_solve(CLI::App& app) {
    auto command = std::make_shared<SolveCommand>();
    CLI::App* solve =
        app.add_subcommand("solve", "Solve a layer or a stack exactly, without a table");
    CLI::Option* const phase =
        solve->add_option("--phase", command->phase,
                          "Phase function: isotropic, rayleigh, anisotropic:x=X, lambert_sphere, "
                          "henyey_greenstein:g=G, "
                          "tabulated:file=F.csv, moments:file=F.csv, or a sum 0.6*NAME + 0.4*NAME");
    CLI::Option* const albedo =
        solve->add_option("--albedo", command->albedo, "Single-scattering albedo, [0, 1]")
            ->check(number("in [0, 1]", [](double w) { return w >= 0 && w <= 1; }));
    CLI::Option* const optical_depth =
        solve
            ->add_option("--optical-depth", command->optical_depth,
                         "Vertical optical depth, [0, inf]")
            ->check(number("in [0, inf]", [](double depth) { return depth >= 0; }));
    solve->add_option("--nodes", command->nodes, "Gauss nodes of the solver, [1, 512]")
        ->capture_default_str()
        ->check(whole_number(1, 512));
    CLI::Option* const scheme =
        solve
            ->add_option(
                "--scheme", command->scheme,
                "harmonic (doubling as an arithmetic-harmonic mean) or classic (textbook doubling)")
            ->capture_default_str()
            ->check(CLI::IsMember({"harmonic", "classic"}));
    CLI::Option* const layers =
        solve
            ->add_option("--layers", command->layers,
                         "TOML file of a stack: tables [[layers]], top first, with phase_function, "
                         "albedo, optical_depth; beneath them [below] with lambert_albedo, or with "
                         "phase_function and albedo")
            ->check(file_name())
            ->excludes(phase, albedo, optical_depth, scheme);
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
        "    | stratus solve --phase rayleigh --albedo 1 --optical-depth 0.3 --query -\n"
        "  stratus solve --layers tables/stacks/haze_over_ground.toml --mu-in 0.5,1");
    solve->callback([command, query, phase, albedo, optical_depth, layers] {
        for (const CLI::Option* needed : {phase, albedo, optical_depth})
            if (layers->count() == 0 && needed->count() == 0)
                throw CLI::RequiredError(needed->get_name());
        command->asked = query->count() > 0;
        run_solve(*command);
    });
}

}  // namespace stratus
