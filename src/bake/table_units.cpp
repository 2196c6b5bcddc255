#include "table_units.h"

#include <stratus/bake/axes.h>
#include <stratus/bake/bake.h>
#include <stratus/bake/parallel.h>
#include <stratus/base/argument.h>
#include <stratus/transfer/stack.h>

#include "recipe_sections.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace stratus {

std::vector<std::vector<LayerSolution>> solve_material(
    const StackLayers& layers, const PhaseFunction& phase_function,
    const std::vector<double>& albedos, const DepthLadder& ladder, const std::vector<double>& mu,
    const SolverOptions& options, const LowerBoundary& boundary, const TakeMode& take) {
    if (layers.empty())
        return solve_ladder(phase_function, albedos, ladder, mu, options, boundary, take);
    std::vector<std::vector<LayerSolution>> alone(1);
    alone[0].push_back(as_one_layer(solve_stack(layers, boundary, mu, options)));
    return alone;
}

std::vector<PhaseFunction> list_phase_functions(const StackLayers& layers,
                                                const PhaseFunction& phase_function,
                                                const LowerBoundary& boundary) {
    std::vector<PhaseFunction> all;
    for (const StackLayer& layer : layers) all.push_back(layer.phase_function);
    if (layers.empty()) all.push_back(phase_function);
    if (boundary.is_layer()) all.push_back(boundary.phase_function);
    return all;
}

namespace {

/// Albedos that one run of the solver works on at once. Eight fill its registers mode by mode; where
/// modes are many four do nearly as well with two modes at a time, fewer lanes idle in the last run, and modes
/// take half of the memory. Where they are very many two take little longer, and half of that again. A
/// few orders are solved once for all albedos (ordered_ladder.h), which then cost little more than their memory.
std::size_t albedos_at_once(const Recipe& recipe) {
    const int modes = recipe.discretisation.modes;
    return (modes >= 32 ? 2 : modes >= 10 ? 4 : 8) * (recipe.orders > 0 ? 4 : 1);
}

const Recipe& checked(const Recipe& resolved) {
    const Discretisation& d = resolved.discretisation;
    std::vector<std::pair<std::string, int>> choices{{"nodes", d.nodes},
                                                     {"modes", d.modes},
                                                     {"mu_samples", d.mu_samples},
                                                     {"azimuth_samples", d.azimuth_samples},
                                                     {"albedo_samples", d.albedo_samples}};
    for (std::size_t k = 0; k < resolved.family.size(); ++k)
        if (resolved.family[k].values.empty())
            choices.push_back({samples_key(resolved.family[k].parameter), d.family_samples[k]});
    for (const auto& [name, count] : choices)
        require(count >= 1, "solve_table", name, "resolved", count);
    check_directions(resolved);
    return resolved;
}

}  // namespace

TableUnits::TableUnits(const Recipe& resolved) : recipe_(with_path_law_decided(checked(resolved))) {
    place_axes();
    header_.path_law = recipe_path_law(recipe_);
    for (std::size_t m = 0; m < header_.member_count(); ++m) {
        members_.push_back(at_member(recipe_, member_at(header_.family, m)));
        const Recipe& member = members_.back();
        const std::vector<double> exponents = decay_exponents(member, header_.albedo.values);
        header_.extrapolation_lengths.push_back(
            extrapolation_length(member.phase_function, member.lower_boundary));
        header_.diffusion_exponent.insert(header_.diffusion_exponent.end(), exponents.begin(),
                                          exponents.end());
        grids_.emplace_back(member.phase_function, member.lower_boundary, mu_,
                            header_.azimuth.values, recipe_.discretisation.modes,
                            recipe_path_law(member), pairs_);
    }
}

void TableUnits::place_axes() {
    const Discretisation& d = recipe_.discretisation;
    header_.phase_function = recipe_.phase_function;
    header_.lower_boundary = recipe_.lower_boundary;
    header_.layers = recipe_.layers;
    header_.highest_order = recipe_.orders;
    header_.tolerance = recipe_.tolerance;
    header_.extrapolation_length =
        extrapolation_length(recipe_.phase_function, recipe_.lower_boundary);
    header_.family = family_axes(recipe_);
    if (mixture_range(recipe_) != nullptr)
        header_.second_phase_function = recipe_.second_phase_function;
    header_.albedo = albedo_axis(recipe_.albedo, d.albedo_samples, d.albedo_scale);
    header_.optical_depth = optical_depth_axis(
        recipe_.optical_depth, d.optical_depth_samples_per_octave, d.deepest_optical_depth);
    DirectionAxes directions = direction_axes(recipe_);
    header_.mu_in = std::move(directions.mu_in);
    header_.mu_out = std::move(directions.mu_out);
    header_.azimuth = std::move(directions.azimuth);
    place_cosines();
}

/// The cosines to be solved at: those along both axes, once where they are the same.
void TableUnits::place_cosines() {
    mu_ = header_.mu_in.values;
    pairs_.in.resize(mu_.size());
    std::iota(pairs_.in.begin(), pairs_.in.end(), 0);
    pairs_.out = pairs_.in;
    pairs_.exchangeable = recipe_.layers.empty();
    if (header_.mu_out.values == mu_) return;
    pairs_.out.resize(header_.mu_out.values.size());
    std::iota(pairs_.out.begin(), pairs_.out.end(), int_size(mu_));
    mu_.insert(mu_.end(), header_.mu_out.values.begin(), header_.mu_out.values.end());
}

/// One run of doubling serves all octaves: as many runs as samples an octave.
int TableUnits::runs() const {
    const int depths = header_.optical_depth.view().count;
    const int per_octave = std::max(1, recipe_.discretisation.optical_depth_samples_per_octave);
    return depths == 0 ? 1 : std::min(per_octave, depths);
}

std::vector<Unit> TableUnits::all() const {
    std::vector<int> layers(header_.layer_count());
    std::iota(layers.begin(), layers.end(), 0);
    return make_units(layers, albedos_at_once(recipe_));
}

std::vector<Unit> TableUnits::holding(const std::vector<int>& layers) const {
    return make_units(layers, recipe_.orders > 0 ? albedos_at_once(recipe_) : 1);
}

std::vector<Unit> TableUnits::make_units(const std::vector<int>& layers,
                                         std::size_t at_once) const {
    const AxisView tau = header_.optical_depth.view();
    const int depths = tau.size(), albedos = int_size(header_.albedo.values);
    struct Run {
        std::set<std::size_t> albedos;
        std::set<int> octaves;
        bool to_infinity = false;
    };
    std::map<std::pair<std::size_t, int>, Run> runs_by_member;  // by member and run
    for (const int layer : layers) {
        const int depth = layer % depths;
        const bool is_infinite = depth == tau.count;
        const int deepest = is_infinite ? std::max(0, tau.count - 1) : depth;
        Run& run = runs_by_member[{size(layer / depths / albedos), deepest % runs()}];
        run.albedos.insert(size(layer / depths % albedos));
        if (is_infinite)
            run.to_infinity = true;
        else
            run.octaves.insert(depth / runs());
    }
    std::vector<Unit> units;
    for (const auto& [key, run] : runs_by_member) {
        const std::vector<std::size_t> of_run(run.albedos.begin(), run.albedos.end());
        DepthLadder ladder{1, 0, run.to_infinity};
        if (tau.count > 0) {
            ladder.first = header_.optical_depth.values[size(key.second)];
            ladder.octaves =
                run.to_infinity ? (tau.count - 1) / runs() + 1 : *run.octaves.rbegin() + 1;
            ladder.asked.assign(size(ladder.count()), run.to_infinity);
            for (int octave = 0; octave < ladder.octaves; ++octave)
                ladder.asked[size(octave)] = run.octaves.count(octave) > 0;
        }
        for (std::size_t first = 0; first < of_run.size(); first += at_once)
            units.push_back({key.first,
                             key.second,
                             {of_run.begin() + static_cast<std::ptrdiff_t>(first),
                              of_run.begin() + static_cast<std::ptrdiff_t>(
                                                   std::min(first + at_once, of_run.size()))},
                             ladder});
    }
    return units;
}

std::vector<int> TableUnits::unit_layers(const Unit& unit) const {
    const std::size_t albedos = header_.albedo.values.size();
    const std::size_t depths = header_.optical_depth.values.size();
    std::vector<int> layers;
    for (const std::size_t albedo : unit.albedos) {
        const auto first = static_cast<int>((unit.member * albedos + albedo) * depths);
        for (int d = 0; d < unit.ladder.count(); ++d)
            if (unit.ladder.asks_for(d))
                layers.push_back(first + (d < unit.ladder.octaves ? unit.run + d * runs()
                                                                  : static_cast<int>(depths) - 1));
    }
    return layers;
}

std::vector<SolvedLayer> TableUnits::solve(const Unit& unit, const TakeMode& take) const {
    std::vector<double> albedos;
    for (const std::size_t albedo : unit.albedos) albedos.push_back(header_.albedo.values[albedo]);
    const std::vector<int> numbers = unit_layers(unit);
    std::vector<SolvedLayer> solved;
    for (auto& of_albedo :
         solve_material(recipe_.layers, members_[unit.member].phase_function, albedos, unit.ladder,
                        mu_, solver_options(recipe_), recipe_.lower_boundary, take))
        for (LayerSolution& solution : of_albedo)
            solved.push_back({numbers[solved.size()], std::move(solution)});
    return solved;
}

std::string TableUnits::unit_name(const Unit& unit) const {
    std::string name = "depths from " + std::to_string(unit.run) + ", " +
                       std::to_string(unit.ladder.octaves) + " octaves" +
                       (unit.ladder.to_infinity ? " and infinity" : "") + ", albedos";
    for (const std::size_t albedo : unit.albedos) name += ' ' + std::to_string(albedo);
    return header_.has_family() ? "member " + std::to_string(unit.member) + ", " + name : name;
}

double TableUnits::unit_weight(const Unit& unit) const {
    return std::max(1.0, static_cast<double>(unit.albedos.size()) * unit.ladder.octaves);
}

/// Seconds that one thread takes for a layer of a unit, timed.
double TableUnits::layer_seconds(const Unit& unit) const {
    // Few albedos, of which the modes alone fill the registers.
    Unit timed = unit;
    const int modes = recipe_.discretisation.modes;
    timed.albedos.resize(std::min<std::size_t>(timed.albedos.size(), modes >= 32   ? 1
                                                                     : modes >= 16 ? 2
                                                                     : modes >= 8  ? 4
                                                                                   : 8));
    const double started = processor_seconds();
    for (const SolvedLayer& layer : solve(timed))
        for (const Side side : both_sides)
            if (side == Side::reflection ? recipe_.reflection : recipe_.transmission)
                evaluate_tabulated(layer.solution, side, grids_[timed.member]);
    return (processor_seconds() - started) / unit_weight(timed);
}

/// From the first unit of the nearest timed member: the ends and the middle, for members take very
/// different times.
std::vector<double> TableUnits::predicted_seconds() const {
    const std::vector<Unit> units = all();
    const std::size_t units_of_member = units.size() / members_.size(), last = members_.size() - 1;
    std::map<std::size_t, double> of_member;  // seconds a layer
    for (const std::size_t member : {std::size_t{0}, last / 2, last})
        if (of_member.count(member) == 0)
            of_member[member] = layer_seconds(units[member * units_of_member]);
    std::vector<double> seconds;
    for (const Unit& unit : units) {
        const auto distance = [&](const auto& timed) {
            return timed.first < unit.member ? unit.member - timed.first
                                             : timed.first - unit.member;
        };
        const auto nearest = std::ranges::min_element(of_member, {}, distance);
        seconds.push_back(nearest->second * unit_weight(unit));
    }
    return seconds;
}

}  // namespace stratus
