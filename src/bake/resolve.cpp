// Choosing nodes, modes and samples by measuring what each costs in accuracy.
//
// All measurements are made on one set of probes: directions between grazing and normal, a few
// azimuths, albedos over the range, every octave of depth (and infinity). Errors are relative as in
// accuracy.h; a choice stands when 99.9 % of the probes are within its share of the tolerance.
#include "resolve.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include <stratus/bake/accuracy.h>
#include <stratus/bake/parallel.h>
#include <stratus/runtime/diffusion.h>

#include "axes.h"

namespace stratus {

namespace {

constexpr double pi = std::numbers::pi;
constexpr double infinity = std::numeric_limits<double>::infinity();

using Solutions = std::vector<std::vector<LayerSolution>>;  // [albedo][depth]

/// Errors of many probes, and what of them a choice is judged by.
class Errors {
  public:
    void add(double error) { errors_.push_back(error); }
    void add(const Errors& more) {
        errors_.insert(errors_.end(), more.errors_.begin(), more.errors_.end());
    }
    double quantile(double share = 0.999) {
        if (errors_.empty()) return 0;
        const auto at = errors_.begin() + static_cast<std::ptrdiff_t>(
                                              share * static_cast<double>(errors_.size() - 1));
        std::nth_element(errors_.begin(), at, errors_.end());
        return *at;
    }

  private:
    std::vector<double> errors_;
};

std::string percent(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2g", value);
    return text;
}

class Resolver {
  public:
    Resolver(const Recipe& recipe, double strictness, const BakeOptions& options)
        : recipe_(recipe), options_(options), share_(recipe.tolerance * strictness) {
        const double deepest_s = std::sqrt(1 - recipe.albedo.min),
                     shallow_s = std::sqrt(1 - recipe.albedo.max);
        for (double at : {0.0, 0.04, 0.15, 0.4, 0.75, 1.0}) {
            const double s = shallow_s + at * (deepest_s - shallow_s);
            albedos_.push_back(std::clamp(1 - s * s, recipe.albedo.min, recipe.albedo.max));
            if (recipe.albedo.min == recipe.albedo.max) break;
        }
        for (double mu : floor_cosines()) mu_.push_back(mu);
        for (double x : {0.035, 0.11, 0.18, 0.25, 0.39, 0.46, 0.61, 0.68, 0.86, 0.93})
            mu_.push_back(x * x);
    }

    Recipe resolve() {
        Discretisation& d = recipe_.discretisation;
        solver_.scheme = d.scheme;
        solver_.mode_tolerance = 1e-3 * recipe_.tolerance;
        choose_depth_range();
        choose_nodes();
        choose_modes();
        choose_mu_samples();
        choose_azimuth_samples();
        choose_deepest();
        choose_optical_depth_samples();
        choose_albedo_samples();
        return recipe_;
    }

  private:
    // ---- what is compared ----------------------------------------------------------------------

    /// Calls visit(value(solution), floor) for both sides that the recipe has.
    template <class Visit>
    void for_sides(const LayerSolution& at, Visit visit) const {
        if (recipe_.reflection)
            visit([](const LayerSolution& s, int i, int j,
                     double phi) { return s.reflection(i, j, phi); },
                  reflection_floor(at), Side::reflection);
        if (recipe_.transmission && !std::isinf(at.optical_depth))
            visit([](const LayerSolution& s, int i, int j,
                     double phi) { return s.transmission(i, j, phi); },
                  transmission_floor(at), Side::transmission);
    }

    /// Calls visit(i, j) for all pairs of probe cosines.
    template <class Visit>
    void for_pairs(Visit visit) const {
        for (int i = 0; i < static_cast<int>(mu_.size()); ++i)
            for (int j = i; j < static_cast<int>(mu_.size()); ++j) visit(i, j);
    }

    template <class Measure>
    double measure_cells(const Solutions& solutions, Measure measure) const {
        const int depths = static_cast<int>(solutions[0].size());
        const int cells = static_cast<int>(solutions.size()) * depths;
        std::vector<Errors> of_cell(static_cast<std::size_t>(cells));
        parallel_for(cells, options_.threads, [&](int cell) {
            measure(static_cast<std::size_t>(cell / depths),
                    static_cast<std::size_t>(cell % depths),
                    of_cell[static_cast<std::size_t>(cell)]);
        });
        Errors all;
        for (const Errors& errors : of_cell) all.add(errors);
        return all.quantile();
    }

    // ---- solving the probes --------------------------------------------------------------------

    Solutions solve(const std::vector<double>& albedos, const std::vector<double>& mu,
                    const DepthLadder& ladder, const SolverOptions& solver) const {
        // Eight albedos fill the lanes of a pack; few albedos are split so that no thread is idle.
        const std::size_t chunk = albedos.size() >= 16 ? 8 : 1;
        const int chunks = static_cast<int>((albedos.size() + chunk - 1) / chunk);
        Solutions result(albedos.size());
        parallel_for(chunks, options_.threads, [&](int c) {
            const std::size_t first = static_cast<std::size_t>(c) * chunk;
            const std::size_t last = std::min(albedos.size(), first + chunk);
            auto part = solve_ladder(recipe_.phase_function,
                                     {albedos.begin() + static_cast<std::ptrdiff_t>(first),
                                      albedos.begin() + static_cast<std::ptrdiff_t>(last)},
                                     ladder, mu, solver);
            for (std::size_t a = first; a < last; ++a) result[a] = std::move(part[a - first]);
        });
        return result;
    }

    void choose_depth_range() {
        const Range range = recipe_.optical_depth;
        if (std::isinf(range.min)) {
            ladder_ = {1, 0, true};
            return;
        }
        // Infinite tables are probed to where the diffusion law has long taken over.
        const double reduced = 1 - recipe_.phase_function.asymmetry();
        const double highest =
            std::isinf(range.max) ? std::max(range.min, 200 / reduced) : range.max;
        const int octaves = static_cast<int>(std::floor(std::log2(highest / range.min) + 1e-9));
        ladder_ = {std::isinf(range.max) ? range.min : std::ldexp(range.max, -octaves), octaves + 1,
                   std::isinf(range.max)};
    }

    // ---- the choices ---------------------------------------------------------------------------

    /// First of the ascending candidates whose error is within the share, by bisection; the last if
    /// none is.
    template <class Measure>
    int choose(const char* what, const std::vector<int>& candidates, Measure measure) const {
        std::size_t low = 0, high = candidates.size() - 1;
        double error = measure(candidates[high]);
        while (low < high) {
            const std::size_t middle = (low + high) / 2;
            const double at_middle = measure(candidates[middle]);
            if (at_middle <= share_) {
                high = middle;
                error = at_middle;
            } else {
                low = middle + 1;
            }
        }
        say(what, candidates[high], error, "interpolation misses");
        return candidates[high];
    }

    void say(const std::string& what, int value, double error, const char* of) const {
        if (!options_.note) return;
        options_.note(what + " " + std::to_string(value) + ": " + of + " " + percent(error) +
                      " (99.9 % of probes)");
    }

    void choose_nodes() {
        int& nodes = recipe_.discretisation.nodes;
        if (nodes) {
            solver_.nodes = nodes;
            probes_ = solve(albedos_, mu_, ladder_, solver_);
            return;
        }
        const int candidates[] = {4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 80};
        for (int candidate : candidates) {
            solver_.nodes = candidate;
            Solutions finer = solve(albedos_, mu_, ladder_, solver_);
            if (!probes_.empty()) {
                const double error = nodes_error(probes_, finer);
                if (error <= 0.2 * share_ || candidate == candidates[std::size(candidates) - 1]) {
                    say("nodes", nodes, error, "more nodes change");
                    break;
                }
            }
            nodes = candidate;
            probes_ = std::move(finer);
        }
        solver_.nodes = nodes;
    }

    double nodes_error(const Solutions& coarse, const Solutions& fine) const {
        return measure_cells(fine, [&](std::size_t a, std::size_t d, Errors& errors) {
            for_sides(fine[a][d], [&](auto value, double floor, Side) {
                for_pairs([&](int i, int j) {
                    for (double phi : azimuths_) {
                        const double expected = value(fine[a][d], i, j, phi).total;
                        errors.add(std::abs(value(coarse[a][d], i, j, phi).total - expected) /
                                   std::max(expected, floor));
                    }
                });
            });
        });
    }

    /// Modes from which on all others together stay below a twentieth of the share.
    void choose_modes() {
        int& modes = recipe_.discretisation.modes;
        if (!modes) {
            const int all = static_cast<int>(probes_[0][0].reflection_modes.size());
            double error = 0;
            int low = 1, high = all;
            while (low < high) {
                const int middle = (low + high) / 2;
                const double tail = modes_error(middle);
                if (tail <= 0.05 * share_) {
                    high = middle;
                    error = tail;
                } else {
                    low = middle + 1;
                }
            }
            modes = high;
            say("modes", modes, error, "all higher ones add");
        }
        solver_.modes = modes;
    }

    double modes_error(int kept) const {
        return measure_cells(probes_, [&](std::size_t a, std::size_t d, Errors& errors) {
            const LayerSolution& solution = probes_[a][d];
            for_sides(solution, [&](auto value, double floor, Side side) {
                const auto& modes = side == Side::reflection ? solution.reflection_modes
                                                             : solution.transmission_modes;
                for_pairs([&](int i, int j) {
                    double tail = 0;
                    for (auto m = static_cast<std::size_t>(kept); m < modes.size(); ++m)
                        tail += 2 * std::abs(modes[m](i, j));
                    errors.add(tail / std::max(value(solution, i, j, pi / 2).total, floor));
                });
            });
        });
    }

    void choose_mu_samples() {
        int& samples = recipe_.discretisation.mu_samples;
        if (!samples)
            samples = choose("mu_samples",
                             {8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32, 36, 40, 48, 56},
                             [&](int candidate) { return mu_error(candidate); });
    }

    double mu_error(int samples) const {
        const AxisView axis = mu_axis(samples).view();
        std::vector<double> mu = mu_;
        for (double sample : mu_axis(samples).values) mu.push_back(sample);
        const Solutions solutions = solve(albedos_, mu, ladder_, solver_);
        const int offset = static_cast<int>(mu_.size());
        return measure_cells(solutions, [&](std::size_t a, std::size_t d, Errors& errors) {
            const LayerSolution& solution = solutions[a][d];
            for_sides(solution, [&](auto value, double floor, Side) {
                for_pairs([&](int i, int j) {
                    const Stencil in = axis.stencil(mu_[static_cast<std::size_t>(i)]);
                    const Stencil out = axis.stencil(mu_[static_cast<std::size_t>(j)]);
                    const double tau = solution.optical_depth;
                    const double scale = intercepted_share(tau, mu[static_cast<std::size_t>(i)]) *
                                         intercepted_share(tau, mu[static_cast<std::size_t>(j)]);
                    auto intercepted = [&](int sample) {
                        return intercepted_share(tau,
                                                 mu[static_cast<std::size_t>(offset + sample)]);
                    };
                    for (double phi : azimuths_) {
                        const SolvedValue expected = value(solution, i, j, phi);
                        double found = 0;
                        for (int p = 0; p < 4; ++p)
                            for (int q = 0; q < 4; ++q)
                                found += scale /
                                         (intercepted(in.first + p) * intercepted(out.first + q)) *
                                         in.weight[p] * out.weight[q] *
                                         value(solution, offset + in.first + p,
                                               offset + out.first + q, phi)
                                             .multiple;
                        errors.add(std::abs(found - expected.multiple) /
                                   std::max(expected.total, floor));
                    }
                });
            });
        });
    }

    void choose_azimuth_samples() {
        int& samples = recipe_.discretisation.azimuth_samples;
        if (samples) return;
        if (recipe_.discretisation.modes == 1 && recipe_.phase_function.is_isotropic()) {
            samples = 1;
            return;
        }
        samples = choose("azimuth_samples",
                         {5, 7, 9, 11, 13, 15, 17, 19, 21, 25, 29, 33, 37, 41, 49, 57, 65, 81, 97},
                         [&](int candidate) { return azimuth_error(candidate); });
    }

    double azimuth_error(int samples) const {
        const Axis axis = azimuth_axis(samples);
        const AxisView view = axis.view();
        return measure_cells(probes_, [&](std::size_t a, std::size_t d, Errors& errors) {
            const LayerSolution& solution = probes_[a][d];
            for_sides(solution, [&](auto value, double floor, Side) {
                for_pairs([&](int i, int j) {
                    for (int n = 0; n < 16; ++n) {
                        const double phi = pi * (n + 0.4) / 16;
                        const Stencil at = view.stencil(phi);
                        const SolvedValue expected = value(solution, i, j, phi);
                        double found = 0;
                        for (int p = 0; p < 4; ++p)
                            found += at.weight[p] *
                                     value(solution, i, j,
                                           axis.values[static_cast<std::size_t>(at.first + p)])
                                         .multiple;
                        errors.add(std::abs(found - expected.multiple) /
                                   std::max(expected.total, floor));
                    }
                });
            });
        });
    }

    /// First depth of the ladder beyond which the diffusion law bridges the way to infinity.
    void choose_deepest() {
        double& deepest = recipe_.discretisation.deepest_optical_depth;
        if (!ladder_.to_infinity || ladder_.octaves == 0 || deepest) return;
        double error = 0;
        std::size_t last = 0;
        for (; last + 2 < static_cast<std::size_t>(ladder_.octaves); ++last) {
            error = infinity_error(last);
            if (error <= share_) break;
        }
        deepest = std::ldexp(ladder_.first, static_cast<int>(last));
        if (options_.note)
            options_.note("deepest finite optical_depth " + percent(deepest) +
                          ": beyond it the diffusion law misses " + percent(error) +
                          " (99.9 % of probes)");
    }

    double infinity_error(std::size_t last) const {
        const double q = extrapolation_length(recipe_.phase_function);
        return measure_cells(probes_, [&](std::size_t a, std::size_t d, Errors& errors) {
            const LayerSolution &at = probes_[a][d], &from = probes_[a][last],
                                &limit = probes_[a].back();
            if (d <= last || std::isinf(at.optical_depth)) return;
            const double k = exponent(albedos_[a]);
            const double tau = at.optical_depth, tau_last = from.optical_depth;
            const double left = reflection_deficit(tau_last, k, q);
            const double share = left > 0 ? reflection_deficit(tau, k, q) / left : 0;
            const double passed = transmission_scale(tau_last, k, q);
            const double fall = passed > 1e-35 ? transmission_scale(tau, k, q) / passed : 0;
            for_sides(at, [&](auto value, double floor, Side side) {
                for_pairs([&](int i, int j) {
                    for (double phi : azimuths_) {
                        const SolvedValue expected = value(at, i, j, phi);
                        const double near = value(from, i, j, phi).multiple;
                        const double far = value(limit, i, j, phi).multiple;
                        const double found =
                            side == Side::reflection ? far + share * (near - far) : fall * near;
                        errors.add(std::abs(found - expected.multiple) /
                                   std::max(expected.total, floor));
                    }
                });
            });
        });
    }

    /// Depths at `fine` steps an octave; a candidate's own samples are every (fine / candidate)-th
    /// of them.
    void choose_optical_depth_samples() {
        int& samples = recipe_.discretisation.optical_depth_samples_per_octave;
        const double highest = std::isinf(recipe_.optical_depth.max)
                                   ? recipe_.discretisation.deepest_optical_depth
                                   : recipe_.optical_depth.max;
        if (samples || ladder_.octaves == 0) return;
        if (recipe_.optical_depth.min == highest) {
            samples = 1;
            return;
        }
        constexpr int fine = 12;
        const int octaves = std::max(
            1, static_cast<int>(std::ceil(std::log2(highest / recipe_.optical_depth.min))));
        const double lowest = std::ldexp(highest, -octaves);
        std::vector<Solutions> of_step(fine);
        for (int step = 0; step < fine; ++step)
            of_step[static_cast<std::size_t>(step)] =
                solve(albedos_, mu_,
                      {lowest * std::exp2(static_cast<double>(step) / fine),
                       octaves + (step == 0 ? 1 : 0), false},
                      solver_);
        auto at = [&](std::size_t a, int depth) -> const LayerSolution& {
            return of_step[static_cast<std::size_t>(depth % fine)][a]
                          [static_cast<std::size_t>(depth / fine)];
        };
        samples = choose("optical_depth_samples_per_octave", {1, 2, 3, 4, 6}, [&](int candidate) {
            const int stride = fine / candidate, count = candidate * octaves + 1;
            const AxisView axis = make_axis(AxisScale::logarithmic, lowest, highest, count).view();
            return depth_error(
                count - 1, axis, [&](int cell) { return cell * stride + stride / 2; },
                [&](std::size_t a, int sample) -> const LayerSolution& {
                    return at(a, sample * stride);
                },
                at);
        });
    }

    /// Interpolation along optical depth, samples divided by the diffusion scales.
    template <class TestDepth, class Sample, class Exact>
    double depth_error(int cells, const AxisView& axis, TestDepth test_depth, Sample sample,
                       Exact exact) const {
        const double q = extrapolation_length(recipe_.phase_function);
        std::vector<Errors> of_albedo(albedos_.size());
        parallel_for(static_cast<int>(albedos_.size()), options_.threads, [&](int index) {
            const auto a = static_cast<std::size_t>(index);
            const double k = exponent(albedos_[a]);
            for (int cell = 0; cell < cells; ++cell) {
                const LayerSolution& target = exact(a, test_depth(cell));
                const Stencil stencil = axis.stencil(target.optical_depth);
                for_sides(target, [&](auto value, double floor, Side side) {
                    double weight[4];
                    for (int p = 0; p < 4; ++p) {
                        if (stencil.weight[p] == 0) {
                            weight[p] = 0;
                            continue;
                        }
                        const double tau = sample(a, stencil.first + p).optical_depth;
                        auto scale = [&](double depth) {
                            return side == Side::reflection ? reflection_scale(depth, k, q)
                                                            : transmission_scale(depth, k, q);
                        };
                        weight[p] = stencil.weight[p] * scale(target.optical_depth) / scale(tau);
                    }
                    for_pairs([&](int i, int j) {
                        for (double phi : azimuths_) {
                            const SolvedValue expected = value(target, i, j, phi);
                            double found = 0;
                            for (int p = 0; p < 4; ++p)
                                if (weight[p] != 0)
                                    found +=
                                        weight[p] *
                                        intercepted_share(target.optical_depth, target.mu(i)) *
                                        intercepted_share(target.optical_depth, target.mu(j)) /
                                        intercepted_share(
                                            sample(a, stencil.first + p).optical_depth,
                                            target.mu(i)) /
                                        intercepted_share(
                                            sample(a, stencil.first + p).optical_depth,
                                            target.mu(j)) *
                                        value(sample(a, stencil.first + p), i, j, phi).multiple;
                            of_albedo[a].add(std::abs(found - expected.multiple) /
                                             std::max(expected.total, floor));
                        }
                    });
                });
            }
        });
        Errors all;
        for (const Errors& errors : of_albedo) all.add(errors);
        return all.quantile();
    }

    /// Albedos at `fine` even steps of sqrt(1 - w); a candidate's own samples are every (fine /
    /// intervals)-th.
    void choose_albedo_samples() {
        int& samples = recipe_.discretisation.albedo_samples;
        if (samples) return;
        if (recipe_.albedo.min == recipe_.albedo.max) {
            samples = 1;
            return;
        }
        constexpr int fine = 120;
        const Axis fine_axis = albedo_axis(recipe_.albedo, fine + 1);
        DepthLadder ladder = ladder_;
        if (recipe_.discretisation.deepest_optical_depth)
            ladder.octaves = 1 + static_cast<int>(std::lround(std::log2(
                                     recipe_.discretisation.deepest_optical_depth / ladder.first)));
        const std::vector<double> mu{0.1, 0.3, 0.6, 1.0, 0.0049, 0.03};
        const Solutions solutions = solve(fine_axis.values, mu, ladder, solver_);
        const double q = extrapolation_length(recipe_.phase_function);
        std::vector<double> exponents;
        for (double w : fine_axis.values) exponents.push_back(exponent(w));
        samples = choose(
            "albedo_samples", {4, 5, 6, 7, 9, 11, 13, 16, 21, 25, 31, 41, 61}, [&](int candidate) {
                const int intervals = candidate - 1, stride = fine / intervals;
                const AxisView axis = albedo_axis(recipe_.albedo, candidate).view();
                const int depths = static_cast<int>(solutions[0].size());
                std::vector<Errors> of_cell(static_cast<std::size_t>(intervals * depths));
                parallel_for(intervals * depths, options_.threads, [&](int cell) {
                    const auto d = static_cast<std::size_t>(cell % depths);
                    const auto test =
                        static_cast<std::size_t>((cell / depths) * stride + stride / 2);
                    const LayerSolution& target = solutions[test][d];
                    const Stencil stencil = axis.stencil(target.albedo);
                    double k = 0;
                    for (int p = 0; p < 4; ++p)
                        if (stencil.weight[p] != 0)
                            k += stencil.weight[p] *
                                 exponents[static_cast<std::size_t>((stencil.first + p) * stride)];
                    for_sides(target, [&](auto value, double floor, Side side) {
                        for (int i = 0; i < static_cast<int>(mu.size()); ++i)
                            for (int j = i; j < static_cast<int>(mu.size()); ++j)
                                for (double phi : azimuths_) {
                                    const SolvedValue expected = value(target, i, j, phi);
                                    double found = 0;
                                    for (int p = 0; p < 4; ++p) {
                                        if (stencil.weight[p] == 0) continue;
                                        const auto at =
                                            static_cast<std::size_t>((stencil.first + p) * stride);
                                        auto scale = [&](double exponent) {
                                            return side == Side::reflection
                                                       ? reflection_scale(target.optical_depth,
                                                                          exponent, q)
                                                       : transmission_scale(target.optical_depth,
                                                                            exponent, q);
                                        };
                                        const double own = scale(exponents[at]);
                                        if (own > 1e-35 && solutions[at][d].albedo > 0)
                                            found += stencil.weight[p] * target.albedo /
                                                     solutions[at][d].albedo * scale(k) / own *
                                                     value(solutions[at][d], i, j, phi).multiple;
                                    }
                                    of_cell[static_cast<std::size_t>(cell)].add(
                                        std::abs(found - expected.multiple) /
                                        std::max(expected.total, floor));
                                }
                    });
                });
                Errors all;
                for (const Errors& errors : of_cell) all.add(errors);
                return all.quantile();
            });
    }

    double exponent(double albedo) const {
        return compute_diffusion_exponent(recipe_.phase_function, albedo);
    }

    Recipe recipe_;
    const BakeOptions& options_;
    const double share_;
    SolverOptions solver_;
    std::vector<double> albedos_, mu_;
    const std::vector<double> azimuths_{0.15, 0.7, 1.3, 1.9, 2.5, 3.1};
    DepthLadder ladder_;
    Solutions probes_;
};

}  // namespace

Recipe resolve_to(const Recipe& recipe, double strictness, const BakeOptions& options) {
    return Resolver(recipe, strictness, options).resolve();
}

}  // namespace stratus
