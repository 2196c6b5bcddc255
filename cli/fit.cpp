// `stratus fit`: albedos, optical depths and what scatters, of rings and clouds, from their observed
// brightness.
#include <stratus/fit/fit.h>

#include <stratus/bake/parallel.h>
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/picture/plots.h>

#include "options.h"
#include "progress.h"

#include <ostream>
#include <set>

namespace stratus {
namespace {

struct FitCommand {
    std::string observations, table, phase, second_phase, output, rows, svg;
    bool single = false;
    std::vector<std::string> fixed, free;
    std::string density = "0";
    std::string opposition;
    int threads = 0;
    ReadOptions reading;
};

/// Returns the light that a row observes.
Light observed_light(const RowDirection& direction) {
    if (!direction.side) return Light::beam;
    return *direction.side == Side::reflection ? Light::reflected : Light::transmitted;
}

/// Returns the word for it in the column side.
const char* light_word(Light light) {
    constexpr const char* names[] = {"lit", "unlit", "beam"};
    return names[static_cast<int>(light)];
}

bool all_are_beams(const Query& rows) {
    return std::ranges::all_of(rows.directions,
                               [](const RowDirection& direction) { return !direction.side; });
}

/// The observations of one radius of rings, or of one pixel.
struct Bin {
    double place = 0;
    Observations observations;
    std::vector<std::size_t> rows;  // of the file
};

/// The column each of whose values has a fit of its own; "" where there is none. Where a table varies
/// the radius of droplets, the column radius is of these.
std::string column_of_bins(const CsvTable& rows, const FamilyAxes& family) {
    const bool has_rings =
        rows.has_column("radius") && std::ranges::none_of(family, [](const FamilyAxis& axis) {
            return axis.parameter == PhaseParameter::radius;
        });
    if (!rows.has_column("pixel")) return has_rings ? "radius" : "";
    if (has_rings)
        throw std::invalid_argument(rows.name +
                                    ": column pixel must come without radius, got both");
    return "pixel";
}

/// Refuses columns of what the table's family does not vary.
void check_family_columns(const CsvTable& rows, const FamilyAxes& family) {
    for (const char* const name : {"g", "wavelength", "variance"})
        if (rows.has_column(name) && std::ranges::none_of(family, [&](const FamilyAxis& axis) {
                return axis.name() == std::string(name);
            }))
            throw std::invalid_argument(rows.name + ": column " + name +
                                        " must be left out unless the table's family varies it");
}

/// Parameters of the family that a row states; not-a-number for the others.
FamilyPoint known_point(const Row& row, const FamilyAxes& family) {
    std::vector<double> known;
    for (const FamilyAxis& axis : family) {
        known.push_back(row.has(axis.name()) ? row[axis.name()]
                                             : std::numeric_limits<double>::quiet_NaN());
        require(!row.has(axis.name()) || holds(axis, known.back()), row.place().c_str(),
                axis.name(), allowed_text(axis), known.back());
    }
    return FamilyPoint(known);
}

/// Bins in the order in which their places appear; a single one without a column of them.
std::vector<Bin> make_bins(const Query& query, const LayerModel& model) {
    const CsvTable& rows = query.table;
    const FamilyAxes family = model.family();
    check_family_columns(rows, family);
    const std::string place_column = column_of_bins(rows, family);
    std::vector<Bin> bins;
    for (std::size_t r = 0; r < rows.rows.size(); ++r) {
        const Row row = query.row(r);
        const Light light = observed_light(query.directions[r]);
        require(model.has(light), row.place().c_str(), "side", "one that the table holds",
                light_word(light));
        const double place = place_column.empty() ? 0 : row[place_column];
        auto bin = std::ranges::find(bins, place, &Bin::place);
        if (bin == bins.end()) bin = bins.insert(bin, {place, {}, {}});
        bin->observations.push_back({query.directions[r].geometry, light, row["brightness"],
                                     row["sigma"], known_point(row, family)});
        model.check_directions(row.place().c_str(), bin->observations.back());
        bin->rows.push_back(r);
    }
    if (bins.empty()) throw std::invalid_argument(rows.name + ": no observations");
    return bins;
}

void check_counts(const std::vector<Bin>& bins, const CsvTable& rows, const std::string& column,
                  std::size_t free) {
    for (const Bin& bin : bins)
        if (bin.observations.size() < free)
            throw std::invalid_argument(
                rows.name + ": rows" + (column.empty() ? "" : " of a " + column) +
                " must be at least " + std::to_string(free) +
                ", one for each free parameter, got " + std::to_string(bin.observations.size()) +
                (column.empty() ? "" : " of " + shortest_text(bin.place)));
}

/// Name of a parameter in `--fix` and `--free`.
std::string option_name(const LayerModel& model, int parameter) {
    if (parameter == fit_optical_depth) return "tau";
    return fit_parameter_names(model)[size(parameter)];
}

/// A parameter's value; of lengths um or nm may follow. Not-a-number where it is none.
double parse_value(const std::string& text, const std::string& name) {
    if (const auto parameter = parameter_named(name)) return parameter_value(text, *parameter);
    double value = 0;
    const std::size_t end = read_number(text, value);
    return end > 0 && end == text.size() ? value : std::numeric_limits<double>::quiet_NaN();
}

/// The parameter of that name.
int require_parameter(const std::string& option, const std::string& form, const LayerModel& model,
                      const std::string& name, const std::string& met) {
    std::vector<std::string> names;
    for (const int p : model_parameters(model)) {
        names.push_back(option_name(model, p));
        if (names.back() == name) return p;
    }
    require(false, "fit", option, form + " out of " + joined(names), met);
    return 0;
}

FitOptions make_options(const FitCommand& command, const LayerModel& model) {
    FitOptions options;
    options.density = parse_density("fit", command.density);
    options.opposition = parse_opposition("fit", command.opposition, options.density);
    for (const std::string& text : command.fixed) {
        const std::size_t equals = text.find('=');
        const std::string name = text.substr(0, equals);
        const int p = require_parameter("--fix", "NAME=VALUE with a name", model, name, text);
        const double value =
            parse_value(equals == std::string::npos ? "" : text.substr(equals + 1), name);
        require(!std::isnan(value), "fit", "--fix", "NAME=VALUE", text);
        std::optional<double>& held = options.*held_fields[size(p)];
        if (held)
            throw std::invalid_argument("fit: --fix must name " + option_name(model, p) +
                                        " once, got " + text);
        held = value;
    }
    for (const std::string& name : command.free) {
        const int p = require_parameter("--free", "a name", model, name, name);
        if (options.*held_fields[size(p)])
            throw std::invalid_argument("fit: --free must not name what --fix holds, got " + name);
        if (p == fit_g1) options.free_g1 = true;
        if (p == fit_g2) options.free_g2 = true;
    }
    return options;
}

/// The model that predicts the brightness, with the table that it may look up.
struct Prediction {
    std::optional<AnyTable> table;
    std::unique_ptr<LayerModel> model;
};

Prediction make_prediction(const FitCommand& command, bool beams_alone) {
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
        prediction.table = read_intact_table(command.table, command.reading);
        prediction.model = table_model(prediction.table->view());
    } else if (has_phase) {
        std::vector<std::string> notes;
        const PhaseFunction first = read_phase_function(command.phase, "", &notes);
        std::optional<PhaseFunction> second;
        if (!command.second_phase.empty())
            second = read_phase_function(command.second_phase, "", &notes);
        for (const std::string& note : notes) say("note: " + note);
        prediction.model =
            command.single ? single_scattering_model(first, second) : solver_model(first, second);
    } else if (beams_alone) {
        prediction.model = beam_model();
    } else {
        require(false, "fit", "--table or --phase", "given unless all rows are beams", "neither");
    }
    return prediction;
}

/// The columns of the answer.
struct Columns {
    std::vector<std::size_t> parameters;
    std::vector<std::string> names;  // of them
    std::string place;               // of the bins; "": none
};

/// Albedos and the depth, and what else is free.
Columns fit_columns(const LayerModel& model, const std::array<bool, fit_parameters>& free,
                    const std::string& place) {
    Columns columns;
    columns.place = place;
    for (const int p : model_parameters(model)) {
        if (p >= fit_g1 && !free[size(p)]) continue;
        columns.parameters.push_back(size(p));
        columns.names.push_back(fit_parameter_names(model)[size(p)]);
    }
    return columns;
}

/// Calls visit(a, b) with every two of some values.
template <class Values, class Visit>
void visit_pairs(const Values& values, const Visit& visit) {
    for (std::size_t a = 0; a < values.size(); ++a)
        for (std::size_t b = a + 1; b < values.size(); ++b) visit(values[a], values[b]);
}

void write_header(std::ostream& out, const Columns& columns) {
    if (!columns.place.empty()) out << columns.place << ',';
    for (const std::string& name : columns.names) out << name << ',' << name << "_sigma,";
    for (const char* const name : {"covariance_", "correlation_"})
        visit_pairs(columns.names, [&](const std::string& a, const std::string& b) {
            out << name << a << '_' << b << ',';
        });
    out << "chi_square,degrees_of_freedom,probability,remarks\n";
}

void write_fit(std::ostream& out, const Columns& columns, const Bin& bin, const Fit& fit) {
    if (!columns.place.empty()) out << shortest_text(bin.place) << ',';
    for (const std::size_t p : columns.parameters)
        out << full_text(fit.estimate[p].value) << ',' << full_text(fit.estimate[p].sigma) << ',';
    visit_pairs(columns.parameters, [&](std::size_t p, std::size_t q) {
        out << full_text(fit.covariance[p][q]) << ',';
    });
    visit_pairs(columns.parameters, [&](std::size_t p, std::size_t q) {
        out << full_text(fit.correlation(p, q)) << ',';
    });
    out << full_text(fit.chi_square) << ',' << fit.degrees_of_freedom << ','
        << full_text(fit.probability) << ",\"" << joined(fit.remarks, "; ") << "\"\n";
}

/// The model's value of each row of the file.
std::vector<double> model_values(const std::vector<Bin>& bins, const std::vector<Fit>& fits,
                                 std::size_t rows) {
    std::vector<double> values(rows);
    for (std::size_t b = 0; b < bins.size(); ++b)
        for (std::size_t i = 0; i < bins[b].rows.size(); ++i)
            values[bins[b].rows[i]] = fits[b].brightness[i];
    return values;
}

/// Beams come from behind: their phase angle is 180 degrees.
double phase_angle_deg(const RowDirection& at) {
    if (!at.side) return 180;
    return 180 - degrees(std::acos(cos_scattering_angle(*at.side, at.geometry)));
}

/// The angle is beyond 90 degrees on the unlit side.
double emission_angle_deg(const RowDirection& at) {
    const double angle = degrees(std::acos(at.geometry.mu_out));
    return at.side == Side::transmission ? 180 - angle : angle;
}

std::size_t count_distinct(const std::vector<double>& angles_deg) {
    constexpr double per_degree = 100;
    std::set<double> rounded;
    for (const double angle : angles_deg) rounded.insert(std::round(angle * per_degree));
    return rounded.size();
}

/// Returns the title of a figure's axis, and where its rows are along it: over the wavelength if that is a
/// column, else over the phase angle, or over the emission angle if that takes more values.
std::pair<std::string, std::vector<double>> plot_places(const Query& query) {
    std::vector<double> wavelengths, phases, emissions;
    if (query.table.has_column("wavelength")) {
        for (std::size_t r = 0; r < query.directions.size(); ++r)
            wavelengths.push_back(query.row(r)["wavelength"]);
        return {"wavelength (um)", wavelengths};
    }
    for (const RowDirection& direction : query.directions) {
        phases.push_back(phase_angle_deg(direction));
        emissions.push_back(emission_angle_deg(direction));
    }
    if (count_distinct(emissions) > count_distinct(phases))
        return {"emission angle (degrees)", emissions};
    return {"phase angle (degrees)", phases};
}

/// Writes the rows with columns model and residual; `model` has a value for each row.
void write_rows(std::ostream& out, const Query& query, const std::vector<double>& model) {
    const std::vector<std::string> columns{"model", "residual"};
    write_answer_header(out, query, columns);
    for (std::size_t r = 0; r < model.size(); ++r)
        write_answer_row(out, query, r, columns, {model[r], query.row(r)["brightness"] - model[r]});
}

/// Returns a figure of the rows.
ResidualPlot plot_of_rows(const Query& query, const std::vector<double>& model) {
    ResidualPlot plot;
    plot.title = "Fit of " + fs::path(query.table.name).filename().string();
    const auto [x_title, places] = plot_places(query);
    plot.x_title = x_title;
    plot.y_title = all_are_beams(query) ? "I/F0" : "I/F";
    for (const Light light : {Light::reflected, Light::transmitted, Light::beam}) {
        ResidualSeries series{light_word(light), {}};
        for (std::size_t r = 0; r < model.size(); ++r)
            if (observed_light(query.directions[r]) == light)
                series.points.push_back(
                    {places[r], query.row(r)["brightness"], query.row(r)["sigma"], model[r]});
        if (!series.points.empty()) plot.series.push_back(std::move(series));
    }
    return plot;
}

/// Refuses files to write, before any work.
void check_files(const FitCommand& command) {
    require_different_files("fit", {command.table, command.observations},
                            {command.output, command.rows, command.svg});
    if (!command.svg.empty()) require_writable("fit", "--svg", command.svg, {".svg"});
    if (!command.rows.empty()) require_writable("fit", "--rows", command.rows);
}

void run_fit(const FitCommand& command) {
    check_files(command);
    const Query query = read_observations(command.observations, {"brightness", "sigma"},
                                          {"radius", "pixel", "g", "wavelength", "variance"});
    const CsvTable& rows = query.table;
    const Prediction prediction =
        make_prediction(command, !rows.rows.empty() && all_are_beams(query));
    const LayerModel& model = *prediction.model;
    const FitOptions options = make_options(command, model);
    const std::vector<Bin> bins = make_bins(query, model);
    const Observations& first = bins.front().observations;
    const std::string place_column = column_of_bins(rows, model.family());
    check_counts(bins, rows, place_column, free_parameter_count(model, first, options));
    std::vector<Fit> fits(bins.size());
    parallel_for(int_size(bins), command.threads, [&](int b) {
        const auto at = size(b);
        fits[at] = fit_layer(model, bins[at].observations, options);
    });
    const Columns columns =
        fit_columns(model, free_parameters(model, first, options), place_column);
    write_answer(command.output, [&](std::ostream& out) {
        write_header(out, columns);
        for (std::size_t b = 0; b < fits.size(); ++b) write_fit(out, columns, bins[b], fits[b]);
    });
    const std::vector<double> by_model = model_values(bins, fits, rows.rows.size());
    if (!command.rows.empty())
        write_answer(command.rows, [&](std::ostream& out) { write_rows(out, query, by_model); });
    if (!command.svg.empty())
        write_file(command.svg, std::bind_front(draw_residual_plot, plot_of_rows(query, by_model)));
}

void add_model_options(CLI::App& fit, FitCommand& command) {
    add_file(fit, "--table", command.table,
             "Baked table that predicts all orders, .h5, .exr or .stratus");
    add_max_memory(fit, command.reading);
    add_text(fit, "--phase", command.phase, "a phase function",
             "Without a table: the phase function. All orders are solved at the rows' own "
             "geometries, some seconds a radius");
    add_text(fit, "--second-phase", command.second_phase, "a phase function",
             "Phase function of the second kind of particles, whose albedo is w2");
    fit.add_flag("--single", command.single,
                 "Light scattered once alone, in closed form: the paper's own inversion");
    fit.add_option("--fix", command.fixed,
                   "Hold parameters, NAME=VALUE, comma between: w1, w2 (w of one kind of "
                   "particles), tau, the optical depth, g1, g2 (g), and radius, wavelength and "
                   "variance of a table's family")
        ->delimiter(',')
        ->allow_extra_args(false);
    fit.add_option("--free", command.free,
                   "Fit g1 or g2 (g), too, asymmetries of --phase and --second-phase where they "
                   "are Henyey-Greenstein. Albedos, tau and what a table's family varies are free "
                   "unless fixed")
        ->delimiter(',')
        ->allow_extra_args(false);
    add_density_and_opposition(fit, command.density, command.opposition);
}

}  // namespace

void add_fit(CLI::App& app) {
    const auto [command, options] = add_command<FitCommand>(
        app, "fit",
        "Fit albedos, the optical depth, and asymmetries or droplets to observed brightnesses",
        run_fit);
    add_file(command, "OBSERVATIONS", options.observations,
             "CSV with columns " + direction_columns_help +
                 ", and brightness, sigma, in any order; "
                 "side (lit, unlit or beam); for a fit of each, radius (of rings) or pixel; "
                 "and wavelength or others that a table's family varies, where they are known "
                 "row by row; -: standard input")
        ->required();
    add_model_options(command, options);
    add_csv_output(command, options.output);
    add_file(command, "--rows", options.rows,
             "CSV to write: the rows of OBSERVATIONS with columns model, what the fit makes of "
             "brightness, and residual, brightness less it");
    add_file(command, "--svg", options.svg,
             "Figure to draw, .svg: observed, model and residuals over the wavelength where that "
             "is a column, else over the phase or the emission angle, whichever takes more values");
    add_threads(command, options.threads);
    command.footer(
        "brightness is I/F = mu_in R on the side lit, mu_in T on the side unlit (R = pi I / (mu_in "
        "F0)); sigma is its standard deviation. Without the column side, rows with mu_out < 0 are "
        "of the unlit side, and so are those with emission_deg beyond 90; phase_deg is 180 degrees "
        "less "
        "the scattering angle. Rows of the side beam are occultations: brightness is I/F0 = "
        "exp(-tau / mu_out), where mu_in and azimuth_deg do not count; a file of these alone needs "
        "neither table nor phase function, and gives tau.\n"
        "w1 and w2 are the albedos of the two kinds of particles, w that of one. Standard "
        "deviations and covariances come from the model linearised at the best fit, and are 0 for "
        "what was fixed, correlations likewise. probability is that of so large a chi-square or a "
        "larger one, without degrees of freedom for one of each parameter at the edge of its "
        "range; "
        "below 0.001 the column remarks says that the model is refused. It also names parameters "
        "that "
        "the geometries do not determine, those at the edge of their range, and other layers that "
        "fit as well. Without a table tau is sought from 1e-4 to 64, g from -0.9 to 0.9 (-0.95 to "
        "0.95 with --single).\n"
        "Of a table of a family the parameters that it varies are sought within its range: g, or "
        "radius, wavelength and variance of droplets, lengths in um. One of just some values must "
        "be fixed, or be a column: rows of several wavelengths then share one radius, one tau and "
        "one w. With a table that varies the radius of droplets a column radius is of these, and "
        "pixel tells fits apart.\n"
        "Examples:\n"
        "  stratus fit voyager.csv --table saturn_rings_mixture.h5 --fix w2=0.1 -o rings.csv \\\n"
        "    --rows residuals.csv --svg rings.svg\n"
        "  stratus fit voyager.csv --single --phase lambert_sphere \\\n"
        "    --second-phase henyey_greenstein:g=0.5 --free g2\n"
        "  stratus fit cloud.csv --table stratus_clouds.h5 --fix w=1\n"
        "  printf 'side,mu_out,brightness,sigma\\nbeam,0.5,0.3,0.01\\n' | stratus fit -");
}

}  // namespace stratus
