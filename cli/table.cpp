// Commands on whole tables: info, convert, pack, seal and verify.
//
// `stratus info`: prints what a table holds, how accurate it is and how it was made.
#include <stratus/bake/accuracy.h>
#include <stratus/base/constants.h>
#include <stratus/base/half.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/io/file_bytes.h>
#include <stratus/scene/render.h>

#include "options.h"
#include "progress.h"

#include <algorithm>
#include <iostream>
#include <sstream>

namespace stratus {
namespace {

struct InfoOptions {
    std::string table;
    std::string picture;
    ReadOptions reading;
};

constexpr std::size_t label_width = 22;
constexpr int digits = 6;  // of numbers

std::string megabytes(double bytes) { return formatted("%.2f MB", bytes / 1e6); }

/// A text may list a thousand numbers; the file has all of them.
std::string shortened(const std::string& text) {
    constexpr std::size_t max_length = 240;
    return text.size() <= max_length ? text : text.substr(0, max_length) + " ...";
}

/// `label` and a text of any number of lines.
void print(const std::string& label, const std::string& text) {
    std::string head = label;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line); head.clear()) {
        head.resize(std::max(label_width, head.size() + 1), ' ');
        std::cout << head << line << '\n';
    }
}

std::string described(const Axis& axis, const std::string& scale_name, double unit = 1,
                      const char* unit_name = "") {
    const std::vector<double>& values = axis.values;
    std::string text =
        std::to_string(values.size()) + (values.size() == 1 ? " sample" : " samples");
    text += " at " + short_number(values.front() / unit, digits);
    if (values.size() > 1) text += " to " + short_number(values.back() / unit, digits);
    if (axis.view().ends_at_infinity && values.size() > 2)
        text += " (finite to " + short_number(values[values.size() - 2] / unit, digits) + ")";
    text += unit_name;
    if (values.size() > 1) text += ", " + scale_name;
    return text;
}

std::string describe_sides(const TableView& table) {
    if (!table.has_reflection()) return "transmission";
    if (!table.has_transmission()) return "reflection";
    return "reflection, transmission";
}

std::string lower_boundary_text(const Table& table) {
    const std::string albedo = "albedo " + short_number(table.lower_boundary.albedo, digits);
    switch (table.lower_boundary.kind) {
        case LowerBoundary::Kind::surface: return "Lambert surface, " + albedo;
        case LowerBoundary::Kind::ground: return table.lower_boundary.law->text() + ", " + albedo;
        case LowerBoundary::Kind::layer:
            return "semi-infinite layer, " + albedo + ", " +
                   shortened(table.lower_boundary.phase_function.text());
        default: return "none";
    }
}

std::string describe_orders(const Table& table) {
    const std::string multiple =
        table.highest_order == 0 ? "2 and above"
        : table.highest_order == 2
            ? "2, where the series is truncated"
            : "2 to " + std::to_string(table.highest_order) + ", where the series is truncated";
    return multiple + " (lookups add order 1 in closed form)";
}

/// Bytes of samples, of `sample_size` each, and of fluxes.
double bytes_in_memory(const Table& table, std::size_t sample_size) {
    const std::size_t samples =
        table.reflection_multiple.size() + table.transmission_multiple.size();
    const std::size_t fluxes = table.plane_albedo.size() + table.diffuse_transmittance.size() +
                               table.spherical_albedo.size();
    return static_cast<double>(samples * sample_size + fluxes * sizeof(float));
}

void print_content(const Table& table, const TableView& view) {
    const auto title = table.attributes.find("title");
    if (title != table.attributes.end()) print("title", title->second);
    for (std::size_t k = 0; k < table.layers.size(); ++k) {
        const StackLayer& layer = table.layers[k];
        print("layer " + std::to_string(k + 1) + (k == 0 ? ", the top" : ""),
              "optical depth " + short_number(layer.optical_depth, digits) + ", albedo " +
                  short_number(layer.albedo, digits) + ", " +
                  shortened(layer.phase_function.text()));
    }
    if (table.is_stack()) print("the mean layer", "the table is of the stack, lit from above");
    print("phase function", shortened(table.phase_function.text()));
    print("asymmetry g", short_number(table.phase_function.asymmetry(), digits));
    for (const FamilyAxis& axis : table.family) {
        if (axis.parameter == PhaseParameter::mixture) {
            print("second phase function", shortened(table.second_phase_function.text()));
            print("asymmetry g", short_number(table.second_phase_function.asymmetry(), digits));
            print("mixture", described(axis.axis, mixture_scale_name) +
                                 ", the share of the first phase function");
        } else {
            const std::string unit = parameter_unit(axis.parameter);
            print(axis.name() + (unit == "1" ? std::string() : " (" + unit + ")"),
                  axis.is_discrete ? allowed_text(axis)
                                   : described(axis.axis, axis_scale_name(axis.axis.scale)) +
                                         ", a parameter of the phase function");
        }
    }
    print("lower boundary", lower_boundary_text(table));
    for (const auto& [name, axis] :
         {std::pair("albedo", &table.albedo), std::pair("optical depth", &table.optical_depth),
          std::pair("mu_in", &table.mu_in), std::pair("mu_out", &table.mu_out)})
        print(name, described(*axis, axis_scale_name(axis->scale)));
    print("azimuth",
          described(table.azimuth, axis_scale_name(table.azimuth.scale), pi / 180, " degrees"));
    print("sides", describe_sides(view));
    print("orders", describe_orders(table));
}

void print_size(const AnyTable& given, const std::string& path) {
    const Table& table = given.table();
    print("samples per side", std::to_string(table.sample_count()));
    if (given.packed() == nullptr)
        print("in memory", megabytes(bytes_in_memory(table, sizeof(float))) + " as float, " +
                               megabytes(bytes_in_memory(table, sizeof(Half))) + " as half");
    print("file", megabytes(static_cast<double>(fs::file_size(path))));
}

void print_accuracy(const Table& table) {
    print("tolerance", short_number(table.tolerance, digits));
    print("largest error",
          short_number(table.measured_error, digits) + ", relative, measured at the bake");
}

/// All attributes but the title: conventions, program version, recipes, how the table was made.
void print_attributes(const Table& table) {
    for (const auto& [name, text] : table.attributes) {
        if (name == "title" || text.empty()) continue;
        std::string label = name;
        std::ranges::replace(label, '_', ' ');
        if (text.find('\n') == std::string::npos) {
            print(label, shortened(text));
        } else {
            std::cout << '\n' << label << '\n';
            std::istringstream lines(text);
            for (std::string line; std::getline(lines, line);) std::cout << "    " << line << '\n';
        }
    }
}

void run_info(const InfoOptions& options) {
    if (!options.picture.empty())
        require_output("info", "--picture", options.picture, {options.table}, {".png"});
    const AnyTable given = read_intact_table(options.table, options.reading);
    const Table& table = given.table();
    if (!options.picture.empty())
        write_file(options.picture,
                   std::bind_front(draw_portrait, make_portrait(table, given.view())));
    print_content(table, given.view());
    print_size(given, options.table);
    print_accuracy(table);
    print("picture written", options.picture);
    print_attributes(table);
}

}  // namespace

void add_info(CLI::App& app) {
    const auto [command, options] = add_command<InfoOptions>(
        app, "info", "Show what a table holds and how it was made", run_info);
    add_table(command, options.table);
    add_file(command, "--picture", options.picture, "Portrait of the table to draw, .png");
    add_max_memory(command, options.reading);
    command.footer("Example:\n  stratus info saturn_rings.h5 --picture saturn_rings.png");
}

// `stratus convert`: all samples in the other file format, lossless both ways; those of a packed table as its
// lookups give them. `stratus pack`: a table in the small file that lookups map into memory. `stratus seal`: a table
// that was changed on purpose, with checksums of what it holds.

namespace {

struct ChangeOptions {
    std::string input, output;
    ReadOptions reading;
    bool quiet = false;
};

void run_convert(const ChangeOptions& options) {
    if (!is_packed(options.input)) require_table_ending("convert", "IN", options.input);
    require_table_ending("convert", "OUT", options.output);
    require_different_files("convert", {options.input}, {options.output});
    const Table table = read_samples(options.input, options.reading);
    const SignalsHeld held;
    write_table(table, options.output);
}

void run_pack(const ChangeOptions& options) {
    require_writable("pack", "--output", options.output, {packed_ending});
    require_different_files("pack", {options.input}, {options.output});
    if (is_packed(options.input)) require_table_ending("pack", "TABLE", options.input);
    const Table table = read_table(options.input, options.reading);
    const std::vector<char> packed = pack(table);
    write_content_held(options.output, {packed.data(), packed.size()});
    if (options.quiet) return;
    const double samples = 4.0 * static_cast<double>(table.reflection_multiple.size() +
                                                     table.transmission_multiple.size());
    const double size = static_cast<double>(packed.size());
    say(options.output + ": " + short_number(size / 1e6, 3) + " MB, " +
        short_number(100 * size / samples, 3) + " % of the table's samples");
}

void run_seal(const ChangeOptions& options) {
    const std::string output = options.output.empty() ? options.input : options.output;
    require_table_ending("seal", "TABLE", options.input);
    require_table_ending("seal", "--output", output);
    require_writable("seal", "--output", output);
    ReadOptions reading = options.reading;
    reading.ignore_checksums = true;
    const Table table = read_table(options.input, reading);
    const SignalsHeld held;
    write_table(table, output);
}

}  // namespace

void add_convert(CLI::App& app) {
    const auto [command, options] = add_command<ChangeOptions>(
        app, "convert", "Write a table's samples in another file format", run_convert);
    command
        .add_option("IN", options.input,
                    "Table to read, .h5 or .exr, losslessly, or .stratus, whose lookups are "
                    "evaluated at its samples")
        ->required();
    command.add_option("OUT", options.output, "Table to write, .h5 or .exr")->required();
    add_max_memory(command, options.reading);
    command.footer("Example:\n  stratus convert saturn_rings.h5 saturn_rings.exr");
}

void add_pack(CLI::App& app) {
    const auto [command, options] = add_command<ChangeOptions>(
        app, "pack", "Write the small file of a table that fast lookups map into memory", run_pack);
    command.add_option("TABLE", options.input, "Table to read, .h5 or .exr")->required();
    command.add_option("-o,--output", options.output, "File to write, .stratus")->required();
    command.add_flag("--quiet", options.quiet, "Do not report the size");
    add_max_memory(command, options.reading);
    command.footer(
        "eval, verify, info and render --table read it as they read a table; its accuracy is what\n"
        "`stratus verify` says. Keep the table: bind, edit and convert what is exact.\n\n"
        "Example:\n  stratus pack saturn_rings.h5 -o saturn_rings.stratus");
}

void add_seal(CLI::App& app) {
    const auto [command, options] = add_command<ChangeOptions>(
        app, "seal",
        "Write a table that was changed on purpose with checksums of what it holds now", run_seal);
    command.add_option("TABLE", options.input, "Table that was changed, .h5 or .exr")->required();
    add_file(command, "-o,--output", options.output,
             "File to write, .h5 or .exr. Default: TABLE itself");
    add_max_memory(command, options.reading);
    command.footer(
        "What it holds must be a valid table. Its measured error is still that of the bake; see\n"
        "`stratus verify`. Attributes of your own are kept as text if they are text or numbers,\n"
        "datasets of your own are not.\n\n"
        "Example:\n  stratus seal saturn_rings.h5");
}

// `stratus verify`: compares lookups at random points with fresh solutions.

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
    const auto within = std::ranges::count_if(
        samples, [&](double error) { return error <= tolerance; }, &ErrorSample::error);
    return 100.0 * static_cast<double>(within) /
           static_cast<double>(std::max<std::size_t>(1, samples.size()));
}

void print_worst(const Verification& verification, const FamilyAxes& family) {
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
    options.progress = [&](double done) { progress(done, "verifying"); };
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
            !verification.judges_forward
                ? "; neither is judged: the samples hold the peak of the ground"
            : !verification.judges_grazing ? "; the latter are not judged: the path law misses"
                                           : "");
    if (verification.meets(table.tolerance)) return;
    std::string missed = formatted(
        "99.9 %% of values must be within its tolerance %.2g and all within 5 times it, "
        "got %.3f %% and %.2f times",
        table.tolerance, share, worst / table.tolerance);
    if (peaked && verification.judges_grazing)
        missed += formatted(
            "; 99 %% within 10 degrees of forward and at cosines below 0.15, got %.2f %% "
            "and %.2f %%",
            forward, grazing);
    else if (peaked && verification.judges_forward)
        missed += formatted("; 99 %% within 10 degrees of forward, got %.2f %%", forward);
    if (verification.energy_defect > table.tolerance)
        missed += formatted("; stored fluxes must close to it at albedo 1, got %.2g",
                            verification.energy_defect);
    throw std::runtime_error("verify: " + command.table + ": " + missed);
}

}  // namespace

void add_verify(CLI::App& app) {
    const auto [command, options] = add_command<VerifyCommand>(
        app, "verify", "Check a table against the solver at random points", run_verify);
    add_table(command, options.table);
    add_whole_number(command, "--samples", options.options.samples, 1, 100000000, "Random points")
        ->capture_default_str();
    add_whole_number(command, "--seed", options.options.seed, 0,
                     std::numeric_limits<unsigned>::max(), "Seed of the random points")
        ->capture_default_str();
    add_threads(command, options.options.threads);
    command.add_flag("--bound", options.options.bound,
                     "Look up through bound slices, as renderers do, instead of five axes at once");
    command.add_flag("--quiet", options.quiet, "No progress");
    add_max_memory(command, options.reading);
    command.footer(
        "Exit code 1 when the table misses the tolerance that it states: 99.9 % of values within "
        "it, all within five times it, and the energy of the stored fluxes at albedo 1. Peaked "
        "phase functions are also judged at points drawn near "
        "forward and at grazing pairs of directions, 99 % of either within it; of a narrow peak "
        "(Henyey-Greenstein: g from 0.84 on) directions with a cosine below 0.15 are shown apart "
        "and not judged. Over an ocean or an RPV ground both kinds are shown, and judged only "
        "if the phase function is peaked.\nExample:\n"
        "  stratus verify saturn_rings.h5 --samples 2000");
}

}  // namespace stratus
