// `stratus eval`: looks up a baked table at the rows of a query, through what renderers call.
//
// Rows between the table's samples and without density or opposition are looked up directly
// (lookup.h), in double precision, or in a packed table as it is mapped. All others, and backgrounds, go through slices (slice.h), one
// for all rows of a layer: effects, the laws beyond the table and refusals are theirs.
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/bsdf/slice.h>

#include "options.h"
#include "progress.h"

#include <cmath>
#include <ostream>

namespace stratus {
namespace {

struct EvalOptions {
    std::string table;
    std::string query;
    std::string output;
    std::vector<std::string> effects;
    std::string density = "0";
    std::string opposition;
    bool clamp = false;
    ReadOptions reading;
};

constexpr const char* effect_names = "single, multiple, reflection, transmission, background";

/// Sides and orders are separate: where none of a kind is named, all of that kind are meant.
Effects parse_effects(const std::vector<std::string>& names) {
    const std::map<std::string, bool Effects::*> known{{"single", &Effects::single},
                                                       {"multiple", &Effects::multiple},
                                                       {"reflection", &Effects::reflection},
                                                       {"transmission", &Effects::transmission},
                                                       {"background", &Effects::background}};
    Effects named;
    for (const auto& [name, effect] : known) named.*effect = false;
    for (const std::string& name : names) {
        const auto effect = known.find(name);
        require(effect != known.end(), "eval", "--effects", "out of " + std::string(effect_names),
                name);
        named.*effect->second = true;
    }
    if (!named.single && !named.multiple) named.single = named.multiple = true;
    if (!named.reflection && !named.transmission) named.reflection = named.transmission = true;
    return named;
}

/// Leaves out the sides that the table does not hold, and says so; refuses when nothing is left.
Effects available_effects(const Effects& asked, const TableView& table, const std::string& name) {
    if (asked.background && table.has_lower_boundary())
        throw std::invalid_argument("eval: --effects must be without background for " + name +
                                    ", whose lower boundary hides it, got background");
    if (asked.background && asked.multiple && !table.diffuse_transmittance &&
        table.optical_depth.count > 0)
        say("note: " + name + " holds no diffuse_transmittance, background is seen by the beam" +
            (asked.single ? " and single scattering alone" : " alone"));
    Effects available = asked;
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
    say("note: " + name + " holds no " + missing + ", left out");
    return available;
}

/// The columns of a query beside its directions; those of an axis with one sample may be left out.
struct QueryColumns {
    std::vector<std::string> required, optional;
};

QueryColumns query_columns(const Table& table) {
    QueryColumns columns;
    const auto place = [&](const Axis& axis, const char* name) {
        (axis.values.size() == 1 ? columns.optional : columns.required).push_back(name);
    };
    place(table.optical_depth, "optical_depth");
    place(table.albedo, "albedo");
    for (const FamilyAxis& axis : table.family) columns.required.push_back(axis.name());
    return columns;
}

/// A layer, before the effect of density.
struct LayerKey {
    double albedo, optical_depth;
    std::vector<double> member;  // of a family

    auto operator<=>(const LayerKey&) const = default;
};

/// The layer of each row of a query.
std::vector<LayerKey> make_layers(const Query& query, const Table& table) {
    std::vector<LayerKey> layers;
    for (std::size_t r = 0; r < query.directions.size(); ++r) {
        const Row row = query.row(r);
        const auto value_or_only_sample = [&](const char* name, const Axis& axis) {
            return row.has(name) ? row[name] : axis.values.front();
        };
        std::vector<double> member;
        for (const FamilyAxis& axis : table.family) member.push_back(row[axis.name()]);
        layers.push_back({value_or_only_sample("albedo", table.albedo),
                          value_or_only_sample("optical_depth", table.optical_depth),
                          std::move(member)});
    }
    return layers;
}

bool is_outside(const AxisView& axis, double value) {
    if (axis.count == 0) return value != infinity;
    if (axis.ends_at_infinity) return value < axis.lowest;
    return value < axis.lowest || value > axis.highest;
}

/// Tells whether an azimuth is outside an axis, to the rounding of degrees; nothing depends on azimuth where 0 alone is sampled.
bool is_azimuth_outside(const AxisView& axis, double radians) {
    constexpr double rounding = 1e-9;
    if (axis.count == 1 && axis.lowest == 0) return false;
    const double value = std::abs(std::remainder(radians, 2 * pi));
    return value < axis.lowest - rounding || value > axis.highest + rounding;
}

bool is_member_outside(const TableView& table, const LayerKey& layer) {
    for (std::size_t k = 0; k < layer.member.size(); ++k)
        if (!holds((*table.family)[k], layer.member[k])) return true;
    return false;
}

/// True where a layer lies between the table's samples, or is thinner: lookups extrapolate these.
bool is_looked_up(const TableView& table, const LayerKey& layer) {
    const bool is_thin =
        layer.optical_depth < table.optical_depth.lowest && table.knows_thinner_layers();
    return (is_thin || !is_outside(table.optical_depth, layer.optical_depth)) &&
           !is_outside(table.albedo, layer.albedo) && !is_member_outside(table, layer);
}

/// R and T at a row by origin, and the share of a background.
struct Answer {
    Scattered reflected{}, transmitted{};
    double background = 0;
    bool clamped = false;
    double extrapolation_error = 0;  // of layers thinner than the table's
};

/// Looks the rows of one layer up.
class LayerLookup {
  public:
    LayerLookup(const TableView& table, const LayerKey& layer, const Effects& asked,
                OutsideTable outside)
        : table_(table.at(FamilyPoint(layer.member))), layer_(layer), asked_(asked) {
        if (table.is_stack()) outside = OutsideTable::refuse;  // no other layer stands for one
        const auto bound = [&](const Effects& effects) {
            Slice slice = bind(table_, layer.optical_depth, layer.albedo, effects, outside);
            clamped_ |= slice.clamped();
            return slice;
        };
        if (asked.background) {
            Effects effects = asked;
            effects.reflection = effects.transmission = false;
            background_ = bound(effects);
        }
        const bool plain = asked.density == 0 && !asked.opposition.is_present();
        if (plain && (is_looked_up(table, layer) || (!asked.multiple && !table.is_stack()))) return;
        if (asked.single) {
            Effects effects = asked;
            effects.multiple = effects.background = false;
            single_ = bound(effects);
        }
        if (asked.multiple) {
            Effects effects = asked;
            effects.single = effects.background = false;
            effects.opposition = {};  // of single scattering alone
            multiple_ = bound(effects);
        }
    }

    Answer at(const Geometry& geometry) const {
        Answer answer;
        answer.clamped = clamped_;
        if (asked_.multiple && !clamped_)
            for (const Side side : both_sides)
                if (side == Side::reflection ? asked_.reflection : asked_.transmission)
                    answer.extrapolation_error =
                        std::max(answer.extrapolation_error,
                                 thin_layer_error(
                                     table_, side, layer_.albedo,
                                     effective_optical_depth(layer_.optical_depth, asked_.density),
                                     geometry));
        if (background_)
            answer.background =
                double{background_->background(static_cast<float>(geometry.mu_out))};
        if (single_ || multiple_) {
            look_up_slices(geometry, answer);
        } else {
            if (asked_.reflection)
                answer.reflected =
                    reflection(table_, layer_.albedo, layer_.optical_depth, geometry);
            if (asked_.transmission)
                answer.transmitted =
                    transmission(table_, layer_.albedo, layer_.optical_depth, geometry);
        }
        return answer;
    }

  private:
    void look_up_slices(const Geometry& geometry, Answer& answer) const {
        const auto in = static_cast<float>(geometry.mu_in),
                   out = static_cast<float>(geometry.mu_out),
                   azimuth = static_cast<float>(geometry.azimuth);
        if (single_) {  // by vectors, which resolve the peak of opposition
            const auto sine = [](double mu) { return std::sqrt((1 - mu) * (1 + mu)); };
            const double s = sine(geometry.mu_out);
            const Vector wi{static_cast<float>(-sine(geometry.mu_in)), 0, in};
            const auto x = static_cast<float>(s * std::cos(geometry.azimuth)),
                       y = static_cast<float>(s * std::sin(geometry.azimuth));
            answer.reflected.single = pi * double{single_->eval(wi, {x, y, out})};
            answer.transmitted.single = pi * double{single_->eval(wi, {x, y, -out})};
        }
        if (multiple_) {
            answer.reflected.multiple = double{multiple_->reflection(in, out, azimuth)};
            answer.transmitted.multiple = double{multiple_->transmission(in, out, azimuth)};
        }
    }

    TableView table_;
    LayerKey layer_;
    Effects asked_;
    std::optional<Slice> background_, single_, multiple_;
    bool clamped_ = false;
};

/// Tells whether --clamp would answer for a layer.
bool can_clamp(const TableView& table, const LayerKey& layer, const Effects& asked) {
    try {
        LayerLookup(table, layer, asked, OutsideTable::clamp);
        return true;
    } catch (const std::invalid_argument&) {
        return false;
    }
}

std::vector<Answer> look_up_rows(const TableView& table, const std::vector<LayerKey>& layers,
                                 const Query& query, const Effects& asked, OutsideTable outside) {
    std::map<LayerKey, std::vector<std::size_t>> rows_by_layer;
    for (std::size_t r = 0; r < layers.size(); ++r) rows_by_layer[layers[r]].push_back(r);
    std::vector<Answer> answers(layers.size());
    for (const auto& [layer, rows] : rows_by_layer) {
        try {
            const LayerLookup lookup(table, layer, asked, outside);
            for (const std::size_t r : rows) answers[r] = lookup.at(query.directions[r].geometry);
        } catch (const std::invalid_argument& error) {
            throw std::invalid_argument(query.row(rows.front()).place() + ": " + error.what() +
                                        (can_clamp(table, layer, asked)
                                             ? "; --clamp takes orders n >= 2 of the nearest layer"
                                             : ""));
        }
    }
    return answers;
}

/// Says once how many rows lie outside the table, where the orders n >= 2 come from its edge.
void warn_of_clamped(const Query& query, const std::vector<LayerKey>& layers,
                     const std::vector<Answer>& answers, const TableView& table, double density) {
    long rows_in[6] = {};
    for (std::size_t r = 0; r < layers.size(); ++r) {
        const auto& [mu_in, mu_out, azimuth] = query.directions[r].geometry;
        const LayerKey& layer = layers[r];
        rows_in[0] += is_outside(table.mu_in, mu_in);
        rows_in[1] += is_outside(table.mu_out, mu_out);
        rows_in[5] += is_azimuth_outside(table.azimuth, azimuth);
        if (!answers[r].clamped) continue;
        rows_in[2] +=
            is_outside(table.optical_depth, effective_optical_depth(layer.optical_depth, density));
        rows_in[3] += is_outside(table.albedo, layer.albedo);
        rows_in[4] += is_member_outside(table, layer);
    }
    constexpr const char* names[] = {
        "mu_in",      "mu_out", "optical_depth", "albedo", "parameters of the phase function",
        "azimuth_deg"};
    std::string list;
    for (std::size_t axis = 0; axis < std::size(names); ++axis)
        if (rows_in[axis] > 0)
            list +=
                (list.empty() ? "" : ", ") + std::to_string(rows_in[axis]) + " in " + names[axis];
    if (list.empty()) return;
    say("warning: of " + std::to_string(layers.size()) +
        " rows some lie outside the table; multiple scattering there is that of its edge: " + list);
}

/// Says once how many rows are thinner than the table's layers and off by more than its tolerance.
void warn_of_extrapolated(const std::vector<Answer>& answers, const TableView& table) {
    long rows = 0;
    double most = 0;
    for (const Answer& answer : answers) {
        rows += answer.extrapolation_error > table.tolerance;
        most = std::max(most, answer.extrapolation_error);
    }
    if (rows > 0)
        say("warning: of " + std::to_string(answers.size()) + " rows " + std::to_string(rows) +
            " are of thinner layers than the table's, whose multiple scattering is extrapolated: R "
            "or T is off by " +
            short_number(100 * most, 2) + " % or so at most");
}

/// A column of an answer, and what stands in it.
struct AnswerColumn {
    std::string name;
    std::function<double(const Answer& answer)> value;
};

std::vector<AnswerColumn> answer_columns(const Effects& effects) {
    std::vector<AnswerColumn> columns;
    const auto both_sides = [&](const std::string& ending, bool single, bool multiple) {
        const auto light = [=](const Scattered& all) {
            return (single ? all.single : 0) + (multiple ? all.multiple : 0);
        };
        if (effects.reflection)
            columns.push_back({"reflection" + ending,
                               [=](const Answer& answer) { return light(answer.reflected); }});
        if (effects.transmission)
            columns.push_back({"transmission" + ending,
                               [=](const Answer& answer) { return light(answer.transmitted); }});
    };
    both_sides("", effects.single, effects.multiple);
    if (effects.single) both_sides("_single", true, false);
    if (effects.multiple) both_sides("_multiple", false, true);
    if (effects.background) columns.push_back({"background", &Answer::background});
    return columns;
}

/// The view without the samples that are not asked for: the lookup then does not touch them.
TableView without_unasked_samples(TableView table, const Effects& effects) {
    if (effects.multiple) return table;
    table.reflection_multiple = table.transmission_multiple = {};
    table.packed = nullptr;
    table.packed_reflection = table.packed_transmission = false;
    return table;
}

void run_eval(const EvalOptions& options) {
    Effects asked = parse_effects(options.effects);
    asked.density = parse_density("eval", options.density);
    asked.opposition = parse_opposition("eval", options.opposition, asked.density);
    check_effects(asked);
    require_different_files("eval", {options.table, options.query}, {options.output});
    const AnyTable table = read_any_table(options.table, options.reading);
    const QueryColumns columns = query_columns(table.table());
    const Query query = read_query(options.query, columns.required, columns.optional);
    const std::vector<LayerKey> layers = make_layers(query, table.table());

    const Effects effects = available_effects(asked, table.view(), options.table);
    const TableView view = without_unasked_samples(table.view(), effects);
    const std::vector<Answer> answers = look_up_rows(
        view, layers, query, effects, options.clamp ? OutsideTable::clamp : OutsideTable::refuse);
    if (effects.multiple) warn_of_clamped(query, layers, answers, view, asked.density);
    warn_of_extrapolated(answers, view);

    const std::vector<AnswerColumn> answered = answer_columns(effects);
    std::vector<std::string> names;
    for (const AnswerColumn& column : answered) names.push_back(column.name);
    write_answer(options.output, [&](std::ostream& out) {
        write_answer_header(out, query, names);
        for (std::size_t r = 0; r < answers.size(); ++r) {
            std::vector<double> values;
            for (const AnswerColumn& column : answered) values.push_back(column.value(answers[r]));
            write_answer_row(out, query, r, names, values);
        }
    });
}

}  // namespace

void add_eval(CLI::App& app) {
    const auto [command, options] =
        add_command<EvalOptions>(app, "eval", "Look up a table at the rows of a query", run_eval);
    add_table(command, options.table);
    add_file(command, "--query", options.query,
             "CSV with columns " + direction_columns_help +
                 ", and optical_depth, albedo, in any order; the last two may be left out "
                 "where the table has one sample. Tables of a family need its parameters, "
                 "too (g, variance, mixture; radius and "
                 "wavelength in um). "
                 "Default or -: standard input");
    add_csv_output(command, options.output);
    command
        .add_option("--effects", options.effects,
                    std::string("What to evaluate, out of ") + effect_names +
                        ", comma between. Default: all that the table holds")
        ->delimiter(',')
        ->allow_extra_args(false);  // or it would take TABLE too
    add_density_and_opposition(command, options.density, options.opposition);
    command.add_flag("--clamp", options.clamp,
                     "Take orders n >= 2 of layers outside the table from the nearest one inside "
                     "it, with a warning, instead of refusing them");
    add_max_memory(command, options.reading);
    command.footer(
        observed_angles_help +
        "Answers of the side that a row of such angles does not see are nan.\n"
        "The column background, asked for by that name, is the share of a uniform background that "
        "is seen through the layer at mu_out: the beam, and the diffuse transmittance.\n"
        "Example:\n"
        "  printf 'mu_in,mu_out,azimuth_deg,optical_depth,albedo\\n0.5,0.8,60,1.5,0.9\\n' \\\n"
        "    | stratus eval saturn_rings.h5 --effects reflection");
}

}  // namespace stratus
