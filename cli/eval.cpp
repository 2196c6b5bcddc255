// `stratus eval`: looks up a baked table at the rows of a query, through the same runtime library a
// renderer links.
#include <stratus/runtime/constants.h>
#include <stratus/runtime/effects.h>
#include <stratus/runtime/lookup.h>
#include <stratus/runtime/number_text.h>
#include <stratus/runtime/table.h>

#include "allowed.h"
#include "commands.h"
#include "query.h"
#include "table_option.h"

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace stratus {
namespace {

struct EvalOptions {
    std::string table;
    std::string query;
    std::string output;
    std::vector<std::string> effects;
    double density = 0;
    std::string opposition;
    ReadOptions reading;
};

/// What is asked for, and whether what lies behind the layer is to be seen through it.
struct Asked : Effects {
    bool background = false;
};

constexpr const char* effect_names = "single, multiple, reflection, transmission, background";

/// Sides and orders are asked for apart: where none of a kind is named, all of that kind are meant.
Asked parse_effects(const std::vector<std::string>& names) {
    Asked named;
    named.single = named.multiple = named.reflection = named.transmission = false;
    for (const std::string& name : names) {
        if (name == "single") {
            named.single = true;
        } else if (name == "multiple") {
            named.multiple = true;
        } else if (name == "reflection") {
            named.reflection = true;
        } else if (name == "transmission") {
            named.transmission = true;
        } else if (name == "background") {
            named.background = true;
        } else {
            throw std::invalid_argument(std::string("eval: --effects must be out of ") +
                                        effect_names + ", got " + name);
        }
    }
    if (!named.single && !named.multiple) named.single = named.multiple = true;
    if (!named.reflection && !named.transmission) named.reflection = named.transmission = true;
    return named;
}

/// `blinn`, whose width is that of the density, or `hapke:width=H` and `,amplitude=A`.
Opposition parse_opposition(const std::string& text, double density) {
    if (text.empty()) return {};
    if (text == "blinn") {
        if (density == 0)
            throw std::invalid_argument(
                "eval: --opposition blinn must come with a --density above 0, got 0");
        return Opposition::blinn(density);
    }
    double width = 0, amplitude = 1;
    int read = 0;
    const bool hapke = std::sscanf(text.c_str(), "hapke:width=%lf%n,amplitude=%lf%n", &width, &read,
                                   &amplitude, &read) >= 1 &&
                       static_cast<std::size_t>(read) == text.size();
    if (!hapke)
        throw std::invalid_argument(
            "eval: --opposition must be blinn or hapke:width=H or hapke:width=H,amplitude=A, got " +
            text);
    return Opposition::hapke(amplitude, width);
}

/// Leaves out the sides that the table does not hold, and says so; refuses when nothing is left.
Asked available_effects(const Asked& asked, const TableView& table, const std::string& name) {
    Asked available = asked;
    available.reflection = asked.reflection && table.has_reflection();
    available.transmission = asked.transmission && table.has_transmission();
    const bool left_out =
        asked.reflection != available.reflection || asked.transmission != available.transmission;
    if (!left_out) return available;
    const char* const held = table.has_reflection() ? "reflection" : "transmission";
    const char* const missing = table.has_reflection() ? "transmission" : "reflection";
    if (!available.reflection && !available.transmission)
        throw std::invalid_argument("eval: --effects must ask for a side that " + name +
                                    " holds, which is " + held + ", got " + missing);
    std::cerr << "stratus: note: " << name << " holds no " << missing << ", left out\n";
    return available;
}

/// The columns of a query; those of an axis with one sample may be left out.
struct QueryColumns {
    std::vector<std::string> required{"mu_in", "mu_out", "azimuth_deg"};
    std::vector<std::string> optional;
};

QueryColumns query_columns(const Table& table) {
    QueryColumns columns;
    const auto place = [&](const Axis& axis, const char* name) {
        (axis.values.size() == 1 ? columns.optional : columns.required).push_back(name);
    };
    place(table.optical_depth, "optical_depth");
    place(table.albedo, "albedo");
    if (table.has_mixture()) place(table.mixture, "mixture");
    return columns;
}

/// One row of a query in the runtime's terms.
struct Point {
    double albedo, optical_depth, mixture;
    Geometry geometry;
};

std::vector<Point> points_of(const CsvTable& query, const Table& table, double density) {
    const auto column = [&](const char* name) {
        return static_cast<std::size_t>(query.column(name));
    };
    const std::size_t mu_in = column("mu_in"), mu_out = column("mu_out");
    const std::size_t azimuth = column("azimuth_deg");
    const auto value_or_only_sample = [&](const std::vector<double>& row, const char* name,
                                          const Axis& axis) {
        return query.has_column(name) ? row[column(name)] : axis.values.front();
    };
    std::vector<Point> points;
    points.reserve(query.rows.size());
    for (const std::vector<double>& row : query.rows)
        points.push_back(
            {value_or_only_sample(row, "albedo", table.albedo),
             effective_optical_depth(
                 value_or_only_sample(row, "optical_depth", table.optical_depth), density),
             table.has_mixture() ? row[column("mixture")] : 1,
             {row[mu_in], row[mu_out], row[azimuth] * pi / 180}});
    return points;
}

bool is_outside(const AxisView& axis, double value) {
    if (axis.count == 0) return value != infinity;
    if (axis.ends_at_infinity) return value < axis.lowest;
    return value < axis.lowest || value > axis.highest;
}

/// An empty layer is no exception: it scatters nothing, whatever the table holds, and on a surface
/// light scatters once.
bool is_depth_outside(const TableView& table, double optical_depth) {
    const bool known_when_empty =
        !table.has_lower_boundary() || table.lower_boundary->kind == LowerBoundary::Kind::surface;
    return !(optical_depth == 0 && known_when_empty) &&
           is_outside(table.optical_depth, optical_depth);
}

/// Says once how many rows lie outside the table, where the multiply scattered part comes from its
/// edge.
void warn_of_clamped(const std::vector<Point>& points, const TableView& table) {
    const auto count = [&](auto&& outside) { return std::ranges::count_if(points, outside); };
    struct AxisCount {
        const char* name;
        long rows;
    };
    const AxisCount counts[] = {
        {"mu_in", count([&](const Point& p) { return is_outside(table.mu_in, p.geometry.mu_in); })},
        {"mu_out",
         count([&](const Point& p) { return is_outside(table.mu_out, p.geometry.mu_out); })},
        {"optical_depth",
         count([&](const Point& p) { return is_depth_outside(table, p.optical_depth); })},
        {"albedo", count([&](const Point& p) { return is_outside(table.albedo, p.albedo); })},
        {"mixture", table.has_mixture() ? count([&](const Point& p) {
             return is_outside(table.mixture, p.mixture);
         })
                                        : 0},
    };
    std::string list;
    for (const AxisCount& axis : counts)
        if (axis.rows > 0)
            list += (list.empty() ? "" : ", ") + std::to_string(axis.rows) + " in " + axis.name;
    if (list.empty()) return;
    std::cerr << "stratus: warning: of " << points.size()
              << " rows some lie outside the table, their multiple scattering comes from its edge: "
              << list << '\n';
}

void write_header(std::ostream& out, const CsvTable& query, const Asked& effects) {
    std::vector<std::string> columns = query.columns;
    const auto both_sides = [&](bool asked, const std::string& ending) {
        if (asked && effects.reflection) columns.push_back("reflection" + ending);
        if (asked && effects.transmission) columns.push_back("transmission" + ending);
    };
    both_sides(true, "");
    both_sides(effects.single, "_single");
    both_sides(effects.multiple, "_multiple");
    if (effects.background) columns.push_back("background");
    for (std::size_t c = 0; c < columns.size(); ++c) out << (c ? "," : "") << columns[c];
    out << '\n';
}

/// What opposition adds to single scattering by the layer.
double brightened_by(const Opposition& opposition, const TableView& table, const Point& point) {
    const Geometry& at = point.geometry;
    const double c = cos_scattering_angle_reflected(at);
    const double factor =
        opposition_factor(opposition, c, point.optical_depth, at.mu_in, at.mu_out);
    return (factor - 1) * single_reflection(table.phase(c), point.albedo, point.optical_depth,
                                            at.mu_in, at.mu_out);
}

/// What a viewer at mu_out sees of a background.
double background_of(const TableView& table, const Point& point, const Asked& effects) {
    if (table.has_lower_boundary()) return 0;
    return transparency(effects.single ? table.phase(1) : 0, point.albedo, point.optical_depth,
                        point.geometry.mu_out);
}

void write_row(std::ostream& out, const std::vector<double>& query_row, const Point& point,
               const TableView& table, const Asked& effects) {
    Scattered reflected{}, transmitted{};
    if (effects.reflection) {
        reflected = reflection(table, point.albedo, point.optical_depth, point.geometry);
        reflected.single += brightened_by(effects.opposition, table, point);
    }
    if (effects.transmission)
        transmitted = transmission(table, point.albedo, point.optical_depth, point.geometry);

    for (std::size_t c = 0; c < query_row.size(); ++c)
        out << (c ? "," : "") << shortest_text(query_row[c]);
    const auto both_sides = [&](bool asked, auto&& part) {
        if (asked && effects.reflection) out << ',' << full_text(part(reflected));
        if (asked && effects.transmission) out << ',' << full_text(part(transmitted));
    };
    both_sides(true, [&](const Scattered& light) {
        return (effects.single ? light.single : 0) + (effects.multiple ? light.multiple : 0);
    });
    both_sides(effects.single, [](const Scattered& light) { return light.single; });
    both_sides(effects.multiple, [](const Scattered& light) { return light.multiple; });
    if (effects.background) out << ',' << full_text(background_of(table, point, effects));
    out << '\n';
}

/// The view without the samples that are not asked for: the lookup then does not touch them.
TableView without_unasked_samples(TableView table, const Asked& effects) {
    if (!effects.multiple) table.reflection_multiple = table.transmission_multiple = {};
    return table;
}

void run_eval(const EvalOptions& options) {
    Asked asked = parse_effects(options.effects);
    asked.density = options.density;
    asked.opposition = parse_opposition(options.opposition, options.density);
    check_effects(asked);
    if (!options.output.empty()) {
        require_different_files("eval", options.table, options.output);
        require_different_files("eval", options.query, options.output);
    }
    const Table table = read_noted_table(options.table, options.reading);
    const QueryColumns columns = query_columns(table);
    const CsvTable query = read_query(options.query, columns.required, columns.optional);
    const std::vector<Point> points = points_of(query, table, options.density);

    const Asked effects = available_effects(asked, table.view(), options.table);
    const TableView view = without_unasked_samples(table.view(), effects);
    if (effects.multiple) warn_of_clamped(points, view);

    write_answer(options.output, [&](std::ostream& out) {
        write_header(out, query, effects);
        for (std::size_t r = 0; r < points.size(); ++r)
            write_row(out, query.rows[r], points[r], view.at_mixture(points[r].mixture), effects);
    });
}

}  // namespace

void add_eval(CLI::App& app) {
    auto options = std::make_shared<EvalOptions>();
    CLI::App* command = app.add_subcommand("eval", "Look up a table at the rows of a query");
    command->add_option("TABLE", options->table, "Baked table, .h5 or .exr")->required();
    command
        ->add_option("--query", options->query,
                     "CSV with columns mu_in, mu_out, azimuth_deg, optical_depth, albedo in any "
                     "order; the last two may be left out where the table has one sample. Tables "
                     "that mix need mixture, too, the share of the first phase function. "
                     "Default or -: standard input")
        ->check(file_name());
    command
        ->add_option("-o,--output", options->output, "CSV to write. Default or -: standard output")
        ->check(file_name());
    command
        ->add_option("--effects", options->effects,
                     std::string("What to evaluate, out of ") + effect_names +
                         ", comma between. Default: all that the table holds")
        ->delimiter(',')
        ->allow_extra_args(false);  // or it would take TABLE too
    command
        ->add_option("--density", options->density,
                     "Share of the volume that particles fill, [0, 1): every order sees the depth "
                     "tau / (1 - density)")
        ->capture_default_str()
        ->check(number("in [0, 1)", [](double value) { return value >= 0 && value < 1; }));
    command->add_option(
        "--opposition", options->opposition,
        "How single scattering brightens towards the light: blinn, as wide as the density makes "
        "it, or hapke:width=0.05 or hapke:width=0.05,amplitude=0.8. Default: not at all");
    add_max_memory(*command, options->reading);
    command->footer(
        "The column background, asked for by that name, is the share of what lies behind the layer "
        "that is seen at mu_out: the beam, and what single scattering sends straight on.\n"
        "Example:\n"
        "  printf 'mu_in,mu_out,azimuth_deg,optical_depth,albedo\\n0.5,0.8,60,1.5,0.9\\n' \\\n"
        "    | stratus eval saturn_rings.h5 --effects reflection");
    command->callback([options] { run_eval(*options); });
}

}  // namespace stratus
