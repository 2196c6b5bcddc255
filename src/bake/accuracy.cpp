#include <stratus/bake/accuracy.h>

#include <stratus/bake/parallel.h>
#include <stratus/base/argument.h>
#include <stratus/base/constants.h>
#include <stratus/bsdf/slice.h>
#include <stratus/io/write_options.h>
#include <stratus/table/packed_table.h>
#include <stratus/transfer/quadrature.h>
#include <stratus/transfer/stack.h>

#include "piece_of_work.h"
#include "table_units.h"

#include <algorithm>
#include <cmath>

namespace stratus {

namespace {

/// Errors are not relative to less: fainter light shows in no picture and no measurement.
constexpr double min_value = 1e-8;

}  // namespace

PointRange point_range(const Table& table, const TableView& view) {
    return {view.albedo,
            view.optical_depth,
            view.mu_in,
            view.mu_out,
            view.has_reflection(),
            view.has_transmission(),
            table.lower_boundary,
            table.family,
            table.second_phase_function,
            view.path_law != nullptr,
            true,
            view.azimuth,
            table.layers};
}

const std::vector<double>& floor_cosines() {
    static const std::vector<double> cosines{0.1, 0.3, 0.6, 1.0};
    return cosines;
}

double error_floor(const LayerSolution& solution, Side side) {
    // Not straight on in a narrow peak: 1 % of that is more than all the rest.
    std::vector<double> azimuths{pi / 2, pi};
    if (std::ranges::none_of(
            list_phase_functions(solution.stack ? solution.stack->layers : StackLayers{},
                                 solution.phase_function, {}),
            has_narrow_peak))
        azimuths.insert(azimuths.begin(), 0);
    std::vector<int> at;
    for (const double mu : floor_cosines()) {
        const auto found = std::find(solution.mu.begin(), solution.mu.end(), mu);
        if (found != solution.mu.end()) at.push_back(static_cast<int>(found - solution.mu.begin()));
    }
    double max = 0;
    for (std::size_t i = 0; i < at.size(); ++i)
        for (std::size_t j = i; j < at.size(); ++j)  // both are symmetric
            for (const SolvedValue& value : solution.values(side, at[i], at[j], azimuths))
                max = std::max(max, value.total);
    return std::max(0.01 * max, min_value);
}

namespace {

/// How many of some samples are at least a share of them.
std::size_t count_of(const std::vector<ErrorSample>& samples, double share) {
    constexpr double rounding = 1e-12;
    return static_cast<std::size_t>(
        std::ceil(share * static_cast<double>(samples.size()) * (1 - rounding)));
}

/// True where at least a share of the errors is within a tolerance.
bool are_within(const std::vector<ErrorSample>& some, double tolerance, double share) {
    const auto count = std::count_if(some.begin(), some.end(), [&](const ErrorSample& sample) {
        return sample.error <= tolerance;
    });
    return static_cast<std::size_t>(count) >= count_of(some, share);
}

}  // namespace

double error_quantile(std::vector<ErrorSample>& samples, double share) {
    if (samples.empty()) return 0;
    std::ranges::sort(samples, {}, &ErrorSample::error);
    return samples[std::max<std::size_t>(1, count_of(samples, share)) - 1].error;
}

bool is_peaked(const PhaseFunction& phase_function) { return phase_function(1.0) >= 40; }

int reference_nodes(int nodes) { return std::min(512, nodes + std::max(8, nodes / 2)); }

bool Verification::meets_between_peaks(double tolerance) const {
    return are_within(samples, tolerance, 0.999) &&
           (samples.empty() || samples.back().error <= largest_over_tolerance * tolerance);
}

bool Verification::meets_at_peaks(double tolerance) const {
    return (!judges_forward || are_within(forward, tolerance, 0.99)) &&
           (!judges_grazing || are_within(grazing, tolerance, 0.99));
}

namespace {

/// Largest |1 - plane albedo - diffuse and direct transmittance| where the table has w = 1; -1
/// where it has not, not all orders, or a lower boundary that absorbs the rest.
double energy_defect(const Table& table) {
    const AxisView w = table.albedo.view(), tau = table.optical_depth.view();
    if (table.albedo.values.back() != 1 || table.plane_albedo.empty() || table.highest_order > 0 ||
        table.lower_boundary.is_present())
        return -1;
    double worst = 0;
    const std::size_t mus = table.mu_in.values.size();
    const auto albedos = size(w.count);
    const auto depths = size(tau.size());
    for (std::size_t m = 0; m < table.member_count(); ++m)
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

/// Views a table that is packed, or whose samples may be in files.
TableView checked_view(const Table& table, const VerifyOptions& options) {
    if (options.packed) return options.packed->view();
    TableView view = table.view();
    if (options.files == nullptr) return view;
    if (view.has_reflection())
        view.reflection_multiple = options.files->samples(Side::reflection).data();
    if (view.has_transmission())
        view.transmission_multiple = options.files->samples(Side::transmission).data();
    return view;
}

/// The furnace_defect of a Verification, of one member.
double furnace_defect(const Table& table, std::size_t member, const VerifyOptions& options) {
    const TableView all = checked_view(table, options);
    const TableView view = all.at(member_at(table.family, member));
    if (!view.has_reflection() || table.plane_albedo.empty() || !view.has_all_directions())
        return -1;
    const Directions outgoing = gauss_directions(48, NodeMap::grazing);
    const int azimuths = 96;
    double worst = 0;
    const auto mus = table.mu_in.values.size();
    const std::size_t depths = table.optical_depth.values.size();
    const std::size_t first_albedo = member * table.albedo.values.size();
    for (std::size_t w : {std::size_t{0}, table.albedo.values.size() - 1})
        for (std::size_t d = 0; d < depths; d += std::max<std::size_t>(1, depths / 6)) {
            if (options.files) options.files->release();
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
        }
    return worst;
}

/// A table at the points of its family, one after the other: to choose one takes long, and the
/// samples of a ladder share it.
class ChosenView {
  public:
    explicit ChosenView(const TableView& table) : table_(table), chosen_(table) {}

    const TableView& at(const FamilyPoint& member) {
        for (std::size_t k = 0; k < member.size(); ++k)
            if (chosen_.chosen.size() == 0 || chosen_.chosen[k] != member[k]) {
                chosen_ = table_.at(member);
                break;
            }
        return chosen_;
    }

  private:
    const TableView& table_;
    TableView chosen_;
};

/// found(sample) is what a lookup says.
template <class Found>
void compare(std::span<ErrorSample> samples, const Found& found) {
    for (ErrorSample& at : samples) {
        at.found = found(at);
        at.error = std::abs(at.found - at.expected) / std::max(at.expected, at.floor);
    }
}

}  // namespace

void look_up(const TableView& table, std::span<ErrorSample> samples) {
    ChosenView chosen(table);
    compare(samples, [&](const ErrorSample& at) {
        return scattering(chosen.at(at.member), at.side, at.albedo, at.optical_depth, at.geometry)
            .total();
    });
}

namespace {

/// Through slices, one bound at every point.
void look_up_bound(const TableView& table, std::span<ErrorSample> samples) {
    ChosenView chosen(table);
    compare(samples, [&](const ErrorSample& at) {
        Effects effects;
        effects.reflection = at.side == Side::reflection;
        effects.transmission = !effects.reflection;
        effects.background = false;
        const Slice slice = bind(chosen.at(at.member), at.optical_depth, at.albedo, effects);
        const auto mu_in = static_cast<float>(at.geometry.mu_in);
        const auto mu_out = static_cast<float>(at.geometry.mu_out);
        const auto azimuth = static_cast<float>(at.geometry.azimuth);
        return double{effects.reflection ? slice.reflection(mu_in, mu_out, azimuth)
                                         : slice.transmission(mu_in, mu_out, azimuth)};
    });
}

/// Few points at a time: threads share them, and what samples in files bring into memory is let go.
void look_up_by_few(const TableView& view, std::span<ErrorSample> all,
                    const VerifyOptions& options) {
    constexpr std::size_t at_once = 64;
    const auto parts = static_cast<int>((all.size() + at_once - 1) / at_once);
    parallel_for(parts, options.threads, [&](int part) {
        const std::size_t first = size(part) * at_once;
        (options.bound ? look_up_bound : look_up)(
            view, all.subspan(first, std::min(at_once, all.size() - first)));
        if (options.files) options.files->release();
    });
}

}  // namespace

SolverOptions reference_solver(const Table& table, int nodes) {
    SolverOptions solver;
    solver.nodes = reference_nodes(nodes);
    solver.orders = table.highest_order;
    // Without azimuths a table holds means over them.
    if (table.azimuth.values == std::vector{0.0}) solver.modes = 1;
    solver.exact_fluxes = false;
    solver.mode_tolerance = 1e-3 * table.tolerance;
    return solver;
}

Verification verify(const Table& table, const VerifyOptions& options) {
    require(options.samples >= 1, "verify", "samples", ">= 1", options.samples);
    const auto stored = table.attributes.find("nodes");
    const int nodes =
        stored == table.attributes.end() ? 32 : std::max(1, std::atoi(stored->second.c_str()));
    const SolverOptions solver = reference_solver(table, nodes);
    Verification result;
    result.reference_nodes = solver.nodes;
    const TableView view = checked_view(table, options);
    const PointRange range = point_range(table, view);
    result.judges_forward =
        table.lower_boundary.law == nullptr || has_peak(table.phase_function, range);
    result.judges_grazing = result.judges_forward && table.path_law == nullptr;
    std::vector<ErrorSample> all =
        solve_random_points(table.phase_function, range, solver, options);
    if (!is_first_rank(options.log)) return result;
    look_up_by_few(view, all, options);
    error_quantile(all, 1);  // sorts
    for (const ErrorSample& sample : all)
        (sample.kind == PointKind::even      ? result.samples
         : sample.kind == PointKind::forward ? result.forward
                                             : result.grazing)
            .push_back(sample);
    if (!options.fluxes) return result;
    result.energy_defect = energy_defect(table);
    result.furnace_defect = furnace_defect(table, 0, options);
    if (table.has_family())
        result.furnace_defect = std::max(result.furnace_defect,
                                         furnace_defect(table, table.member_count() - 1, options));
    return result;
}

}  // namespace stratus
