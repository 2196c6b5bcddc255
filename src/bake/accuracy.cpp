#include <stratus/bake/accuracy.h>

#include <stratus/bake/parallel.h>
#include <stratus/runtime/angle.h>
#include <stratus/runtime/argument.h>
#include <stratus/runtime/constants.h>
#include <stratus/runtime/diffusion.h>
#include <stratus/runtime/slice.h>
#include <stratus/transfer/quadrature.h>

#include "piece_of_work.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

namespace stratus {

namespace {

/// Errors are not relative to less: fainter light shows in no picture and no measurement.
constexpr double min_value = 1e-8;

/// The floor of one side's errors: values(i, j, azimuths) at the floor's cosines.
template <class Values>
double floor_of(const LayerSolution& solution, Values values) {
    // Not straight on in a narrow peak: 1 % of that is more than all the rest.
    std::vector<double> azimuths{pi / 2, pi};
    if (!has_narrow_peak(solution.phase_function)) azimuths.insert(azimuths.begin(), 0);
    std::vector<int> at;
    for (const double mu : floor_cosines()) {
        const auto found = std::find(solution.mu.begin(), solution.mu.end(), mu);
        if (found != solution.mu.end()) at.push_back(static_cast<int>(found - solution.mu.begin()));
    }
    double max = 0;
    for (std::size_t i = 0; i < at.size(); ++i)
        for (std::size_t j = i; j < at.size(); ++j)  // both are symmetric
            for (const SolvedValue& value : values(at[i], at[j], azimuths))
                max = std::max(max, value.total);
    return std::max(0.01 * max, min_value);
}

/// Index of a quantile among `count` values in ascending order.
std::ptrdiff_t quantile_index(std::size_t count, double share) {
    return static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(count - 1)));
}

PointRange range_of(const Table& table) {
    const TableView view = table.view();
    return {view.albedo,
            view.optical_depth,
            view.mu_in,
            view.mu_out,
            view.has_reflection(),
            view.has_transmission(),
            table.lower_boundary,
            view.mixture,
            table.second_phase_function,
            view.path_law != nullptr,
            true,
            view.azimuth};
}

struct RandomLayer {
    double albedo, optical_depth;
    double mixture = 1;
};

/// Evenly spread over the cells of a range.
RandomLayer random_layer(const PointRange& range, std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(0, 1);
    auto between = [&](double low, double high) { return low + uniform(random) * (high - low); };
    const AxisView &w = range.albedo, &tau = range.optical_depth;
    RandomLayer layer{};
    const double s = between(std::sqrt(1 - w.lowest), std::sqrt(1 - w.highest));
    layer.albedo = w.count == 1 ? w.lowest : std::clamp(1 - s * s, w.lowest, w.highest);
    const double index = uniform(random) * (tau.size() - 1);
    if (tau.count == 0)
        layer.optical_depth = infinity;
    else if (index > tau.count - 1)
        layer.optical_depth = tau.highest / (tau.size() - 1 - index);
    else
        layer.optical_depth =
            std::clamp(std::exp2(between(std::log2(tau.lowest), std::log2(tau.highest))),
                       tau.lowest, tau.highest);
    if (range.mixture.count > 0)
        layer.mixture = between(range.mixture.lowest, range.mixture.highest);
    return layer;
}

/// Evenly spread over the square root.
double random_cosine(double lowest, double highest, std::mt19937& random) {
    std::uniform_real_distribution<double> x(std::sqrt(lowest), std::sqrt(highest));
    const double root = x(random);
    return std::clamp(root * root, lowest, highest);
}

/// The least cosine of an axis that is judged with the even points.
double least_cosine(const PointRange& range, const AxisView& axis) {
    return range.has_path_law ? std::clamp(least_judged_cosine, axis.lowest, axis.highest)
                              : axis.lowest;
}

struct Azimuths {
    double lowest, highest;

    bool hold(double azimuth) const { return azimuth >= lowest && azimuth <= highest; }
};

Azimuths azimuths_of(const PointRange& range) {
    const AxisView& azimuth = range.azimuth;
    const bool any = azimuth.count == 0 || (azimuth.count == 1 && azimuth.lowest == 0);
    return any ? Azimuths{0, pi} : Azimuths{azimuth.lowest, azimuth.highest};
}

bool is_same(const AxisView& a, const AxisView& b) {
    return a.count == b.count && a.lowest == b.lowest && a.highest == b.highest;
}

struct RandomPoint {
    Geometry at;
    PointKind kind;
    std::vector<Side> sides;
};

/// Directions within the cone around straight on, evenly over its angle, that leave on one side;
/// none after a hundred trials.
std::optional<Geometry> random_forward(const PointRange& range, Side side, std::mt19937& random) {
    const double widest = radians(forward_cone);
    std::uniform_real_distribution<double> angle(0, widest), turn(0, pi);
    // Light comes back within the cone from grazing incidence alone.
    const double highest = side == Side::reflection
                               ? std::min(range.mu_in.highest, std::sin(widest))
                               : range.mu_in.highest;
    const double lowest = least_cosine(range, range.mu_in);
    if (lowest > highest) return std::nullopt;
    for (int trial = 0; trial < 100; ++trial) {
        const double mu_in = random_cosine(lowest, highest, random);
        const double sine_in = std::sqrt((1 - mu_in) * (1 + mu_in));
        const double theta = angle(random), psi = turn(random);
        const double down = std::cos(theta) * mu_in + std::sin(theta) * std::cos(psi) * sine_in;
        const double along = std::cos(theta) * sine_in - std::sin(theta) * std::cos(psi) * mu_in;
        const double mu_out = side == Side::reflection ? -down : down;
        const double azimuth = std::atan2(std::sin(theta) * std::sin(psi), along);
        if (mu_out >= least_cosine(range, range.mu_out) && mu_out <= range.mu_out.highest &&
            azimuths_of(range).hold(azimuth))
            return Geometry{mu_in, mu_out, azimuth};
    }
    return std::nullopt;
}

/// Evenly drawn points, then those of the other kinds where something is peaked.
std::vector<RandomPoint> random_points(const PointRange& range, bool peaked, int count,
                                       std::mt19937& random) {
    std::vector<Side> sides;
    if (range.reflection) sides.push_back(Side::reflection);
    if (range.transmission) sides.push_back(Side::transmission);
    const Azimuths azimuths = azimuths_of(range);
    std::uniform_real_distribution<double> azimuth(azimuths.lowest, azimuths.highest);
    std::vector<RandomPoint> points;
    // By the points of layers that take long: each cosine adds to it.
    std::vector<double> shared_in, shared_out;
    const bool same = is_same(range.mu_in, range.mu_out);
    const auto anywhere = [&](const AxisView& axis) {
        constexpr std::size_t few = 16;
        std::vector<double>& shared = same || &axis == &range.mu_in ? shared_in : shared_out;
        if (shared.size() == few) return shared[random() % few];
        const double mu = random_cosine(least_cosine(range, axis), axis.highest, random);
        if (range.has_path_law) shared.push_back(mu);
        return mu;
    };
    for (int n = 0; n < count; ++n) {
        const double mu_in = anywhere(range.mu_in), mu_out = anywhere(range.mu_out);
        points.push_back({{mu_in, mu_out, azimuth(random)}, PointKind::even, sides});
    }
    if (!peaked) return points;
    for (int n = 0; n < (range.has_path_law ? count + 3 : 2 * count + 2) / 4; ++n)
        for (const Side side : sides)
            if (const auto at = random_forward(range, side, random))
                points.push_back({*at, PointKind::forward, {side}});
    const auto grazing = [&](const AxisView& axis) {
        return random_cosine(axis.lowest, std::min(axis.highest, grazing_cosine), random);
    };
    if (range.mu_in.lowest < grazing_cosine && range.mu_out.lowest < grazing_cosine)
        for (int n = 0; n < (count + 3) / 4; ++n) {
            const double mu_in = grazing(range.mu_in);
            const double mu_out =
                range.has_path_law ? anywhere(range.mu_out) : grazing(range.mu_out);
            points.push_back({{mu_in, mu_out, azimuth(random)}, PointKind::grazing, sides});
        }
    return points;
}

}  // namespace

const std::vector<double>& floor_cosines() {
    static const std::vector<double> cosines{0.1, 0.3, 0.6, 1.0};
    return cosines;
}

double reflection_floor(const LayerSolution& solution) {
    return floor_of(solution, [&](int i, int j, const std::vector<double>& azimuths) {
        return solution.reflection(i, j, azimuths);
    });
}

double transmission_floor(const LayerSolution& solution) {
    return floor_of(solution, [&](int i, int j, const std::vector<double>& azimuths) {
        return solution.transmission(i, j, azimuths);
    });
}

double error_quantile(std::vector<double>& errors, double share) {
    if (errors.empty()) return 0;
    const auto at = errors.begin() + quantile_index(errors.size(), share);
    std::nth_element(errors.begin(), at, errors.end());
    return *at;
}

double error_quantile(std::vector<ErrorSample>& samples, double share) {
    if (samples.empty()) return 0;
    std::sort(samples.begin(), samples.end(),
              [](const ErrorSample& a, const ErrorSample& b) { return a.error < b.error; });
    return samples.begin()[quantile_index(samples.size(), share)].error;
}

bool is_peaked(const PhaseFunction& phase_function) { return phase_function(1.0) >= 40; }

int points_of_layer(const PointRange& range) { return range.has_path_law ? 24 : 8; }

int reference_nodes(int nodes) { return std::min(512, nodes + std::max(8, nodes / 2)); }

bool Verification::meets(double tolerance) const {
    const auto within = [&](const std::vector<ErrorSample>& some, double share) {
        const auto count = std::count_if(some.begin(), some.end(), [&](const ErrorSample& sample) {
            return sample.error <= tolerance;
        });
        return static_cast<double>(count) >= share * static_cast<double>(some.size());
    };
    return within(samples, 0.999) && (samples.empty() || samples.back().error <= 5 * tolerance) &&
           within(forward, 0.99) && (!judges_grazing || within(grazing, 0.99));
}

namespace {

bool has_peak(const PhaseFunction& phase_function, const PointRange& range) {
    const LowerBoundary& below = range.lower_boundary;
    return is_peaked(phase_function) ||
           (range.mixture.count > 0 && is_peaked(range.second_phase_function)) ||
           (below.kind == LowerBoundary::Kind::layer && is_peaked(below.phase_function));
}

/// Points of one random layer; `piece` names its solution in the log.
void solve_points(const PhaseFunction& phase_function, const PointRange& range,
                  const SolverOptions& solver, int geometries, std::mt19937& random,
                  const WorkLog& log, const std::string& piece, std::vector<ErrorSample>& into) {
    const RandomLayer layer = random_layer(range, random);
    const std::vector<RandomPoint> points = random_points(
        range, range.all_kinds && has_peak(phase_function, range), geometries, random);
    std::vector<double> mu = floor_cosines();
    std::vector<Side> sides;
    if (range.reflection) sides.push_back(Side::reflection);
    if (range.transmission) sides.push_back(Side::transmission);

    std::size_t count = sides.size();
    std::vector<int> places;  // in mu, of the points' two cosines
    for (const RandomPoint& point : points) {
        count += point.sides.size();
        for (const double cosine : {point.at.mu_in, point.at.mu_out}) {
            const auto found = std::find(mu.begin(), mu.end(), cosine);
            places.push_back(static_cast<int>(found - mu.begin()));
            if (found == mu.end()) mu.push_back(cosine);
        }
    }
    // A floor for each side, then the totals, point by point.
    std::vector<double> solved;
    if (auto finished = find_finished<double>(log, piece, count)) {
        solved = std::move(*finished);
    } else {
        const PhaseFunction mixed = range.mixture.count == 0
                                        ? phase_function
                                        : PhaseFunction::mixture(layer.mixture, phase_function,
                                                                 range.second_phase_function);
        const LayerSolution solution =
            solve_layer(mixed, layer.albedo, layer.optical_depth, mu, solver, range.lower_boundary);
        for (const Side side : sides)
            solved.push_back(side == Side::reflection ? reflection_floor(solution)
                                                      : transmission_floor(solution));
        const int* at = places.data();
        for (const RandomPoint& point : points) {
            const double phi = point.at.azimuth;
            for (const Side side : point.sides)
                solved.push_back(side == Side::reflection
                                     ? solution.reflection(at[0], at[1], phi).total
                                     : solution.transmission(at[0], at[1], phi).total);
            at += 2;
        }
        keep_finished(log, piece, solved);
    }
    std::size_t next = sides.size();
    for (const RandomPoint& point : points)
        for (const Side side : point.sides) {
            const bool reflected = side == Side::reflection;
            const double cosine = reflected ? cos_scattering_angle_reflected(point.at)
                                            : cos_scattering_angle_transmitted(point.at);
            into.push_back({side, layer.albedo, layer.optical_depth, point.at,
                            std::acos(std::clamp(cosine, -1.0, 1.0)), solved[next++], 0, 0,
                            reflected ? solved.front() : solved[sides.size() - 1], layer.mixture,
                            point.kind});
        }
}

/// Largest |1 - plane albedo - diffuse and direct transmittance| where the table has w = 1; -1
/// where it has not, not all orders, or a lower boundary that absorbs the rest.
double energy_defect(const Table& table) {
    const AxisView w = table.albedo.view(), tau = table.optical_depth.view();
    if (table.albedo.values.back() != 1 || table.plane_albedo.empty() || table.highest_order > 0 ||
        table.lower_boundary.is_present())
        return -1;
    double worst = 0;
    const std::size_t mus = table.mu_in.values.size();
    const auto albedos = static_cast<std::size_t>(w.count);
    const auto depths = static_cast<std::size_t>(tau.size());
    for (std::size_t m = 0; m < table.mixture_count(); ++m)
        for (std::size_t d = 0; d < depths; ++d) {
            const double depth = table.optical_depth.values[d];
            if (table.diffuse_transmittance.empty() && !std::isinf(depth)) continue;
            for (std::size_t i = 0; i < mus; ++i) {
                const std::size_t at = (((m + 1) * albedos - 1) * depths + d) * mus + i;
                const double transmitted =
                    table.diffuse_transmittance.empty() ? 0 : table.diffuse_transmittance[at];
                const double left = 1 - static_cast<double>(table.plane_albedo[at]) - transmitted;
                worst = std::max(
                    worst, std::abs(left - direct_transmittance(depth, table.mu_in.values[i])));
            }
        }
    return worst;
}

/// The furnace_defect of a Verification, at one mixture.
double furnace_defect(const Table& table, std::size_t mixture) {
    const TableView view =
        table.view().at_mixture(table.has_mixture() ? table.mixture.values[mixture] : 1);
    const Azimuths azimuths_known = azimuths_of(range_of(table));
    if (!view.has_reflection() || table.plane_albedo.empty() || !is_same(view.mu_in, view.mu_out) ||
        azimuths_known.lowest > 0 || azimuths_known.highest < pi)
        return -1;
    const Directions outgoing = gauss_directions(48, NodeMap::grazing);
    const int azimuths = 96;
    double worst = 0;
    const auto mus = table.mu_in.values.size();
    const std::size_t depths = table.optical_depth.values.size();
    const std::size_t first_albedo = mixture * table.albedo.values.size();
    for (std::size_t w : {std::size_t{0}, table.albedo.values.size() - 1})
        for (std::size_t d = 0; d < depths; d += std::max<std::size_t>(1, depths / 6))
            for (std::size_t i = 0; i < mus; i += std::max<std::size_t>(1, mus / 4)) {
                const double mu_in = table.mu_in.values[i];
                if (mu_in < 0.1) continue;
                double sum = 0;
                for (int j = 0; j < outgoing.nodes; ++j)
                    for (int k = 0; k < azimuths; ++k)
                        sum +=
                            2 * outgoing.mu(j) * outgoing.weight(j) / azimuths *
                            reflection(view, table.albedo.values[w], table.optical_depth.values[d],
                                       {mu_in, outgoing.mu(j), pi * (k + 0.5) / azimuths})
                                .total();
                worst = std::max(
                    worst,
                    std::abs(sum -
                             static_cast<double>(
                                 table.plane_albedo[((first_albedo + w) * depths + d) * mus + i])));
            }
    return worst;
}

}  // namespace

std::vector<ErrorSample> solve_random_points(const PhaseFunction& phase_function,
                                             const PointRange& range, const SolverOptions& solver,
                                             const VerifyOptions& options) {
    const int points = points_of_layer(range);
    const int layers = (options.samples + points - 1) / points;
    std::vector<std::vector<ErrorSample>> of_layer(static_cast<std::size_t>(layers));
    auto solve = [&](int layer) {
        stop_if_asked(options.log);
        std::mt19937 random(options.seed * 1000003u + static_cast<unsigned>(layer));
        const int rest = options.samples - layer * points;
        solve_points(phase_function, range, solver, std::min(rest, points), random, options.log,
                     "points from " + std::to_string(layer * points),
                     of_layer[static_cast<std::size_t>(layer)]);
    };
    parallel_for(layers, options.threads, solve, [&](int done) {
        if (options.progress) options.progress(static_cast<double>(done) / layers);
    });
    std::vector<ErrorSample> samples;
    for (const auto& some : of_layer) samples.insert(samples.end(), some.begin(), some.end());
    return samples;
}

namespace {

/// found(sample) is what a lookup says.
template <class Found>
void compare(std::vector<ErrorSample>& samples, const Found& found) {
    for (ErrorSample& at : samples) {
        at.found = found(at);
        at.error = std::abs(at.found - at.expected) / std::max(at.expected, at.floor);
    }
}

}  // namespace

void look_up(const TableView& table, std::vector<ErrorSample>& samples) {
    compare(samples, [&](const ErrorSample& at) {
        const auto side = at.side == Side::reflection ? reflection : transmission;
        return side(table.at_mixture(at.mixture), at.albedo, at.optical_depth, at.geometry).total();
    });
}

void look_up_bound(const TableView& table, std::vector<ErrorSample>& samples) {
    compare(samples, [&](const ErrorSample& at) {
        Effects effects;
        effects.reflection = at.side == Side::reflection;
        effects.transmission = !effects.reflection;
        effects.background = false;
        const Slice slice =
            bind(table.at_mixture(at.mixture), at.optical_depth, at.albedo, effects);
        const auto mu_in = static_cast<float>(at.geometry.mu_in);
        const auto mu_out = static_cast<float>(at.geometry.mu_out);
        const auto azimuth = static_cast<float>(at.geometry.azimuth);
        return double{effects.reflection ? slice.reflection(mu_in, mu_out, azimuth)
                                         : slice.transmission(mu_in, mu_out, azimuth)};
    });
}

Verification verify(const Table& table, const VerifyOptions& options) {
    require(options.samples >= 1, "verify", "samples", ">= 1", options.samples);
    const auto stored = table.attributes.find("nodes");
    const int nodes =
        stored == table.attributes.end() ? 32 : std::max(1, std::atoi(stored->second.c_str()));
    Verification result;
    result.reference_nodes = reference_nodes(nodes);
    result.judges_grazing = table.path_law == nullptr;
    SolverOptions solver;
    solver.nodes = result.reference_nodes;
    solver.orders = table.highest_order;
    solver.exact_fluxes = false;
    solver.mode_tolerance = 1e-3 * table.tolerance;

    const TableView view = table.view();
    std::vector<ErrorSample> all =
        solve_random_points(table.phase_function, range_of(table), solver, options);
    (options.bound ? look_up_bound : look_up)(view, all);
    error_quantile(all, 1);  // sorts
    for (const ErrorSample& sample : all)
        (sample.kind == PointKind::even      ? result.samples
         : sample.kind == PointKind::forward ? result.forward
                                             : result.grazing)
            .push_back(sample);
    result.energy_defect = energy_defect(table);
    result.furnace_defect = furnace_defect(table, 0);
    if (table.has_mixture())
        result.furnace_defect =
            std::max(result.furnace_defect, furnace_defect(table, table.mixture.values.size() - 1));
    return result;
}

}  // namespace stratus
