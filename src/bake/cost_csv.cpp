// The CSV of `stratus cost`.
#include <stratus/bake/cost.h>
#include <stratus/runtime/number_text.h>

#include <ostream>

namespace stratus {

namespace {

constexpr int digits = 6;  // of numbers

struct CostColumn {
    const char* name;
    const char* meaning;
    enum class Scope { both, solver, table } scope;
    std::string (*text)(const CostPoint& point);
};

using Scope = CostColumn::Scope;

constexpr CostColumn columns[] = {
    {"kind", "solver or table", Scope::both,
     [](const CostPoint& p) {
         return std::string(p.kind == CostPoint::Kind::solver ? "solver" : "table");
     }},
    {"varied", "tolerance: it chose the point; else what the sweep changed", Scope::both,
     [](const CostPoint& p) { return p.varied; }},
    {"tolerance", "that chose the point; empty where none did", Scope::both,
     [](const CostPoint& p) { return p.tolerance > 0 ? short_number(p.tolerance, digits) : ""; }},
    {"scheme", "of the solver: harmonic or classic", Scope::both,
     [](const CostPoint& p) {
         return std::string(p.solver.scheme == Scheme::classic ? "classic" : "harmonic");
     }},
    {"start", "of the classic scheme: diamond or single", Scope::both,
     [](const CostPoint& p) {
         if (p.solver.scheme != Scheme::classic) return std::string();
         return std::string(p.solver.start == ClassicStart::single ? "single" : "diamond");
     }},
    {"start_depth", "of the classic scheme, at most; 0: 1e-3 of the smallest cosine", Scope::both,
     [](const CostPoint& p) {
         return p.solver.scheme == Scheme::classic ? short_number(p.solver.start_depth, digits)
                                                   : "";
     }},
    {"nodes", "Gauss nodes of the solver", Scope::both,
     [](const CostPoint& p) { return std::to_string(p.solver.nodes); }},
    {"modes", "azimuthal modes of the solver", Scope::both,
     [](const CostPoint& p) { return std::to_string(p.solver.modes); }},
    {"mu_samples", "of mu_in and mu_out alike", Scope::table,
     [](const CostPoint& p) { return std::to_string(p.discretisation.mu_samples); }},
    {"azimuth_samples", "over 0 to 180 degrees", Scope::table,
     [](const CostPoint& p) { return std::to_string(p.discretisation.azimuth_samples); }},
    {"optical_depth_samples_per_octave", "samples in which the depth doubles", Scope::table,
     [](const CostPoint& p) {
         return std::to_string(p.discretisation.optical_depth_samples_per_octave);
     }},
    {"albedo_samples", "over the recipe's range", Scope::table,
     [](const CostPoint& p) { return std::to_string(p.discretisation.albedo_samples); }},
    {"error_median", "relative error of half of the values", Scope::both,
     [](const CostPoint& p) { return short_number(p.error_median, digits); }},
    {"error_99_9", "relative error of 99.9 % of the values; the frontier's", Scope::both,
     [](const CostPoint& p) { return short_number(p.error_99_9, digits); }},
    {"error_largest", "largest relative error", Scope::both,
     [](const CostPoint& p) { return short_number(p.error_largest, digits); }},
    {"solve_seconds", "one layer, deepest and brightest, 14 cosines, one thread", Scope::solver,
     [](const CostPoint& p) { return short_number(p.solve_seconds, digits); }},
    {"bake_seconds", "all threads; where tolerance chose, with choosing and checking", Scope::table,
     [](const CostPoint& p) { return short_number(p.bake_seconds, digits); }},
    {"bytes", "of the samples of both sides in memory", Scope::table,
     [](const CostPoint& p) { return short_number(p.bytes, digits); }},
    {"lookup_ns", "nanoseconds of a lookup at a random point, one thread", Scope::table,
     [](const CostPoint& p) { return short_number(p.lookup_ns, digits); }},
    {"on_frontier", "1: no other point undercuts it in error and in solve_seconds or bytes",
     Scope::both, [](const CostPoint& p) { return std::string(p.on_frontier ? "1" : "0"); }},
    {"times_frontier", "solve_seconds or bytes over those of the cheapest as accurate", Scope::both,
     [](const CostPoint& p) { return short_number(p.times_frontier, digits); }},
};

}  // namespace

void write_cost(std::ostream& out, const std::vector<CostPoint>& points) {
    const char* between = "";
    for (const CostColumn& column : columns) {
        out << between << column.name;
        between = ",";
    }
    out << '\n';
    for (const CostPoint& point : points) {
        between = "";
        const Scope own = point.kind == CostPoint::Kind::solver ? Scope::solver : Scope::table;
        for (const CostColumn& column : columns) {
            out << between;
            if (column.scope == Scope::both || column.scope == own) out << column.text(point);
            between = ",";
        }
        out << '\n';
    }
}

const std::vector<std::pair<const char*, const char*>>& cost_columns() {
    static const auto list = [] {
        std::vector<std::pair<const char*, const char*>> names;
        for (const CostColumn& column : columns) names.emplace_back(column.name, column.meaning);
        return names;
    }();
    return list;
}

}  // namespace stratus
