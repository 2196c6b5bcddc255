// The CSV of `stratus cost`.
#include <stratus/bake/cost.h>
#include <stratus/base/number_text.h>

#include <cstddef>
#include <ostream>

namespace stratus {

namespace {

constexpr int digits = 6;  // of numbers

using Kind = CostPoint::Kind;

struct CostColumn {
    const char* name;
    const char* meaning;
    bool (*belongs)(Kind kind);
    std::string (*text)(const CostPoint& point);
};

bool to_all(Kind) { return true; }
bool to_solvers(Kind kind) { return kind != Kind::table && kind != Kind::packed; }
bool to_tables(Kind kind) { return !to_solvers(kind); }
template <Kind one>
bool to(Kind kind) {
    return kind == one;
}

const char* name_of(Kind kind) {
    constexpr const char* names[] = {"solver",   "orders", "reference",
                                     "droplets", "table",  "packed"};
    return names[static_cast<std::size_t>(kind)];
}

/// A number of things, empty where there are none.
std::string count_text(double count) { return count > 0 ? short_number(count, 15) : ""; }

template <PhaseParameter parameter>
std::string members_text(const CostPoint& p) {
    return count_text(p.members[static_cast<std::size_t>(parameter)]);
}

std::string scheme_text(const CostPoint& p) {
    if (p.kind == Kind::reference) return p.photons > 0 ? "photons" : "markov";
    return p.solver.scheme == Scheme::classic ? "classic" : "harmonic";
}

constexpr CostColumn columns[] = {
    {"kind", "solver, orders, reference, droplets, table or packed", to_all,
     [](const CostPoint& p) { return std::string(name_of(p.kind)); }},
    {"varied", "tolerance: it chose the point; else what the sweep changed", to_all,
     [](const CostPoint& p) { return p.varied; }},
    {"tolerance", "that chose the point; empty where none did", to_all,
     [](const CostPoint& p) { return p.tolerance > 0 ? short_number(p.tolerance, digits) : ""; }},
    {"scheme", "of the solver: harmonic or classic; of references: markov or photons", to_all,
     scheme_text},
    {"start", "of the classic scheme: diamond or single", to_all,
     [](const CostPoint& p) {
         if (p.solver.scheme != Scheme::classic) return std::string();
         return std::string(p.solver.start == ClassicStart::single ? "single" : "diamond");
     }},
    {"start_depth", "of the classic scheme, at most; 0: 1e-3 of the smallest cosine", to_all,
     [](const CostPoint& p) {
         return p.solver.scheme == Scheme::classic ? short_number(p.solver.start_depth, digits)
                                                   : "";
     }},
    {"nodes", "Gauss nodes of the solver", to_all,
     [](const CostPoint& p) { return count_text(p.solver.nodes); }},
    {"modes", "azimuthal modes of the solver; empty: until the rest is negligible", to_all,
     [](const CostPoint& p) { return count_text(p.solver.modes); }},
    {"orders", "n: the Neumann series stops at order n", to<Kind::orders>,
     [](const CostPoint& p) { return count_text(p.solver.orders); }},
    {"sublayers", "of a Markov chain", to<Kind::reference>,
     [](const CostPoint& p) { return count_text(p.sublayers); }},
    {"photons", "for each of two mu_in", to<Kind::reference>,
     [](const CostPoint& p) { return count_text(p.photons); }},
    {"size_parameter", "of droplets: 2 pi radius / wavelength", to<Kind::droplets>,
     [](const CostPoint& p) { return short_number(p.size_parameter, digits); }},
    {"mu_samples", "of mu_in and mu_out alike", to_tables,
     [](const CostPoint& p) { return std::to_string(p.discretisation.mu_samples); }},
    {"azimuth_samples", "over 0 to 180 degrees", to_tables,
     [](const CostPoint& p) { return std::to_string(p.discretisation.azimuth_samples); }},
    {"optical_depth_samples_per_octave", "samples in which the depth doubles", to_tables,
     [](const CostPoint& p) {
         return std::to_string(p.discretisation.optical_depth_samples_per_octave);
     }},
    {"albedo_samples", "over the recipe's range", to_tables,
     [](const CostPoint& p) { return std::to_string(p.discretisation.albedo_samples); }},
    {"mixture_samples", "members along that axis of a family", to_tables,
     members_text<PhaseParameter::mixture>},
    {"g_samples", "the same", to_tables, members_text<PhaseParameter::g>},
    {"radius_samples", "the same", to_tables, members_text<PhaseParameter::radius>},
    {"wavelength_samples", "the same", to_tables, members_text<PhaseParameter::wavelength>},
    {"variance_samples", "the same", to_tables, members_text<PhaseParameter::variance>},
    {"error_median", "relative error of half of the values", to_all,
     [](const CostPoint& p) { return short_number(p.error_median, digits); }},
    {"error_99_9", "relative error of 99.9 % of the values; the frontier's", to_all,
     [](const CostPoint& p) { return short_number(p.error_99_9, digits); }},
    {"error_largest", "largest relative error", to_all,
     [](const CostPoint& p) { return short_number(p.error_largest, digits); }},
    {"solve_seconds",
     "one layer, deepest and brightest, 14 cosines, one thread; references: 12 geometries",
     to_solvers, [](const CostPoint& p) { return short_number(p.solve_seconds, digits); }},
    {"bake_seconds",
     "all threads; where tolerance chose, with choosing and checking; packed: of packing",
     to_tables, [](const CostPoint& p) { return short_number(p.bake_seconds, digits); }},
    {"bytes", "of the samples of both sides in memory; packed: of the file", to_tables,
     [](const CostPoint& p) { return short_number(p.bytes, digits); }},
    {"lookup_ns", "nanoseconds of a lookup at a random point, one thread", to_tables,
     [](const CostPoint& p) { return short_number(p.lookup_ns, digits); }},
    {"on_frontier", "1: no other point undercuts it in error and in solve_seconds or bytes", to_all,
     [](const CostPoint& p) { return std::string(p.on_frontier ? "1" : "0"); }},
    {"times_frontier", "solve_seconds or bytes over those of the cheapest as accurate", to_all,
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
        for (const CostColumn& column : columns) {
            out << between;
            if (column.belongs(point.kind)) out << column.text(point);
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
