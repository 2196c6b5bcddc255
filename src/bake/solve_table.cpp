// Solves every sample of a resolved recipe.
#include "solve_table.h"

#include <stratus/bake/bake.h>
#include <stratus/bake/parallel.h>
#include <stratus/runtime/argument.h>
#include <stratus/transfer/fourier_sum.h>
#include <stratus/transfer/stack.h>

#include "axes.h"
#include "piece_of_work.h"
#include "solve_material.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>

namespace stratus {

namespace {

/// Albedos that one run of the solver works on at once.
constexpr int albedos_at_once = 8;

/// Drops the last bits of samples, which the tolerance does not need, so that files compress well;
/// costs a thousandth of the tolerance.
class Rounding {
  public:
    explicit Rounding(double tolerance) {
        constexpr int mantissa_bits = 23;
        const int needed = static_cast<int>(std::ceil(-std::log2(tolerance / 500)));
        drop_ = std::max(0, mantissa_bits - needed);
    }

    float operator()(double sample) const {
        if (drop_ == 0) return static_cast<float>(sample);
        auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(sample));
        bits = (bits + (1u << (drop_ - 1))) & ~((1u << drop_) - 1);
        return std::bit_cast<float>(bits);
    }

  private:
    int drop_ = 0;
};

/// What is solved at once, on one thread: some albedos at the depths of one run of doubling.
struct Unit {
    std::size_t member;
    int run;  // samples run, run + runs, run + 2 runs, ... of optical depth
    std::size_t first_albedo, albedo_count;
};

class TableSolver {
  public:
    TableSolver(const Recipe& recipe, const BakeOptions& options)
        : recipe_(recipe), options_(options), rounded_(recipe.tolerance) {
        place_axes();
        table_.path_law = path_law_of(recipe);
        for (std::size_t m = 0; m < table_.member_count(); ++m) {
            members_.push_back(at_member(recipe, member_at(table_.family, m)));
            const Recipe& member = members_.back();
            const std::vector<double> exponents = decay_exponents(member, table_.albedo.values);
            table_.extrapolation_lengths.push_back(
                extrapolation_length(member.phase_function, member.lower_boundary));
            table_.diffusion_exponent.insert(table_.diffusion_exponent.end(), exponents.begin(),
                                             exponents.end());
            grids_.emplace_back(member.phase_function, member.lower_boundary, mu_,
                                table_.azimuth.values, recipe.discretisation.modes,
                                path_law_of(member), pairs_);
        }
    }

    Table solve() {
        make_room();
        const std::vector<Unit> units = divide_work();
        const auto count = static_cast<int>(units.size());
        parallel_for(
            count, options_.threads,
            [&](int unit) {
                stop_if_asked(options_.log);
                solve_unit(units[static_cast<std::size_t>(unit)]);
            },
            [&](int done) {
                if (options_.progress)
                    options_.progress(static_cast<double>(done) / count, "baking");
            });
        table_.spherical_albedo_below = double{spherical_albedo_below_};
        return std::move(table_);
    }

    /// Seconds that `solve` takes, from those of one unit.
    double predicted_seconds(int threads) const {
        const std::vector<Unit> units = divide_work();
        const auto layers_of = [&](const Unit& unit) {
            return static_cast<double>(unit.albedo_count) * ladder_of(unit).octaves;
        };
        // Few albedos, of which the modes alone fill the registers.
        Unit timed = units.front();
        const int modes = recipe_.discretisation.modes;
        timed.albedo_count = std::min<std::size_t>(timed.albedo_count, modes >= 32   ? 1
                                                                       : modes >= 16 ? 2
                                                                       : modes >= 8  ? 4
                                                                                     : 8);
        const double started = processor_seconds();
        for (const auto& of_albedo : solutions_of(timed))
            for (const LayerSolution& solution : of_albedo)
                for (const Side side : {Side::reflection, Side::transmission})
                    if (side == Side::reflection ? recipe_.reflection : recipe_.transmission)
                        evaluate_tabulated(solution, side, grids_[timed.member]);
        const double seconds = processor_seconds() - started;
        double layers = 0;
        for (const Unit& unit : units) layers += layers_of(unit);
        // The last units leave threads idle.
        return seconds * std::max(1.0, layers / std::max(1.0, layers_of(timed)) / threads);
    }

  private:
    void place_axes() {
        const Discretisation& d = recipe_.discretisation;
        table_.phase_function = recipe_.phase_function;
        table_.lower_boundary = recipe_.lower_boundary;
        table_.layers = recipe_.layers;
        table_.highest_order = recipe_.orders;
        table_.extrapolation_length =
            extrapolation_length(recipe_.phase_function, recipe_.lower_boundary);
        table_.family = family_axes(recipe_);
        if (mixture_of(recipe_) != nullptr) {
            table_.second_phase_function = recipe_.second_phase_function;
            table_.second_extrapolation_length =
                extrapolation_length(recipe_.second_phase_function, recipe_.lower_boundary);
        }
        table_.albedo = albedo_axis(recipe_.albedo, d.albedo_samples, d.albedo_scale);
        table_.optical_depth = optical_depth_axis(recipe_.optical_depth,
                                                  std::max(1, d.optical_depth_samples_per_octave),
                                                  d.deepest_optical_depth);
        DirectionAxes directions = direction_axes(recipe_);
        table_.mu_in = std::move(directions.mu_in);
        table_.mu_out = std::move(directions.mu_out);
        table_.azimuth = std::move(directions.azimuth);
        place_cosines();
    }

    /// The cosines to be solved at: those along both axes, once where they are the same.
    void place_cosines() {
        mu_ = table_.mu_in.values;
        pairs_.in.resize(mu_.size());
        std::iota(pairs_.in.begin(), pairs_.in.end(), 0);
        pairs_.out = pairs_.in;
        pairs_.exchangeable = recipe_.layers.empty();
        if (table_.mu_out.values == mu_) return;
        pairs_.out.resize(table_.mu_out.values.size());
        std::iota(pairs_.out.begin(), pairs_.out.end(), static_cast<int>(mu_.size()));
        mu_.insert(mu_.end(), table_.mu_out.values.begin(), table_.mu_out.values.end());
    }

    void make_room() {
        const std::size_t rows = table_.member_count() * table_.albedo.values.size() *
                                 table_.optical_depth.values.size();
        const std::size_t mus = table_.mu_in.values.size();
        block_ = mus * table_.mu_out.values.size() * table_.azimuth.values.size();
        if (recipe_.reflection) table_.reflection_multiple.resize(rows * block_);
        if (recipe_.transmission) table_.transmission_multiple.resize(rows * block_);
        table_.spherical_albedo.resize(rows);
        // Who asks for fluxes asks for those along the direction of view, too.
        if (is_narrow(recipe_.mu_in, all_cosines)) return;
        table_.plane_albedo.resize(rows * mus);
        if (recipe_.transmission) table_.diffuse_transmittance.resize(rows * mus);
    }

    /// One run of doubling serves all octaves: as many runs as samples an octave.
    int runs() const {
        const int depths = table_.optical_depth.view().count;
        const int per_octave = std::max(1, recipe_.discretisation.optical_depth_samples_per_octave);
        return depths == 0 ? 1 : std::min(per_octave, depths);
    }

    std::vector<Unit> divide_work() const {
        const std::size_t albedos = table_.albedo.values.size();
        std::vector<Unit> units;
        for (std::size_t member = 0; member < members_.size(); ++member)
            for (std::size_t first = 0; first < albedos; first += albedos_at_once)
                for (int run = 0; run < runs(); ++run)
                    units.push_back({member, run, first,
                                     std::min<std::size_t>(albedos_at_once, albedos - first)});
        return units;
    }

    DepthLadder ladder_of(const Unit& unit) const {
        const AxisView tau = table_.optical_depth.view();
        if (tau.count == 0) return {1, 0, tau.ends_at_infinity};
        return {table_.optical_depth.values[static_cast<std::size_t>(unit.run)],
                (tau.count - 1 - unit.run) / runs() + 1,
                tau.ends_at_infinity && unit.run == (tau.count - 1) % runs()};
    }

    std::vector<std::vector<LayerSolution>> solutions_of(const Unit& unit) const {
        const auto first =
            table_.albedo.values.begin() + static_cast<std::ptrdiff_t>(unit.first_albedo);
        return solve_material(recipe_.layers, members_[unit.member].phase_function,
                              {first, first + static_cast<std::ptrdiff_t>(unit.albedo_count)},
                              ladder_of(unit), mu_, solver_options(recipe_),
                              recipe_.lower_boundary);
    }

    /// Rows of the table, a row an (albedo, optical depth), in the order in which they are solved.
    std::vector<std::size_t> rows_of(const Unit& unit, const DepthLadder& ladder) const {
        const std::size_t albedos = table_.albedo.values.size();
        const std::size_t depths = table_.optical_depth.values.size();
        std::vector<std::size_t> rows;
        for (std::size_t a = 0; a < unit.albedo_count; ++a) {
            const std::size_t first = (unit.member * albedos + unit.first_albedo + a) * depths;
            for (int d = 0; d < ladder.octaves; ++d)
                rows.push_back(first + static_cast<std::size_t>(unit.run + d * runs()));
            if (ladder.to_infinity) rows.push_back(first + depths - 1);
        }
        return rows;
    }

    void solve_unit(const Unit& unit) {
        const DepthLadder ladder = ladder_of(unit);
        const std::vector<std::size_t> rows = rows_of(unit, ladder);
        std::string piece = "depths from " + std::to_string(unit.run) + ", albedos from " +
                            std::to_string(unit.first_albedo);
        if (table_.has_family()) piece = "member " + std::to_string(unit.member) + ", " + piece;
        if (take_finished(piece, rows)) return;
        const auto solutions = solutions_of(unit);
        const std::size_t depths = rows.size() / unit.albedo_count;
        for (std::size_t n = 0; n < rows.size(); ++n)
            store(solutions[n / depths][n % depths], grids_[unit.member], rows[n]);
        keep(piece, rows);
    }

    // ---- the log -------------------------------------------------------------------------------

    bool take_finished(const std::string& piece, const std::vector<std::size_t>& rows) {
        std::size_t count = 0;
        for (const std::size_t row : rows)
            visit_samples(row, [&](std::span<float> some) { count += some.size(); });
        const auto finished = find_finished<float>(options_.log, piece, count);
        if (!finished) return false;
        const float* from = finished->data();
        for (const std::size_t row : rows) {
            visit_samples(row, [&](std::span<float> some) {
                std::copy_n(from, some.size(), some.data());
                from += some.size();
            });
            mirror(row);
        }
        return true;
    }

    void keep(const std::string& piece, const std::vector<std::size_t>& rows) {
        if (!options_.log.keep) return;
        std::vector<float> samples;
        for (const std::size_t row : rows)
            visit_samples(row, [&](std::span<float> some) {
                samples.insert(samples.end(), some.begin(), some.end());
            });
        keep_finished(options_.log, piece, samples);
    }

    /// Calls visit(samples) for those of one row from which `mirror` fills in the rest.
    template <class Visit>
    void visit_samples(std::size_t row, const Visit& visit) {
        const std::size_t mus = table_.mu_in.values.size();
        for (std::vector<float>* side :
             {&table_.reflection_multiple, &table_.transmission_multiple})
            for (std::size_t i = 0; i < mus && !side->empty(); ++i) {
                const std::size_t begin = pairs_.are_symmetric()
                                              ? i * (mus + 1) * block_ / (mus * mus)
                                              : i * block_ / mus;
                visit(
                    std::span(*side).subspan(row * block_ + begin, (i + 1) * block_ / mus - begin));
            }
        for (std::vector<float>* flux : {&table_.plane_albedo, &table_.diffuse_transmittance})
            if (!flux->empty()) visit(std::span(*flux).subspan(row * mus, mus));
        visit(std::span(table_.spherical_albedo).subspan(row, 1));
        if (table_.is_stack()) visit(std::span(&spherical_albedo_below_, 1));
    }

    /// Fills in the samples with mu_in and mu_out exchanged.
    void mirror(std::size_t row) {
        if (!pairs_.are_symmetric()) return;
        const std::size_t mus = table_.mu_in.values.size(), azimuths = table_.azimuth.values.size();
        for (std::vector<float>* side :
             {&table_.reflection_multiple, &table_.transmission_multiple}) {
            if (side->empty()) continue;
            float* const block = side->data() + row * block_;
            for (std::size_t i = 0; i < mus; ++i)
                for (std::size_t j = 0; j < i; ++j)
                    std::copy_n(block + (j * mus + i) * azimuths, azimuths,
                                block + (i * mus + j) * azimuths);
        }
    }

    // ---- samples -------------------------------------------------------------------------------

    void store(const LayerSolution& solution, const DirectionGrid& grid, std::size_t row) {
        const std::size_t mus = table_.mu_in.values.size();
        if (recipe_.reflection)
            store_side(solution, Side::reflection, grid,
                       table_.reflection_multiple.data() + row * block_);
        if (recipe_.transmission)
            store_side(solution, Side::transmission, grid,
                       table_.transmission_multiple.data() + row * block_);
        for (std::size_t i = 0; i < mus; ++i) {
            const auto at = static_cast<Eigen::Index>(i);
            if (!table_.plane_albedo.empty())
                table_.plane_albedo[row * mus + i] = static_cast<float>(solution.plane_albedo(at));
            if (!table_.diffuse_transmittance.empty())
                table_.diffuse_transmittance[row * mus + i] =
                    static_cast<float>(solution.diffuse_transmittance(at));
        }
        table_.spherical_albedo[row] = static_cast<float>(solution.spherical_albedo);
        if (solution.stack)
            spherical_albedo_below_ = static_cast<float>(solution.stack->spherical_albedo_below);
    }

    void store_side(const LayerSolution& solution, Side side, const DirectionGrid& grid,
                    float* out) const {
        const std::vector<double> samples = evaluate_tabulated(solution, side, grid);
        std::transform(samples.begin(), samples.end(), out, rounded_);
    }

    const Recipe& recipe_;
    const BakeOptions& options_;
    const Rounding rounded_;
    Table table_;
    std::vector<Recipe> members_;       // one where the recipe has no family
    std::vector<DirectionGrid> grids_;  // of each member
    std::vector<double> mu_;            // of solutions
    CosinePairs pairs_;                 // of them, along the table's axes
    std::size_t block_ = 0;             // samples of one row
    float spherical_albedo_below_ = 0;  // of a stack
};

}  // namespace

double predicted_seconds(const Recipe& resolved, int threads) {
    return TableSolver(resolved, {}).predicted_seconds(threads);
}

Table solve_table(const Recipe& resolved, const BakeOptions& options) {
    const Discretisation& d = resolved.discretisation;
    std::vector<std::pair<const char*, int>> choices{{"nodes", d.nodes},
                                                     {"modes", d.modes},
                                                     {"mu_samples", d.mu_samples},
                                                     {"azimuth_samples", d.azimuth_samples},
                                                     {"albedo_samples", d.albedo_samples}};
    for (std::size_t k = 0; k < resolved.family.size(); ++k)
        if (resolved.family[k].values.empty())
            choices.push_back({parameter_name(resolved.family[k].parameter), d.family_samples[k]});
    for (const auto& [name, count] : choices)
        require(count >= 1, "solve_table", name, "resolved", count);
    check_directions(resolved);
    Table table = TableSolver(resolved, options).solve();
    prepare(table);
    return table;
}

}  // namespace stratus
