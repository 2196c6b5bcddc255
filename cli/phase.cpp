// `stratus phase`: phase functions as numbers and as a figure.
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/base/number_text.h>
#include <stratus/picture/plots.h>

#include "options.h"
#include "progress.h"

#include <iostream>
#include <ostream>

namespace stratus {
namespace {

struct PhaseCommand {
    std::vector<std::string> texts;
    std::string output, svg;
    double step_deg = 1;
    int moments = 0;
    bool quiet = false;
};

using PhaseFunctions = std::vector<PhaseFunction>;

/// The names of a quantity's columns: numbered where there are several.
std::string columns(const char* name, std::size_t count) {
    std::string header;
    for (std::size_t i = 1; i <= count; ++i)
        header += std::string(",") + name + (count > 1 ? "_" + std::to_string(i) : "");
    return header;
}

void write_moments(std::ostream& out, const PhaseFunctions& functions, int count) {
    std::vector<std::vector<double>> chi;
    for (const PhaseFunction& phi : functions) chi.push_back(phi.moments(count));
    out << 'l' << columns("chi", functions.size()) << '\n';
    for (std::size_t l = 0; l < size(count); ++l) {
        out << l;
        for (const std::vector<double>& moments : chi) out << ',' << full_text(moments[l]);
        out << '\n';
    }
}

void write_values(std::ostream& out, const PhaseFunctions& functions, double step_deg) {
    out << "scattering_angle_deg" << columns("value", functions.size()) << '\n';
    const int steps = static_cast<int>(std::ceil(180 / step_deg - 1e-9));
    for (int i = 0; i <= steps; ++i) {
        const double angle_deg = std::min(i * step_deg, 180.0);
        out << shortest_text(angle_deg);
        for (const PhaseFunction& phi : functions)
            out << ',' << full_text(phi(std::cos(radians(angle_deg))));
        out << '\n';
    }
}

/// g, and of droplets what Mie scattering tells besides.
std::string summary(const PhaseFunction& phi) {
    std::string line = "g " + short_number(phi.asymmetry(), 6);
    if (const auto albedo = phi.albedo()) line += ", albedo " + short_number(*albedo, 9);
    const auto& terms = phi.terms();
    if (const Mie* const droplets = std::get_if<Mie>(&terms[0].second);
        droplets != nullptr && terms.size() == 1) {
        const EffectiveSize size = effective_size(droplets->droplets);
        line += ", extinction efficiency " + short_number(droplets->extinction_efficiency(), 6) +
                ", effective radius " + short_number(size.radius, 6) + " um";
        if (!droplets->droplets.has_effective_parameters())
            line += ", effective variance " + short_number(size.variance, 6);
    }
    return line;
}

/// Over the scattering angle, y in whole decades that hold all values above 1e-6 of the largest.
LinePlot make_plot(const PhaseFunctions& functions) {
    LinePlot plot;
    plot.title = functions.size() == 1 ? "Phase function" : "Phase functions";
    plot.x_title = "scattering angle (degrees)";
    plot.y_title = "phase function, mean 1";
    plot.x_end = 180;
    plot.legend_below = true;
    double smallest = 1, largest = 1;
    constexpr int samples = 3600;
    for (const PhaseFunction& phi : functions) {
        Line line{phi.caption() + ", g = " + short_number(phi.asymmetry(), 3),
                  plot.lines.size() % 2 == 1,
                  {}};
        for (int i = 0; i <= samples; ++i) {
            const double angle_deg = 180.0 * i / samples;
            const double value = std::max(0.0, phi(std::cos(radians(angle_deg))));
            line.points.emplace_back(angle_deg, value);
            if (value > 0) smallest = std::min(smallest, value);
            largest = std::max(largest, value);
        }
        plot.lines.push_back(std::move(line));
    }
    smallest = std::max(smallest, 1e-6 * largest);
    plot.y_begin = std::pow(10, std::floor(std::log10(smallest)));
    plot.y_end = std::pow(10, std::max(1.0, std::ceil(std::log10(largest))));
    return plot;
}

void run_phase(const PhaseCommand& command) {
    require_writable_answer("phase", command.output);
    if (!command.svg.empty()) require_writable("phase", "--svg", command.svg, {".svg"});
    require_different_files("phase", {}, {command.output, command.svg});
    std::vector<std::string> notes;
    PhaseFunctions functions;
    for (const std::string& text : command.texts)
        functions.push_back(read_phase_function(text, "", &notes));
    if (!command.quiet) {
        for (const std::string& note : notes) say("note: " + note);
        for (std::size_t i = 0; i < functions.size(); ++i)
            std::cerr << shown(command.texts[i]) << ": " << summary(functions[i]) << '\n';
    }
    write_answer(command.output, [&](std::ostream& out) {
        if (command.moments > 0)
            write_moments(out, functions, command.moments);
        else
            write_values(out, functions, command.step_deg);
    });
    if (!command.svg.empty())
        write_file(command.svg, std::bind_front(draw_line_plot, make_plot(functions)));
}

}  // namespace

void add_phase(CLI::App& app) {
    const auto [command, options] = add_command<PhaseCommand>(
        app, "phase", "Show phase functions: values, moments, asymmetry; albedo of droplets",
        run_phase);
    command
        .add_option("PHASE", options.texts,
                    "Phase functions, one or several, each one of\n" + phase_function_help())
        ->required();
    add_whole_number(command, "--moments", options.moments, 1, 20'000,
                     "Write so many Legendre moments, [1, 20000], in place of values");
    command
        .add_option("--step", options.step_deg, "Between scattering angles, degrees, [0.001, 90]")
        ->capture_default_str()
        ->check(number_in("[0.001, 90]"))
        ->excludes("--moments");
    add_csv_output(command, options.output);
    add_file(command, "--svg", options.svg, "Figure to draw, .svg: all over the scattering angle");
    command.add_flag("--quiet", options.quiet, "No summary, no notes");
    command.footer(
        "Columns of the CSV: scattering_angle_deg and value, of mean 1 over the sphere, or l and "
        "chi;\nvalue_1, value_2, ... where there are several. The summary, on standard error, has "
        "the\nasymmetry g, and of droplets the single-scattering albedo and extinction "
        "efficiency.\n"
        "Examples:\n"
        "  stratus phase mie:radius=10um,variance=0.1 henyey_greenstein:g=0.864 --svg cloud.svg\n"
        "  stratus phase mie:radius=10um,variance=0.1 --moments 768 -o cloud_moments.csv\n"
        "  stratus phase mie:distribution=modified_gamma,mode_radius=4um,alpha=6,gamma=1\n"
        "  stratus phase mie:distribution=drops.csv,wavelength=1.94um,index=acid.csv");
}

}  // namespace stratus
