// Solves every sample of a resolved recipe.
#include <stratus/bake/axes.h>
#include <stratus/bake/bake.h>
#include <stratus/base/argument.h>
#include <stratus/io/sample_files.h>
#include <stratus/transfer/fourier_sum.h>
#include <stratus/transfer/stack.h>

#include "piece_of_work.h"
#include "table_units.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

namespace stratus {

namespace {

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

class TableSolver {
  public:
    TableSolver(const Recipe& recipe, const BakeOptions& options)
        : units_(recipe),
          recipe_(units_.recipe()),
          options_(options),
          rounded_(recipe.tolerance),
          table_(units_.header()) {}

    Table solve() {
        make_room();
        const std::vector<Unit> units = units_.all();
        const auto unit = [&](int piece) -> const Unit& {
            return units[static_cast<std::size_t>(piece)];
        };
        Pieces pieces;
        pieces.count = static_cast<int>(units.size());
        pieces.name = [&](int piece) { return units_.unit_name(unit(piece)); };
        pieces.solve = [&](int piece) { return solve_unit(unit(piece)); };
        pieces.take = [&](int piece, std::span<const char> result) { store(unit(piece), result); };
        if (options_.progress)
            pieces.progress = [&](double done) { options_.progress(done, "baking"); };
        solve_pieces(pieces, options_.log, options_.threads);
        table_.spherical_albedo_below = double{spherical_albedo_below_};
        return std::move(table_);
    }

  private:
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

    // ---- results of units ----------------------------------------------------------------------

    /// All samples of a row of the table; empty where the table has none.
    struct Row {
        std::span<float> sides[2];   // reflection, transmission
        std::span<float> fluxes[2];  // plane albedo, diffuse transmittance
        std::span<float> spherical_albedo, spherical_albedo_below;
    };

    /// The samples of all its rows, as `visit_samples` comes by them.
    std::vector<char> solve_unit(const Unit& unit) const {
        std::vector<float> room;
        const Row row = row_in(room);
        std::vector<char> samples;
        samples.reserve(room.size() * sizeof(float) * units_.unit_layers(unit).size());
        for (const SolvedLayer& layer : units_.solve(unit)) {
            fill(row, layer.solution, units_.grid(unit.member));
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
        const std::vector<int> rows = units_.unit_layers(unit);
        std::vector<float> room(is_filed_ ? 2 * block_ : 0);
        std::size_t count = 0;
        for (const int row : rows)
            visit_samples(row_of_table(static_cast<std::size_t>(row), room),
                          [&](std::span<float> some) { count += some.size(); });
        check_size<float>(samples, units_.unit_name(unit), count);
        for (const int layer : rows) {
            const auto at = static_cast<std::size_t>(layer);
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
                const std::size_t begin = units_.are_pairs_symmetric()
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
        if (!units_.are_pairs_symmetric()) return;
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

    const TableUnits units_;
    const Recipe& recipe_;
    const BakeOptions& options_;
    const Rounding rounded_;
    Table table_;
    std::size_t block_ = 0;             // samples of one row
    float spherical_albedo_below_ = 0;  // of a stack
    bool is_filed_ = false;             // the samples of both sides are in files
};

}  // namespace

Table solve_table(const Recipe& resolved, const BakeOptions& options) {
    Table table = TableSolver(resolved, options).solve();
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
