// Solves every sample of a resolved recipe.
#include "solve_table.h"

#include <stratus/bake/bake.h>
#include <stratus/bake/clock.h>
#include <stratus/base/argument.h>
#include <stratus/io/sample_files.h>
#include <stratus/transfer/fourier_sum.h>
#include <stratus/transfer/stack.h>

#include "axes.h"
#include "family_section.h"
#include "piece_of_work.h"
#include "solve_material.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <numeric>
#include <span>
#include <utility>

namespace stratus {

namespace {

/// Albedos that one run of the solver works on at once. Eight fill its registers mode by mode; where
/// modes are many four do as well with two modes at a time, and fewer lanes idle in the last run.
std::size_t albedos_at_once(int modes) { return modes >= 16 ? 4 : 8; }

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
        const auto unit = [&](int piece) { return units[static_cast<std::size_t>(piece)]; };
        Pieces pieces;
        pieces.count = static_cast<int>(units.size());
        pieces.name = [&](int piece) { return name_of(unit(piece)); };
        pieces.solve = [&](int piece) { return solve_unit(unit(piece)); };
        pieces.take = [&](int piece, std::span<const char> result) { store(unit(piece), result); };
        if (options_.progress)
            pieces.progress = [&](double done) { options_.progress(done, "baking"); };
        solve_pieces(pieces, options_.log, options_.threads);
        table_.spherical_albedo_below = double{spherical_albedo_below_};
        return std::move(table_);
    }

    /// Seconds that the units take one thread, from those of the first of the nearest timed member:
    /// the ends and the middle, for members take very different times.
    std::vector<double> unit_seconds() const {
        const std::vector<Unit> units = divide_work();
        const std::size_t units_of_member = units.size() / members_.size(),
                          last = members_.size() - 1;
        std::map<std::size_t, double> of_member;  // seconds a layer
        for (const std::size_t member : {std::size_t{0}, last / 2, last})
            if (of_member.count(member) == 0)
                of_member[member] = layer_seconds(units[member * units_of_member]);
        std::vector<double> of_unit;
        for (const Unit& unit : units) {
            const auto distance = [&](const auto& timed) {
                return timed.first < unit.member ? unit.member - timed.first
                                                 : timed.first - unit.member;
            };
            const auto nearest = std::ranges::min_element(of_member, {}, distance);
            of_unit.push_back(nearest->second * layers_of(unit));
        }
        return of_unit;
    }

    double layers_of(const Unit& unit) const {
        return std::max(1.0, static_cast<double>(unit.albedo_count) * ladder_of(unit).octaves);
    }

    /// Seconds that one thread takes for a layer of a unit, timed.
    double layer_seconds(const Unit& unit) const {
        // Few albedos, of which the modes alone fill the registers.
        Unit timed = unit;
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
        return (processor_seconds() - started) / layers_of(timed);
    }

    /// Floating-point operations of all units, at most: doubling one mode of one albedo takes about
    /// 8 n^3 of them, and every unit begins some twenty doublings below its first depth.
    double flops() const {
        constexpr double of_doubling = 8, before_first = 20;
        double doublings = 0;
        for (const Unit& unit : divide_work())
            doublings +=
                static_cast<double>(unit.albedo_count) * (before_first + ladder_of(unit).octaves);
        const Discretisation& d = recipe_.discretisation;
        return of_doubling * std::pow(d.nodes, 3) * d.modes * doublings;
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
        if (mixture_of(recipe_) != nullptr)
            table_.second_phase_function = recipe_.second_phase_function;
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
        const bool is_first = is_first_rank(options_.log);
        const std::array<std::size_t, 2> counts{recipe_.reflection ? rows * block_ : 0,
                                                recipe_.transmission ? rows * block_ : 0};
        is_filed_ = is_first && options_.samples && options_.samples->make_room(counts);
        // One sample stands for those that are elsewhere.
        const bool has_samples = is_first && !is_filed_;
        const auto own = [&](std::size_t count) {
            return has_samples ? count : std::min<std::size_t>(1, count);
        };
        table_.reflection_multiple.resize(own(counts[0]));
        table_.transmission_multiple.resize(own(counts[1]));
        if (!is_first) return;
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
        const std::size_t at_once = albedos_at_once(recipe_.discretisation.modes);
        std::vector<Unit> units;
        for (std::size_t member = 0; member < members_.size(); ++member)
            for (std::size_t first = 0; first < albedos; first += at_once)
                for (int run = 0; run < runs(); ++run)
                    units.push_back({member, run, first, std::min(at_once, albedos - first)});
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

    // ---- results of units ----------------------------------------------------------------------

    /// All samples of a row of the table; empty where the table has none.
    struct Row {
        std::span<float> sides[2];   // reflection, transmission
        std::span<float> fluxes[2];  // plane albedo, diffuse transmittance
        std::span<float> spherical_albedo, spherical_albedo_below;
    };

    std::string name_of(const Unit& unit) const {
        const std::string piece = "depths from " + std::to_string(unit.run) + ", albedos " +
                                  std::to_string(unit.first_albedo) + " to " +
                                  std::to_string(unit.first_albedo + unit.albedo_count - 1);
        return table_.has_family() ? "member " + std::to_string(unit.member) + ", " + piece : piece;
    }

    /// The samples of all its rows, as `visit_samples` comes by them.
    std::vector<char> solve_unit(const Unit& unit) const {
        std::vector<float> room;
        const Row row = row_in(room);
        std::vector<char> samples;
        samples.reserve(room.size() * sizeof(float) * rows_of(unit, ladder_of(unit)).size());
        for (const auto& of_albedo : solutions_of(unit))
            for (const LayerSolution& solution : of_albedo) {
                fill(row, solution, grids_[unit.member]);
                visit_samples(row, [&](std::span<const float> some) {
                    const auto bytes = std::as_bytes(some);
                    const char* const first = reinterpret_cast<const char*>(bytes.data());
                    samples.insert(samples.end(), first, first + bytes.size());
                });
            }
        return samples;
    }

    /// Puts the samples of a unit into the table.
    void store(const Unit& unit, std::span<const char> samples) {
        const std::vector<std::size_t> rows = rows_of(unit, ladder_of(unit));
        std::vector<float> room(is_filed_ ? 2 * block_ : 0);
        std::size_t count = 0;
        for (const std::size_t row : rows)
            visit_samples(row_of_table(row, room),
                          [&](std::span<float> some) { count += some.size(); });
        check_size<float>(samples, name_of(unit), count);
        for (const std::size_t at : rows) {
            const Row row = row_of_table(at, room);
            visit_samples(row, [&](std::span<float> some) {
                std::memcpy(some.data(), samples.data(), some.size_bytes());
                samples = samples.subspan(some.size_bytes());
            });
            mirror(row);
            if (is_filed_) file(row, at);
        }
    }

    void file(const Row& row, std::size_t at) {
        for (const Side side : {Side::reflection, Side::transmission}) {
            const std::span<const float> samples = row.sides[side == Side::reflection ? 0 : 1];
            for (const float sample : samples)
                require(std::isfinite(sample), "solve_table", "a sample", "finite", sample);
            if (!samples.empty()) options_.samples->write(side, at * block_, samples);
        }
    }

    /// With its sides in `room` where the table's are in files.
    Row row_of_table(std::size_t row, std::span<float> room) {
        const std::size_t mus = table_.mu_in.values.size();
        const auto part = [&](std::vector<float>& all, std::size_t size) {
            return all.empty() ? std::span<float>{} : std::span(all).subspan(row * size, size);
        };
        const auto side = [&](std::vector<float>& all, std::size_t n) {
            if (!is_filed_) return part(all, block_);
            return all.empty() ? std::span<float>{} : room.subspan(n * block_, block_);
        };
        return {{side(table_.reflection_multiple, 0), side(table_.transmission_multiple, 1)},
                {part(table_.plane_albedo, mus), part(table_.diffuse_transmittance, mus)},
                part(table_.spherical_albedo, 1),
                std::span(&spherical_albedo_below_, 1)};
    }

    /// A row of its own, in `room`.
    Row row_in(std::vector<float>& room) const {
        const std::size_t mus = table_.mu_in.values.size();
        const bool has_fluxes = !is_narrow(recipe_.mu_in, all_cosines);
        std::size_t used = 0;
        const auto part = [&](bool exists, std::size_t size) {
            const std::size_t first = std::exchange(used, used + (exists ? size : 0));
            return std::span(room).subspan(first, used - first);
        };
        room.assign(2 * (block_ + mus + 1), 0);
        return {{part(recipe_.reflection, block_), part(recipe_.transmission, block_)},
                {part(has_fluxes, mus), part(has_fluxes && recipe_.transmission, mus)},
                part(true, 1),
                part(true, 1)};
    }

    /// Calls visit(samples) for those of a row from which `mirror` fills in the rest.
    template <class Visit>
    void visit_samples(const Row& row, const Visit& visit) const {
        const std::size_t mus = table_.mu_in.values.size();
        for (const std::span<float> side : row.sides)
            for (std::size_t i = 0; i < mus && !side.empty(); ++i) {
                const std::size_t begin = pairs_.are_symmetric()
                                              ? i * (mus + 1) * block_ / (mus * mus)
                                              : i * block_ / mus;
                visit(side.subspan(begin, (i + 1) * block_ / mus - begin));
            }
        for (const std::span<float> flux : row.fluxes)
            if (!flux.empty()) visit(flux);
        visit(row.spherical_albedo);
        if (table_.is_stack()) visit(row.spherical_albedo_below);
    }

    /// Fills in the samples with mu_in and mu_out exchanged.
    void mirror(const Row& row) const {
        if (!pairs_.are_symmetric()) return;
        const std::size_t mus = table_.mu_in.values.size(), azimuths = table_.azimuth.values.size();
        for (const std::span<float> side : row.sides) {
            if (side.empty()) continue;
            float* const block = side.data();
            for (std::size_t i = 0; i < mus; ++i)
                for (std::size_t j = 0; j < i; ++j)
                    std::copy_n(block + (j * mus + i) * azimuths, azimuths,
                                block + (i * mus + j) * azimuths);
        }
    }

    void fill(const Row& row, const LayerSolution& solution, const DirectionGrid& grid) const {
        for (const Side side : {Side::reflection, Side::transmission}) {
            const std::span<float> out = row.sides[side == Side::reflection ? 0 : 1];
            if (out.empty()) continue;
            const std::vector<double> samples = evaluate_tabulated(solution, side, grid);
            std::transform(samples.begin(), samples.end(), out.begin(), rounded_);
        }
        const Eigen::VectorXd* const fluxes[] = {&solution.plane_albedo,
                                                 &solution.diffuse_transmittance};
        for (std::size_t n = 0; n < 2; ++n)
            for (std::size_t i = 0; i < row.fluxes[n].size(); ++i)
                row.fluxes[n][i] = static_cast<float>((*fluxes[n])(static_cast<Eigen::Index>(i)));
        row.spherical_albedo[0] = static_cast<float>(solution.spherical_albedo);
        if (solution.stack)
            row.spherical_albedo_below[0] =
                static_cast<float>(solution.stack->spherical_albedo_below);
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
    bool is_filed_ = false;             // the samples of both sides are in files
};

}  // namespace

PredictedUnits predict_units(const Recipe& resolved) {
    const BakeOptions alone;
    const TableSolver solver(resolved, alone);
    return {solver.unit_seconds(), solver.flops()};
}

Table solve_table(const Recipe& resolved, const BakeOptions& options) {
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
    const Recipe decided = with_path_law_decided(resolved);
    Table table = TableSolver(decided, options).solve();
    if (!is_first_rank(options.log)) return table;
    if (options.samples && options.samples->has_room()) {
        prepare_header(table);
        table.phase_curve = PhaseCurve(table.phase_function);
    } else {
        prepare(table);
    }
    return table;
}

}  // namespace stratus
