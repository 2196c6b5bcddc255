#include "solved_samples.h"

#include <stratus/bake/axes.h>
#include <stratus/base/argument.h>
#include <stratus/transfer/stack.h>

#include "piece_of_work.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <string>
#include <utility>

namespace stratus {
namespace {

constexpr std::array<Side, 2> both_sides{Side::reflection, Side::transmission};

template <class Number>
std::vector<char> as_chars(const std::vector<Number>& numbers) {
    const std::span<const char> bytes = byte_span(numbers);
    return {bytes.begin(), bytes.end()};
}

template <class Number>
std::vector<Number> as_numbers(const std::vector<char>& bytes) {
    std::vector<Number> numbers(bytes.size() / sizeof(Number));
    if (!numbers.empty()) std::memcpy(numbers.data(), bytes.data(), bytes.size());
    return numbers;
}

}  // namespace

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
    const std::size_t layers =
        table_.member_count() * table_.albedo.values.size() * table_.optical_depth.values.size();
    const std::size_t mus = table_.mu_in.values.size();
    table_.reflection_multiple.resize(sides_[0] ? 1 : 0);
    table_.transmission_multiple.resize(sides_[1] ? 1 : 0);
    table_.spherical_albedo.resize(layers);
    // Who asks for fluxes asks for those along the direction of view, too.
    if (is_narrow(units_.recipe().mu_in, all_cosines)) return;
    table_.plane_albedo.resize(layers * mus);
    if (sides_[1]) table_.diffuse_transmittance.resize(layers * mus);
}

bool SolvedSamples::is_first_rank() const { return stratus::is_first_rank(options_.log); }

int SolvedSamples::in_full(std::vector<int> layers, const Use& use) {
    layers = as_numbers<int>(shared(options_.log, as_chars(layers)));
    if (layers.empty()) return 0;
    DirectionList all(numbers_.count());
    std::iota(all.begin(), all.end(), std::size_t{0});
    const auto is_asked_for = [&](int layer) {
        return std::ranges::find(layers, layer) != layers.end();
    };
    solve("in full", units_.holding(layers), is_asked_for, {all, all}, use);
    return static_cast<int>(layers.size());
}

void SolvedSamples::at(const std::array<DirectionList, 2>& directions, const Use& use) {
    std::array<DirectionList, 2> same;
    for (std::size_t n = 0; n < 2; ++n)
        same[n] = as_numbers<std::size_t>(shared(options_.log, as_chars(directions[n])));
    if (same[0].empty() && same[1].empty()) return;
    solve(
        "baking", units_.all(), [](int) { return true; }, same, use);
}

void SolvedSamples::solve(const std::string& stage, const std::vector<Unit>& units,
                          const Choice& is_asked_for,
                          const std::array<DirectionList, 2>& directions, const Use& use) {
    const std::array<std::vector<std::size_t>, 2> positions{numbers_.positions(directions[0]),
                                                            numbers_.positions(directions[1])};
    const auto unit = [&](int piece) -> const Unit& {
        return units[static_cast<std::size_t>(piece)];
    };
    const std::string request = "request " + std::to_string(requests_++) + ", ";
    Pieces pieces;
    pieces.count = static_cast<int>(units.size());
    pieces.name = [&](int piece) { return request + units_.unit_name(unit(piece)); };
    pieces.solve = [&](int piece) { return solve_unit(unit(piece), is_asked_for, positions); };
    pieces.take = [&](int piece, std::span<const char> result) {
        take(unit(piece), is_asked_for, directions, result, use);
    };
    if (options_.progress) pieces.progress = [&](double done) { options_.progress(done, stage); };
    solve_pieces(pieces, options_.log, options_.threads);
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
std::vector<char> SolvedSamples::solve_unit(
    const Unit& unit, const Choice& is_asked_for,
    const std::array<std::vector<std::size_t>, 2>& positions) const {
    std::vector<SolvedLayer> layers = units_.solve(unit);
    std::erase_if(layers, [&](const SolvedLayer& layer) { return !is_asked_for(layer.number); });
    std::vector<const LayerSolution*> solutions;
    for (const SolvedLayer& layer : layers) solutions.push_back(&layer.solution);
    const DirectionGrid& grid = units_.grid(unit.member);
    std::array<std::vector<std::vector<double>>, 2> samples;  // of each layer
    for (std::size_t n = 0; n < 2; ++n)
        if (sides_[n] && positions[n].size() < numbers_.count())
            samples[n] = evaluate_tabulated(solutions, both_sides[n], grid, positions[n]);
    std::vector<float> numbers;
    for (std::size_t l = 0; l < layers.size(); ++l) {
        for (std::size_t n = 0; n < 2; ++n) {
            if (!sides_[n]) continue;
            if (!samples[n].empty()) {
                numbers.insert(numbers.end(), samples[n][l].begin(), samples[n][l].end());
                continue;
            }
            const std::vector<double> all = evaluate_tabulated(*solutions[l], both_sides[n], grid);
            for (const std::size_t at : positions[n])
                numbers.push_back(static_cast<float>(all[at]));
        }
        const std::vector<float> fluxes = flux_values(layers[l].solution);
        numbers.insert(numbers.end(), fluxes.begin(), fluxes.end());
    }
    return as_chars(numbers);
}

template <class Visit>
void SolvedSamples::for_each_flux(int layer, const Visit& visit) {
    const std::size_t mus = table_.mu_in.values.size(), at = static_cast<std::size_t>(layer);
    visit(std::span(table_.spherical_albedo).subspan(at, 1));
    for (std::vector<float>* const flux : {&table_.plane_albedo, &table_.diffuse_transmittance})
        if (!flux->empty()) visit(std::span(*flux).subspan(at * mus, mus));
}

void SolvedSamples::take(const Unit& unit, const Choice& is_asked_for,
                         const std::array<DirectionList, 2>& directions,
                         std::span<const char> result, const Use& use) {
    std::vector<int> layers = units_.unit_layers(unit);
    std::erase_if(layers, [&](int layer) { return !is_asked_for(layer); });
    std::size_t of_layer = table_.is_stack() ? 1 : 0;
    for (std::size_t n = 0; n < 2; ++n) of_layer += sides_[n] ? directions[n].size() : 0;
    for_each_flux(0, [&](std::span<float> flux) { of_layer += flux.size(); });
    const std::vector<float> numbers =
        numbers_in<float>(result, units_.unit_name(unit), of_layer * layers.size());
    auto next = numbers.begin();
    for (const int layer : layers) {
        for (std::size_t n = 0; n < 2; ++n) {
            if (!sides_[n]) continue;
            const auto end = next + static_cast<std::ptrdiff_t>(directions[n].size());
            require(std::all_of(next, end, [](float sample) { return std::isfinite(sample); }),
                    "bake", "samples", "finite", "others");
            use(layer, both_sides[n], {next, end});
            next = end;
        }
        for_each_flux(layer, [&](std::span<float> flux) {
            std::copy_n(next, flux.size(), flux.begin());
            next += static_cast<std::ptrdiff_t>(flux.size());
        });
        if (table_.is_stack()) table_.spherical_albedo_below = double{*next++};
    }
}

}  // namespace stratus
