#include "methods.h"

#include <stratus/base/number_text.h>
#include <stratus/transfer/solve_to_tolerance.h>

#include "query.h"

#include <algorithm>
#include <ostream>

namespace stratus {
namespace {

std::vector<Geometry> make_geometries(const Query& query) {
    std::vector<Geometry> geometries;
    for (const RowDirection& direction : query.directions) geometries.push_back(direction.geometry);
    return geometries;
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

}  // namespace

std::string answer_fluxes_inside(const LevelsCommand& command) {
    const auto& [layers, boundary] = command.stack;
    const SolvedInside solved =
        solve_fluxes_inside(layers, boundary, command.levels, command.mu_in, command.options);
    write_answer(command.output, [&](std::ostream& out) {
        out << "level,mu_in,direct_flux,diffuse_flux,upward_flux,actinic_flux,heating_rate,error\n";
        for (const FluxesAtLevel& at : solved.levels)
            for (std::size_t i = 0; i < command.mu_in.size(); ++i) {
                out << shortest_text(at.optical_depth) << ',' << shortest_text(command.mu_in[i]);
                for (const double value : {at.direct[i], at.diffuse[i], at.upward[i], at.actinic[i],
                                           at.heating_rate[i], solved.error})
                    out << ',' << full_text(value);
                out << '\n';
            }
    });
    const double tolerance = command.options.tolerance;
    return tolerance > 0 && solved.relative_error > tolerance ? "see error" : "";
}

std::string answer_query_inside(const LevelsCommand& command) {
    const Stack& stack = command.stack;
    const std::vector<std::string> columns{
        "level",           "upward",          "downward",          "upward_single",
        "downward_single", "upward_multiple", "downward_multiple", "upward_error",
        "downward_error"};
    require_different_files("solve", command.query, command.output);
    const Query query = read_query(command.query, {});
    const std::vector<Geometry> geometries = make_geometries(query);
    double worst = 0;
    write_answer(command.output, [&](std::ostream& out) {
        write_answer_header(out, query, columns);
        for (const double level : command.levels) {
            const SolvedGeometries solved = solve_geometries_inside(
                stack.layers, stack.lower_boundary, level, geometries, command.options);
            worst = std::max(worst, worst_error(solved, query));
            for (std::size_t r = 0; r < geometries.size(); ++r) {
                const auto& [up, down, up_error, down_error] = solved.at[r];
                write_answer_row(out, query, r, columns,
                                 {level, up.total, down.total, up.single, down.single, up.multiple,
                                  down.multiple, up_error, down_error});
            }
        }
    });
    const double tolerance = command.options.tolerance;
    if (tolerance == 0 || worst <= tolerance) return "";
    return "the largest relative error is some " + short_number(worst);
}

}  // namespace stratus
