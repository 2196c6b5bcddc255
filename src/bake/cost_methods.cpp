#include "cost_methods.h"

#include <stratus/bake/clock.h>
#include <stratus/base/constants.h>
#include <stratus/transfer/reference/markov.h>
#include <stratus/transfer/reference/photons.h>
#include <stratus/transfer/solve.h>

#include "cost_layers.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <variant>

namespace stratus {

namespace {

using Kind = CostPoint::Kind;

/// Beyond the first few sizes none is begun that would take longer: what a study of a few minutes
/// can spare.
constexpr std::size_t first_few = 3;
constexpr double longest_seconds = 0.25;

/// Draws of photons, whose errors are judged together.
constexpr int most_draws = 4;

// ---- References

/// One layer at twelve geometries, and what the solver finds there.
class ReferenceLayer {
  public:
    ReferenceLayer(const Recipe& recipe, double optical_depth, int nodes)
        : recipe_(recipe), optical_depth_(optical_depth) {
        mu_.insert(mu_.end(), {0.2, 0.9});
        SolverOptions solver = solver_of(recipe);
        solver.nodes = nodes;
        const LayerSolution solution =
            solve_layer(recipe.phase_function, recipe.albedo.max, optical_depth, mu_, solver);
        for (const int in : {1, 5})
            for (const int out : {2, 3, 4})
                for (const double azimuth : {0.6, 2.5}) {
                    places_.push_back({in, out, azimuth});
                    geometries_.push_back({mu_[static_cast<std::size_t>(in)],
                                           mu_[static_cast<std::size_t>(out)], azimuth});
                }
        const double floors[] = {reflection_floor(solution), transmission_floor(solution)};
        for (const Place& at : places_) {
            expected_.total.push_back(solution.reflection(at.in, at.out, at.azimuth).total);
            expected_.total.push_back(solution.transmission(at.in, at.out, at.azimuth).total);
            expected_.floor.insert(expected_.floor.end(), floors, floors + 2);
        }
    }

    CostPoint by_markov(int sublayers, int nodes) const {
        MarkovOptions options;
        options.sublayers = sublayers;
        options.nodes = nodes;
        CostPoint point = begun("sublayers");
        point.sublayers = sublayers;
        point.solver.nodes = nodes;
        const double started = processor_seconds();
        const MarkovSolution solution =
            solve_markov(recipe_.phase_function, recipe_.albedo.max, optical_depth_, mu_, options);
        point.solve_seconds = processor_seconds() - started;
        std::vector<double> found;
        for (const Place& at : places_) {
            found.push_back(solution.reflection(at.in, at.out, at.azimuth).value.total);
            found.push_back(solution.transmission(at.in, at.out, at.azimuth).value.total);
        }
        set_errors(point, errors_of({found, expected_.floor}, expected_));
        return point;
    }

    /// Mean time, and the errors of all draws.
    CostPoint by_photons(double photons, int draws) const {
        PhotonOptions options;
        options.photons = static_cast<std::uint64_t>(photons);
        options.backward_collisions = is_peaked(recipe_.phase_function) ? 8 : 0;
        CostPoint point = begun("photons");
        point.photons = photons;
        point.solver.nodes = 0;
        std::vector<double> errors;
        for (int draw = 0; draw < draws; ++draw) {
            options.seed = static_cast<std::uint64_t>(1 + draw);
            const double started = processor_seconds();
            const PhotonSolution solution = solve_photons(
                recipe_.phase_function, recipe_.albedo.max, optical_depth_, geometries_, options);
            point.solve_seconds += (processor_seconds() - started) / draws;
            std::vector<double> found;
            for (const PhotonGeometry& at : solution.geometries) {
                found.push_back(at.reflection.value.total);
                found.push_back(at.transmission.value.total);
            }
            const std::vector<double> of_draw = errors_of({found, expected_.floor}, expected_);
            errors.insert(errors.end(), of_draw.begin(), of_draw.end());
        }
        set_errors(point, std::move(errors));
        return point;
    }

  private:
    struct Place {
        int in, out;  // in mu_
        double azimuth;
    };

    static CostPoint begun(const char* varied) {
        CostPoint point;
        point.kind = Kind::reference;
        point.varied = varied;
        return point;
    }

    const Recipe& recipe_;
    const double optical_depth_;
    std::vector<double> mu_ = floor_cosines();
    std::vector<Place> places_;
    std::vector<Geometry> geometries_;
    CostLayers::Values expected_;
};

/// Sizes in turn, each of which takes `growth` times as long as the one before, as far as time
/// reaches.
template <class Size>
void add_sizes(std::vector<CostPoint>& points, const CostBudget& budget,
               const std::vector<Size>& sizes, double growth,
               const std::function<CostPoint(Size)>& measure) {
    const std::size_t before = points.size();
    double last = 0;
    for (const Size size : sizes) {
        const double ahead = growth * last;
        if (points.size() - before >= first_few && ahead > longest_seconds) break;
        if (!budget.is_time_left(share_of_references, ahead)) break;
        budget.show("references");
        points.push_back(measure(size));
        last = points.back().solve_seconds;
    }
}

}  // namespace

std::vector<CostPoint> measure_references(const Recipe& recipe, const CostBudget& budget,
                                          int reference_nodes) {
    std::vector<CostPoint> points;
    const Range depth = recipe.optical_depth;
    if (recipe.orders != 0 || recipe.lower_boundary.is_present() || std::isinf(depth.min) ||
        !budget.is_time_left(share_of_references))
        return points;
    const double deepest = std::isinf(depth.max) ? std::max(depth.min, 64.0) : depth.max;
    const ReferenceLayer layer(recipe, deepest, reference_nodes);
    constexpr int nodes = 16;
    const int draws = std::min(most_draws, budget.rounds());
    add_sizes<int>(points, budget, {4, 8, 16, 32, 64}, 8,
                   [&](int sublayers) { return layer.by_markov(sublayers, nodes); });
    add_sizes<double>(points, budget, {500, 2000, 8000, 32000, 128000, 512000}, 4,
                      [&](double photons) { return layer.by_photons(photons, draws); });
    return points;
}

std::vector<CostPoint> measure_droplets(const Recipe& recipe, const CostBudget& budget) {
    std::vector<CostPoint> points;
    const auto& terms = recipe.phase_function.terms();
    const Mie* const mie = terms.size() == 1 ? std::get_if<Mie>(&terms[0].second) : nullptr;
    if (mie == nullptr) return points;
    constexpr int reference = 96;
    for (const double times : {0.25, 0.5, 1.0, 2.0, 4.0}) {
        const Droplets droplets = scaled(mie->droplets, times);
        Recipe of_size = recipe;
        of_size.albedo.min = of_size.albedo.max;
        try {
            of_size.phase_function = PhaseFunction(Mie(droplets));
        } catch (const std::invalid_argument& beyond) {
            budget.say(beyond.what());
            continue;
        }
        const CostLayers layers(of_size, budget.threads());
        SolverOptions solver = solver_of(recipe);
        solver.nodes = reference;
        if (!budget.is_time_left(share_of_droplets)) break;
        budget.show("droplets");
        const CostLayers::Values expected = layers.values(layers.solve(solver));
        for (const int nodes : {16, 24, 32, 48}) {
            if (!budget.is_time_left(share_of_droplets)) break;
            CostPoint point;
            point.kind = Kind::droplets;
            point.varied = "radius";
            point.size_parameter = 2 * pi * effective_size(droplets).radius / droplets.wavelength;
            point.solver = solver;
            point.solver.nodes = nodes;
            set_errors(point, errors_of(layers.values(layers.solve(point.solver)), expected));
            point.solve_seconds = layers.time_solve(point.solver);
            points.push_back(point);
        }
    }
    return points;
}

}  // namespace stratus
