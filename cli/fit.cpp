// `stratus fit`: albedos, optical depths and asymmetries of rings from their observed brightness.
#include <stratus/fit/fit.h>

#include <stratus/bake/parallel.h>
#include <stratus/io/phase_file.h>
#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/number_text.h>

#include "allowed.h"
#include "commands.h"
#include "opposition_option.h"
#include "query.h"
#include "table_option.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {
namespace {

constexpr int solver_nodes = 24;

struct FitCommand {
    std::string observations, table, phase, second_phase, output;
    bool single = false;
    std::vector<std::string> fixed, free;
    std::string density = "0";
    std::string opposition;
    int threads = 0;
    ReadOptions reading;
};

/// The observations of one radius.
struct Bin {
    double radius = 0;
    std::vector<Observation> observations;
};

/// Light of a row: by its side where there is such a column, by the sign of mu_out otherwise.
Light light_of(const CsvTable& rows, const std::vector<double>& row) {
    constexpr Light by_side[] = {Light::reflected, Light::transmitted, Light::beam};
    if (rows.has_column("side"))
        return by_side[static_cast<std::size_t>(
            row[static_cast<std::size_t>(rows.column("side"))])];
    return row[static_cast<std::size_t>(rows.column("mu_out"))] < 0 ? Light::transmitted
                                                                    : Light::reflected;
}

bool all_are_beams(const CsvTable& rows) {
    return std::ranges::all_of(rows.rows, [&](const std::vector<double>& row) {
        return light_of(rows, row) == Light::beam;
    });
}

/// Bins in the order in which their radii appear; a single one without a column of radii.
std::vector<Bin> bins_of(const CsvTable& rows, const LayerModel& model) {
    const auto column = [&](const char* name) {
        return static_cast<std::size_t>(rows.column(name));
    };
    const std::size_t mu_out = column("mu_out");
    const std::size_t brightness = column("brightness"), sigma = column("sigma");
    const bool scattered = !all_are_beams(rows);
    const std::size_t mu_in = scattered ? column("mu_in") : mu_out;
    const std::size_t azimuth = scattered ? column("azimuth_deg") : mu_out;  // not used by beams
    std::vector<Bin> bins;
    for (std::size_t r = 0; r < rows.rows.size(); ++r) {
        const std::vector<double>& row = rows.rows[r];
        const Light light = light_of(rows, row);
        if (!model.has(light))
            throw std::invalid_argument(rows.name + ", line " + std::to_string(rows.lines[r]) +
                                        ": side must be one that the table holds, got " +
                                        side_names[static_cast<std::size_t>(light)]);
        const double radius = rows.has_column("radius") ? row[column("radius")] : 0;
        auto bin = std::ranges::find(bins, radius, &Bin::radius);
        if (bin == bins.end()) bin = bins.insert(bin, {radius, {}});
        bin->observations.push_back({{row[mu_in], std::abs(row[mu_out]), radians(row[azimuth])},
                                     light,
                                     row[brightness],
                                     row[sigma]});
    }
    if (bins.empty()) throw std::invalid_argument(rows.name + ": no observations");
    return bins;
}

void check_counts(const std::vector<Bin>& bins, const CsvTable& rows, std::size_t free) {
    for (const Bin& bin : bins)
        if (bin.observations.size() < free)
            throw std::invalid_argument(
                rows.name + ": rows of a radius must be at least " + std::to_string(free) +
                ", one for each free parameter, got " + std::to_string(bin.observations.size()) +
                (rows.has_column("radius") ? " of " + shortest_text(bin.radius) : ""));
}

/// What `--fix` and `--free` call a parameter.
std::string option_name(const LayerModel& model, int parameter) {
    if (parameter == fit_optical_depth) return "tau";
    return fit_parameter_names(model)[static_cast<std::size_t>(parameter)];
}

/// Parameters that a model has, in the order of the answer.
std::vector<int> parameters_of(const LayerModel& model) {
    if (model.kinds() == 0) return {fit_optical_depth};
    if (model.kinds() == 1) return {fit_w1, fit_optical_depth, fit_g1};
    return {fit_w1, fit_w2, fit_optical_depth, fit_g1, fit_g2};
}

/// The parameter of that name.
int parameter_named(const std::string& option, const std::string& form, const LayerModel& model,
                    const std::string& name, const std::string& met) {
    std::vector<std::string> names;
    for (const int p : parameters_of(model)) {
        names.push_back(option_name(model, p));
        if (names.back() == name) return p;
    }
    throw std::invalid_argument("fit: " + option + " must be " + form + " out of " + joined(names) +
                                ", got " + met);
}

FitOptions options_of(const FitCommand& command, const LayerModel& model) {
    FitOptions options;
    options.density = parse_density("fit", command.density);
    options.opposition = parse_opposition("fit", command.opposition, options.density);
    std::optional<double>* const held[] = {&options.optical_depth, &options.w1, &options.w2,
                                           &options.g1, &options.g2};
    for (const std::string& text : command.fixed) {
        const std::size_t equals = text.find('=');
        double value = 0;
        const std::string number = equals == std::string::npos ? "" : text.substr(equals + 1);
        const int p =
            parameter_named("--fix", "NAME=VALUE with a name", model, text.substr(0, equals), text);
        if (number.empty() || read_number(number, value) != number.size())
            throw std::invalid_argument("fit: --fix must be NAME=VALUE, got " + text);
        if (held[p]->has_value())
            throw std::invalid_argument("fit: --fix must name " + option_name(model, p) +
                                        " once, got " + text);
        *held[p] = value;
    }
    for (const std::string& name : command.free) {
        const int p = parameter_named("--free", "a name", model, name, name);
        if (held[p]->has_value())
            throw std::invalid_argument("fit: --free must not name what --fix holds, got " + name);
        if (p == fit_g1) options.free_g1 = true;
        if (p == fit_g2) options.free_g2 = true;
    }
    return options;
}

/// What predicts the brightness, with the table that it may look up.
struct Prediction {
    std::optional<Table> table;
    std::unique_ptr<LayerModel> model;
};

Prediction prediction_of(const FitCommand& command, bool beams_alone) {
    const bool has_table = !command.table.empty(), has_phase = !command.phase.empty();
    if (has_table && (has_phase || command.single))
        throw std::invalid_argument(
            "fit: --table must come without --phase and --single, got both");
    if (!has_phase && !command.second_phase.empty())
        throw std::invalid_argument("fit: --second-phase must come with --phase, got it alone");
    if (!has_phase && command.single)
        throw std::invalid_argument("fit: --single must come with --phase, got it alone");
    Prediction prediction;
    if (has_table) {
        prediction.table = read_noted_table(command.table, command.reading);
        prediction.model = table_model(prediction.table->view());
    } else if (has_phase) {
        std::vector<std::string> notes;
        const PhaseFunction first = read_phase_function(command.phase, "", &notes);
        std::optional<PhaseFunction> second;
        if (!command.second_phase.empty())
            second = read_phase_function(command.second_phase, "", &notes);
        for (const std::string& note : notes) std::cerr << "stratus: note: " << note << '\n';
        SolverOptions solver;
        solver.nodes = solver_nodes;
        prediction.model = command.single ? single_scattering_model(first, second)
                                          : solver_model(first, second, solver);
    } else if (beams_alone) {
        prediction.model = beam_model();
    } else {
        throw std::invalid_argument(
            "fit: --table or --phase must be given unless all rows are beams, got neither");
    }
    return prediction;
}

/// The columns of the answer.
struct Columns {
    std::vector<int> parameters;
    std::vector<std::string> names;  // of them
    bool radii = false;
};

Columns columns_of(const LayerModel& model, const FitOptions& options, bool radii) {
    Columns columns;
    columns.radii = radii;
    for (const int p : parameters_of(model)) {
        if ((p == fit_g1 && !options.free_g1) || (p == fit_g2 && !options.free_g2)) continue;
        columns.parameters.push_back(p);
        columns.names.push_back(fit_parameter_names(model)[static_cast<std::size_t>(p)]);
    }
    return columns;
}

void write_header(std::ostream& out, const Columns& columns) {
    if (columns.radii) out << "radius,";
    for (const std::string& name : columns.names) out << name << ',' << name << "_sigma,";
    for (std::size_t a = 0; a < columns.names.size(); ++a)
        for (std::size_t b = a + 1; b < columns.names.size(); ++b)
            out << "covariance_" << columns.names[a] << '_' << columns.names[b] << ',';
    out << "chi_square,degrees_of_freedom,probability,remarks\n";
}

void write_fit(std::ostream& out, const Columns& columns, const Bin& bin, const Fit& fit) {
    if (columns.radii) out << shortest_text(bin.radius) << ',';
    std::vector<std::size_t> places(columns.parameters.begin(), columns.parameters.end());
    for (const std::size_t p : places)
        out << full_text(fit.estimate[p].value) << ',' << full_text(fit.estimate[p].sigma) << ',';
    for (std::size_t a = 0; a < places.size(); ++a)
        for (std::size_t b = a + 1; b < places.size(); ++b)
            out << full_text(fit.covariance[places[a]][places[b]]) << ',';
    out << full_text(fit.chi_square) << ',' << fit.degrees_of_freedom << ','
        << full_text(fit.probability) << ",\"" << joined(fit.remarks, "; ") << "\"\n";
}

void run_fit(const FitCommand& command) {
    if (!command.output.empty()) {
        if (!command.table.empty()) require_different_files("fit", command.table, command.output);
        require_different_files("fit", command.observations, command.output);
    }
    const CsvTable rows = read_observations(command.observations, {"mu_out", "brightness", "sigma"},
                                            {"mu_in", "azimuth_deg", "radius", "side"});
    const Prediction prediction = prediction_of(command, !rows.rows.empty() && all_are_beams(rows));
    const LayerModel& model = *prediction.model;
    const FitOptions options = options_of(command, model);
    const std::vector<Bin> bins = bins_of(rows, model);
    check_counts(bins, rows, free_parameter_count(model, options));
    std::vector<Fit> fits(bins.size());
    parallel_for(static_cast<int>(bins.size()), command.threads, [&](int b) {
        const auto at = static_cast<std::size_t>(b);
        fits[at] = fit_layer(model, bins[at].observations, options);
    });
    const Columns columns = columns_of(model, options, rows.has_column("radius"));
    write_answer(command.output, [&](std::ostream& out) {
        write_header(out, columns);
        for (std::size_t b = 0; b < fits.size(); ++b) write_fit(out, columns, bins[b], fits[b]);
    });
}

void add_model_options(CLI::App& fit, FitCommand& command) {
    fit.add_option("--table", command.table,
                   "Baked table that predicts all orders, .h5, .exr or .stratus");
    add_max_memory(fit, command.reading);
    fit.add_option("--phase", command.phase,
                   "Without a table: the phase function. All orders are solved at the rows' own "
                   "geometries, some seconds a radius")
        ->check(file_name());
    fit.add_option("--second-phase", command.second_phase,
                   "Phase function of the second kind of particles, whose albedo is w2")
        ->check(file_name());
    fit.add_flag("--single", command.single,
                 "Light scattered once alone, in closed form: the paper's own inversion");
    fit.add_option("--fix", command.fixed,
                   "Hold parameters, NAME=VALUE, comma between: w1, w2 (w of one kind of "
                   "particles), tau, the optical depth, and g1, g2 (g)")
        ->delimiter(',')
        ->allow_extra_args(false);
    fit.add_option("--free", command.free,
                   "Fit g1 or g2 (g), too, asymmetries of --phase and --second-phase where they "
                   "are Henyey-Greenstein. Albedos and tau are free unless fixed")
        ->delimiter(',')
        ->allow_extra_args(false);
    add_density_and_opposition(fit, command.density, command.opposition);
}

}  // namespace

void add_fit(CLI::App& app) {
    auto command = std::make_shared<FitCommand>();
    CLI::App* fit = app.add_subcommand(
        "fit", "Fit albedos, the optical depth and asymmetries to observed brightnesses");
    fit->add_option("OBSERVATIONS", command->observations,
                    "CSV with columns mu_in, mu_out, azimuth_deg, brightness, sigma in any order; "
                    "side (lit, unlit or beam); and, for a fit of each radius, radius; "
                    "-: standard input")
        ->required()
        ->check(file_name());
    add_model_options(*fit, *command);
    fit->add_option("-o,--output", command->output, "CSV to write. Default or -: standard output")
        ->check(file_name());
    add_threads(*fit, command->threads);
    fit->footer(
        "brightness is I/F = mu_in R on the side lit, mu_in T on the side unlit (R = pi I / (mu_in "
        "F0)); sigma is its standard deviation. Without the column side, rows with mu_out < 0 are "
        "of the unlit side. Rows of the side beam are occultations: brightness is I/F0 = "
        "exp(-tau / mu_out), where mu_in and azimuth_deg do not count; a file of these alone needs "
        "neither table nor phase function, and gives tau.\n"
        "w1 and w2 are the albedos of the two kinds of particles, w that of one. Standard "
        "deviations and covariances come from the model linearised at the best fit, and are 0 for "
        "what was fixed. probability is that of so large a chi-square or a larger one; below "
        "0.001 the column remarks says that the model is refused. It also names parameters that "
        "the geometries do not determine, those at the edge of their range, and other layers that "
        "fit as well. Without a table tau is sought from 1e-4 to 64, g from -0.9 to 0.9 (-0.95 to "
        "0.95 with --single).\n"
        "Examples:\n"
        "  stratus fit voyager.csv --table saturn_rings_mixture.h5 --fix w2=0.1 -o rings.csv\n"
        "  stratus fit voyager.csv --single --phase lambert_sphere \\\n"
        "    --second-phase henyey_greenstein:g=0.5 --free g2\n"
        "  printf 'side,mu_out,brightness,sigma\\nbeam,0.5,0.3,0.01\\n' | stratus fit -");
    fit->callback([command] { run_fit(*command); });
}

}  // namespace stratus
