#include "solved_samples.h"

#include <stratus/bake/axes.h>
#include <stratus/base/argument.h>
#include <stratus/io/write_options.h>
#include <stratus/transfer/stack.h>

#include "piece_of_work.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace stratus {

SolvedSamples::SolvedSamples(const Recipe& resolved, const BakeOptions& options, Table& table)
    : units_(resolved),
      options_(options),
      table_(table = units_.header()),
      numbers_(table_.view()),
      sides_{resolved.reflection, resolved.transmission} {
    make_room();
    prepare_header(table_);
    table_.phase_curve = PhaseCurve(table_.phase_function);
}

void SolvedSamples::make_room() {
    const std::size_t layers = table_.layer_count(), mus = table_.mu_in.values.size();
    table_.reflection_multiple.resize(sides_.reflection ? 1 : 0);
    table_.transmission_multiple.resize(sides_.transmission ? 1 : 0);
    table_.spherical_albedo.resize(layers);
    // Who asks for fluxes asks for those along the direction of view, too.
    if (is_narrow(units_.recipe().mu_in, all_cosines)) return;
    table_.plane_albedo.resize(layers * mus);
    // Between depths and albedos it may be looked up only where T was asked for.
    const bool is_clear_stack = table_.is_stack() && !table_.lower_boundary.is_present() &&
                                std::isfinite(table_.optical_depth.values[0]);
    if (sides_.transmission || is_clear_stack) table_.diffuse_transmittance.resize(layers * mus);
}

bool SolvedSamples::is_first_rank() const { return stratus::is_first_rank(options_.log); }

int SolvedSamples::in_full(std::vector<int> layers, const Use& use) {
    layers = as_numbers<int>(shared(options_.log, as_chars(layers)));
    if (layers.empty()) return 0;
    const DirectionList all = numbers_.all();
    const auto is_asked_for = [&](int layer) {
        return std::ranges::find(layers, layer) != layers.end();
    };
    solve("in full", units_.holding(layers), is_asked_for, {all, all}, use);
    return int_size(layers);
}

void SolvedSamples::at(const PerSide<DirectionList>& directions, const Use& use) {
    PerSide<DirectionList> same;
    for (const Side side : both_sides)
        same[side] = as_numbers<std::size_t>(shared(options_.log, as_chars(directions[side])));
    if (same.reflection.empty() && same.transmission.empty()) return;
    solve(
        "baking", units_.all(), [](int) { return true; }, same, use);
}

void trim_memory() {
#ifdef __GLIBC__
    // The first call sets glibc's allocator up where another serves the program, and no two threads may do so at once.
    [[maybe_unused]] static const auto first = mallinfo2();
    constexpr std::size_t little = 32 << 20;
    if (mallinfo2().fordblks > little) malloc_trim(0);
#endif
}

void SolvedSamples::trim_memory() { stratus::trim_memory(); }

void SolvedSamples::solve(const std::string& stage, const std::vector<Unit>& units,
                          const Choice& is_asked_for, const PerSide<DirectionList>& directions,
                          const Use& use) {
    const PerSide<std::vector<std::size_t>> positions{numbers_.positions(directions.reflection),
                                                      numbers_.positions(directions.transmission)};
    std::vector<SomePositions> some(table_.member_count());
    for (const Side side : both_sides)
        for (std::size_t m = 0; m < some.size() && positions[side].size() < numbers_.count(); ++m)
            some[m][side] = std::make_unique<GridPositions>(units_.grid(m), side, positions[side]);
    const auto unit = [&](int piece) -> const Unit& { return units[size(piece)]; };
    const std::string request = "request " + std::to_string(requests_++) + ", ";
    Pieces pieces;
    pieces.count = int_size(units);
    pieces.name = [&](int piece) { return request + units_.unit_name(unit(piece)); };
    pieces.solve = [&](int piece) {
        return solve_unit(unit(piece), is_asked_for, positions, some[unit(piece).member]);
    };
    pieces.take = [&](int piece, std::span<const char> result) {
        take(unit(piece), is_asked_for, directions, result, use);
    };
    if (options_.progress) pieces.progress = [&](double done) { options_.progress(done, stage); };
    trim_memory();
    solve_pieces(pieces, options_.log, options_.threads);
    trim_memory();
}

std::vector<float> SolvedSamples::flux_values(const LayerSolution& solution) const {
    std::vector<float> fluxes{static_cast<float>(solution.spherical_albedo)};
    const std::size_t mus = table_.mu_in.values.size();
    const auto add = [&](const Eigen::VectorXd& flux) {
        for (std::size_t i = 0; i < mus; ++i)
            fluxes.push_back(static_cast<float>(flux(static_cast<Eigen::Index>(i))));
    };
    if (!table_.plane_albedo.empty()) add(solution.plane_albedo);
    if (!table_.diffuse_transmittance.empty()) add(solution.diffuse_transmittance);
    if (table_.is_stack())
        fluxes.push_back(static_cast<float>(solution.stack->spherical_albedo_below));
    return fluxes;
}

/// Layer by layer: the samples of either side, then its fluxes.
std::vector<char> SolvedSamples::solve_unit(const Unit& unit, const Choice& is_asked_for,
                                            const PerSide<std::vector<std::size_t>>& positions,
                                            const SomePositions& some) const {
    // A side's modes are summed where few of its samples are asked for, and dropped where it has none.
    std::vector<SolvedLayer> layers = units_.solve(
        unit, [&](ModeSolution& solution, Side side, int number, const AzimuthalMode& mode) {
            if (some[side]) some[side]->add_mode(solution, number, mode);
            return some[side] || !sides_[side];
        });
    std::erase_if(layers, [&](const SolvedLayer& layer) { return !is_asked_for(layer.number); });
    std::vector<const LayerSolution*> solutions;
    for (const SolvedLayer& layer : layers) solutions.push_back(&layer.solution);
    const DirectionGrid& grid = units_.grid(unit.member);
    PerSide<std::vector<std::vector<double>>> samples;  // of each layer
    for (const Side side : both_sides)
        if (sides_[side] && some[side]) samples[side] = some[side]->evaluate_tabulated(solutions);
    std::vector<float> numbers;
    for (std::size_t l = 0; l < layers.size(); ++l) {
        for (const Side side : both_sides) {
            if (!sides_[side]) continue;
            if (!samples[side].empty()) {
                numbers.insert(numbers.end(), samples[side][l].begin(), samples[side][l].end());
                continue;
            }
            const std::vector<double> all = evaluate_tabulated(*solutions[l], side, grid);
            for (const std::size_t at : positions[side])
                numbers.push_back(static_cast<float>(all[at]));
        }
        const std::vector<float> fluxes = flux_values(layers[l].solution);
        numbers.insert(numbers.end(), fluxes.begin(), fluxes.end());
    }
    return as_chars(numbers);
}

template <class Visit>
void SolvedSamples::for_each_flux(int layer, const Visit& visit) {
    const std::size_t mus = table_.mu_in.values.size(), at = size(layer);
    visit(std::span(table_.spherical_albedo).subspan(at, 1));
    for (std::vector<float>* const flux : {&table_.plane_albedo, &table_.diffuse_transmittance})
        if (!flux->empty()) visit(std::span(*flux).subspan(at * mus, mus));
}

void SolvedSamples::take(const Unit& unit, const Choice& is_asked_for,
                         const PerSide<DirectionList>& directions, std::span<const char> result,
                         const Use& use) {
    std::vector<int> layers = units_.unit_layers(unit);
    std::erase_if(layers, [&](int layer) { return !is_asked_for(layer); });
    std::size_t of_layer = table_.is_stack() ? 1 : 0;
    for (const Side side : both_sides) of_layer += sides_[side] ? directions[side].size() : 0;
    for_each_flux(0, [&](std::span<float> flux) { of_layer += flux.size(); });
    const std::vector<float> numbers =
        numbers_in<float>(result, units_.unit_name(unit), of_layer * layers.size());
    auto next = numbers.begin();
    for (const int layer : layers) {
        for (const Side side : both_sides) {
            if (!sides_[side]) continue;
            const auto end = next + static_cast<std::ptrdiff_t>(directions[side].size());
            require(std::all_of(next, end, [](float sample) { return std::isfinite(sample); }),
                    "bake", "samples", "finite", "others");
            use(layer, side, {next, end});
            next = end;
        }
        for_each_flux(layer, [&](std::span<float> flux) {
            std::copy_n(next, flux.size(), flux.begin());
            next += static_cast<std::ptrdiff_t>(flux.size());
        });
        if (table_.is_stack()) table_.spherical_albedo_below = double{*next++};
    }
}

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

    float operator()(float sample) const {
        if (drop_ == 0) return sample;
        auto bits = std::bit_cast<std::uint32_t>(sample);
        bits = (bits + (1u << (drop_ - 1))) & ~((1u << drop_) - 1);
        return std::bit_cast<float>(bits);
    }

  private:
    int drop_ = 0;
};

/// Resizes in parts, between which the log may stop the work: a system takes seconds to grant gigabytes.
void resize_until_stopped(std::vector<float>& samples, std::size_t count, const WorkLog& log) {
    constexpr std::size_t part = 16 << 20;
    samples.reserve(count);
    while (samples.size() < count) {
        stop_if_asked(log);
        samples.resize(std::min(count, samples.size() + part));
    }
}

}  // namespace

Table solve_table(const Recipe& resolved, const BakeOptions& options) {
    Table table;
    SolvedSamples samples(resolved, options, table);
    const bool is_first = samples.is_first_rank();
    const std::size_t in_layer = table.sample_count() / table.spherical_albedo.size(),
                      outs = table.mu_out.values.size(), azimuths = table.azimuth.values.size();
    const PerSide<std::vector<float>*> multiple{&table.reflection_multiple,
                                                &table.transmission_multiple};
    PerSide<std::size_t> counts;
    for (const Side side : both_sides)
        counts[side] = multiple[side]->empty() ? 0 : table.sample_count();
    const bool is_filed = is_first && options.samples && options.samples->make_room(counts);
    for (const Side side : both_sides)
        if (is_first && !is_filed) resize_until_stopped(*multiple[side], counts[side], options.log);

    const DirectionNumbers numbers(table.view());
    const DirectionList all = numbers.all();
    const std::vector<std::size_t> positions = numbers.positions(all);
    const Rounding rounded(resolved.tolerance);
    samples.at({all, all}, [&](int layer, Side side, const std::vector<float>& found) {
        std::vector<float> whole(in_layer);
        for (std::size_t n = 0; n < found.size(); ++n) {
            const std::size_t at = positions[n], pair = at / azimuths;
            const float sample = rounded(found[n]);
            whole[at] = sample;
            if (numbers.is_symmetric())
                whole[(pair % outs * outs + pair / outs) * azimuths + at % azimuths] = sample;
        }
        const std::size_t first = size(layer) * in_layer;
        if (is_filed)
            options.samples->write(side, first, whole);
        else
            std::ranges::copy(whole, multiple[side]->begin() + static_cast<std::ptrdiff_t>(first));
    });
    if (is_first && !is_filed) prepare(table);
    return table;
}

}  // namespace stratus
