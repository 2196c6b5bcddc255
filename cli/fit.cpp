// `stratus fit`: albedos and optical depths of rings from their observed brightness.
#include <stratus/fit/fit.h>

#include <stratus/bake/parallel.h>
#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/number_text.h>

#include "allowed.h"
#include "commands.h"
#include "query.h"
#include "table_option.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {
namespace {

struct FitCommand {
    std::string observations, table, output;
    int threads = 0;
    ReadOptions reading;
};

/// The observations of one radius.
struct Bin {
    double radius = 0;
    std::vector<Observation> observations;
};

/// Bins in the order in which their radii appear; a single one without a column of radii.
std::vector<Bin> bins_of(const CsvTable& rows, const TableView& table) {
    const auto column = [&](const char* name) {
        return static_cast<std::size_t>(rows.column(name));
    };
    const std::size_t mu_in = column("mu_in"), mu_out = column("mu_out");
    const std::size_t azimuth = column("azimuth_deg");
    const std::size_t brightness = column("brightness"), sigma = column("sigma");
    std::vector<Bin> bins;
    for (std::size_t r = 0; r < rows.rows.size(); ++r) {
        const std::vector<double>& row = rows.rows[r];
        const Side side = row[mu_out] < 0 ? Side::transmission : Side::reflection;
        const bool transmitted = side == Side::transmission;
        if (!(transmitted ? table.has_transmission() : table.has_reflection()))
            throw std::invalid_argument(rows.name + ", line " + std::to_string(rows.lines[r]) +
                                        ": mu_out must be " +
                                        (transmitted ? "above 0, the table holds no transmission"
                                                     : "below 0, the table holds no reflection") +
                                        ", got " + shortest_text(row[mu_out]));
        const double radius = rows.has_column("radius") ? row[column("radius")] : 0;
        auto bin = std::ranges::find(bins, radius, &Bin::radius);
        if (bin == bins.end()) bin = bins.insert(bin, {radius, {}});
        bin->observations.push_back({{row[mu_in], std::abs(row[mu_out]), radians(row[azimuth])},
                                     side,
                                     row[brightness],
                                     row[sigma]});
    }
    if (bins.empty()) throw std::invalid_argument(rows.name + ": no observations");
    for (const Bin& bin : bins)
        if (bin.observations.size() < 3)
            throw std::invalid_argument(
                rows.name + ": rows of a radius must be at least three, got " +
                std::to_string(bin.observations.size()) +
                (rows.has_column("radius") ? " of " + shortest_text(bin.radius) : ""));
    return bins;
}

void write_fits(std::ostream& out, const std::vector<Bin>& bins, const std::vector<Fit>& fits,
                bool radii) {
    out << (radii ? "radius," : "")
        << "w1,w1_sigma,w2,w2_sigma,optical_depth,optical_depth_sigma,chi_square,"
           "degrees_of_freedom,remarks\n";
    for (std::size_t b = 0; b < fits.size(); ++b) {
        const Fit& fit = fits[b];
        if (radii) out << shortest_text(bins[b].radius) << ',';
        for (const Estimate& found : {fit.w1, fit.w2, fit.optical_depth})
            out << full_text(found.value) << ',' << full_text(found.sigma) << ',';
        out << full_text(fit.chi_square) << ',' << fit.degrees_of_freedom << ",\""
            << joined(fit.remarks, "; ") << "\"\n";
    }
}

void run_fit(const FitCommand& command) {
    if (!command.output.empty()) {
        require_different_files("fit", command.table, command.output);
        require_different_files("fit", command.observations, command.output);
    }
    const Table table = read_noted_table(command.table, command.reading);
    if (!table.has_mixture())
        throw std::invalid_argument("fit: --table must have a mixture axis, got " + command.table +
                                    " without one");
    const CsvTable rows =
        read_observations(command.observations,
                          {"mu_in", "mu_out", "azimuth_deg", "brightness", "sigma"}, {"radius"});
    const TableView view = table.view();
    const std::vector<Bin> bins = bins_of(rows, view);
    std::vector<Fit> fits(bins.size());
    parallel_for(static_cast<int>(bins.size()), command.threads, [&](int b) {
        const auto at = static_cast<std::size_t>(b);
        fits[at] = fit_layer(view, bins[at].observations);
    });
    write_answer(command.output, [&](std::ostream& out) {
        write_fits(out, bins, fits, rows.has_column("radius"));
    });
}

}  // namespace

void add_fit(CLI::App& app) {
    auto command = std::make_shared<FitCommand>();
    CLI::App* fit = app.add_subcommand(
        "fit", "Fit the albedos w1, w2 and the optical depth to observed brightnesses");
    fit->add_option("OBSERVATIONS", command->observations,
                    "CSV with columns mu_in, mu_out, azimuth_deg, brightness, sigma in any order "
                    "and, for a fit of each radius, radius; -: standard input")
        ->required()
        ->check(file_name());
    fit->add_option("--table", command->table, "Table with a mixture axis, .h5 or .exr")
        ->required();
    add_max_memory(*fit, command->reading);
    fit->add_option("-o,--output", command->output, "CSV to write. Default or -: standard output")
        ->check(file_name());
    add_threads(*fit, command->threads);
    fit->footer(
        "brightness is I/F = mu_in R where mu_out > 0, and mu_in T where mu_out < 0, the unlit "
        "side (R = pi I / (mu_in F0)); sigma is its standard deviation. w1 and w2 are the albedos "
        "of the table's two phase functions. Standard deviations come from the model linearised "
        "at the best fit. The column remarks names parameters that the geometries do not "
        "determine, those at the edge of the table, and other layers that fit as well.\n"
        "Example:\n  stratus fit voyager.csv --table saturn_rings_mixture.h5 -o rings.csv");
    fit->callback([command] { run_fit(*command); });
}

}  // namespace stratus
