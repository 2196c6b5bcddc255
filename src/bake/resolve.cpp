// Choosing nodes, modes and samples by measuring what each costs in accuracy.
//
// All measurements are made on one set of probes: directions between grazing and normal, a few
// azimuths, albedos over the range, every octave of depth (and infinity). Errors are relative as in
// accuracy.h; a choice stands when 99.9 % of the probes are within its share of the tolerance.
#include "resolve.h"

#include <stratus/bake/accuracy.h>
#include <stratus/bake/parallel.h>
#include <stratus/runtime/constants.h>
#include <stratus/runtime/diffusion.h>
#include <stratus/runtime/number_text.h>

#include "axes.h"
#include "piece_of_work.h"

#include <algorithm>
#include <cmath>

namespace stratus {

namespace {

/// The probes' directions, and what does not change with depth and albedo.
class Angles {
  public:
    Angles(const PhaseFunction& phase_function, const LowerBoundary& boundary,
           std::vector<double> cosines, std::vector<double> azimuths)
        : mu(std::move(cosines)), azimuth(std::move(azimuths)) {
        for (double in : mu)
            for (double out : mu)
                for (double phi : azimuth) {
                    under.push_back(boundary_phase_value(boundary, {in, out, phi}));
                    reflected.push_back(
                        phase_function(cos_scattering_angle_reflected({in, out, phi})));
                    transmitted.push_back(
                        phase_function(cos_scattering_angle_transmitted({in, out, phi})));
                }
    }

    std::size_t at(int i, int j, int k) const {
        return (static_cast<std::size_t>(i) * mu.size() + static_cast<std::size_t>(j)) *
                   azimuth.size() +
               static_cast<std::size_t>(k);
    }

    std::vector<double> mu, azimuth;
    std::vector<double> reflected, transmitted, under;  // phi over (mu, mu, azimuth); below.h
};

/// One side of a solved layer at all probe directions.
struct SideValues {
    std::vector<double> multiple, total;  // over (mu, mu, azimuth)
    double floor = 0;                     // accuracy.h
};

/// A solved layer and its values at the probe directions.
struct Cell {
    LayerSolution solution;
    SideValues reflection, transmission;

    const SideValues& side(Side which) const {
        return which == Side::reflection ? reflection : transmission;
    }
};

using Cells = std::vector<std::vector<Cell>>;  // [albedo][depth]

/// Light scattered once in what lies beneath: what truncation adds to its closed form once(mu, mu),
/// both per unit of phase function.
struct BoundaryOnce {
    Eigen::MatrixXd correction;
    const std::vector<double>& phase;
    std::function<double(double, double)> once;
};

template <class Single, class Cosine, class Correction>
SideValues values_of(const LayerSolution& layer, const std::vector<Eigen::MatrixXd>& modes,
                     const Angles& angles, const std::vector<double>& phase, Single single,
                     Cosine cos_scattering_angle, Correction correction,
                     const BoundaryOnce* boundary = nullptr) {
    SideValues values;
    values.multiple.resize(angles.reflected.size());
    values.total.resize(angles.reflected.size());
    const auto count = static_cast<Eigen::Index>(modes.size());
    Eigen::MatrixXd cosines(static_cast<Eigen::Index>(angles.azimuth.size()), count);
    for (Eigen::Index k = 0; k < cosines.rows(); ++k)
        for (Eigen::Index m = 0; m < count; ++m)
            cosines(k, m) = (m ? 2 : 1) * std::cos(static_cast<double>(m) *
                                                   angles.azimuth[static_cast<std::size_t>(k)]);
    Eigen::VectorXd series(count), sum(cosines.rows());
    std::vector<double> directions(angles.azimuth.size());
    const int n = static_cast<int>(angles.mu.size());
    for (int i = 0; i < n; ++i)
        for (int j = i; j < n; ++j) {
            for (Eigen::Index m = 0; m < count; ++m)
                series(m) = modes[static_cast<std::size_t>(m)](i, j);
            sum.noalias() = cosines * series;
            const PeakCorrection correction_here = correction(i, j);
            for (std::size_t k = 0; k < directions.size(); ++k)
                directions[k] = cos_scattering_angle({layer.mu(i), layer.mu(j), angles.azimuth[k]});
            const std::vector<double> scattered_again =
                sum_legendre(correction_here.legendre, directions);
            const double once =
                single(1, layer.albedo, layer.optical_depth, layer.mu(i), layer.mu(j));
            for (int k = 0; k < static_cast<int>(sum.size()); ++k) {
                const std::size_t at = angles.at(i, j, k), mirrored = angles.at(j, i, k);
                double multiple = sum(k) + correction_here.single * phase[at] +
                                  scattered_again[static_cast<std::size_t>(k)];
                double total = once * phase[at];
                if (boundary) {
                    multiple += boundary->correction(i, j) * boundary->phase[at];
                    total += boundary->once(layer.mu(i), layer.mu(j)) * boundary->phase[at];
                }
                values.multiple[at] = values.multiple[mirrored] = multiple;
                values.total[at] = values.total[mirrored] = multiple + total;
            }
        }
    return values;
}

using Errors = std::vector<double>;

/// What a resolver chooses, with the deepest optical depth.
constexpr int Discretisation::*counts[] = {
    &Discretisation::nodes,          &Discretisation::modes,
    &Discretisation::mu_samples,     &Discretisation::azimuth_samples,
    &Discretisation::albedo_samples, &Discretisation::optical_depth_samples_per_octave};

class Resolver {
  public:
    Resolver(const Recipe& recipe, double strictness, const BakeOptions& options)
        : recipe_(recipe),
          options_(options),
          share_(recipe.tolerance * strictness),
          q_(extrapolation_length(recipe.phase_function, recipe.lower_boundary)) {
        const double most = std::sqrt(1 - recipe.albedo.min),
                     least = std::sqrt(1 - recipe.albedo.max);
        for (double at : {0.0, 0.04, 0.15, 0.4, 0.75, 1.0}) {
            const double s = least + at * (most - least);
            albedos_.push_back(std::clamp(1 - s * s, recipe.albedo.min, recipe.albedo.max));
            if (recipe.albedo.min == recipe.albedo.max) break;
        }
        exponents_ = decay_exponents(recipe, albedos_);
        for (double mu : floor_cosines()) mu_.push_back(mu);
        for (double x : {0.035, 0.11, 0.18, 0.25, 0.39, 0.46, 0.61, 0.68, 0.86, 0.93})
            mu_.push_back(x * x);
    }

    Recipe resolve() {
        solver_.scheme = recipe_.discretisation.scheme;
        solver_.orders = recipe_.orders;
        solver_.mode_tolerance = 1e-3 * recipe_.tolerance;
        choose_depth_range();
        void (Resolver::*const choices[])() = {
            &Resolver::choose_nodes,         &Resolver::choose_modes,
            &Resolver::choose_mu_samples,    &Resolver::choose_azimuth_samples,
            &Resolver::choose_deepest,       &Resolver::choose_optical_depth_samples,
            &Resolver::choose_albedo_samples};
        const auto piece = [](std::size_t choice) { return "choice " + std::to_string(choice); };
        // Going on: a choice that is made already is like one that the recipe made.
        std::size_t made = std::size(choices);
        while (made > 0 && !take_choices(piece(made - 1))) --made;
        if (made == std::size(choices)) return recipe_;
        std::size_t n = 0;
        for (const auto choose : choices) {
            if (options_.progress)
                options_.progress(static_cast<double>(n) / static_cast<double>(std::size(choices)),
                                  "measuring");
            (this->*choose)();
            if (n >= made) keep_choices(piece(n));
            ++n;
        }
        return recipe_;
    }

    /// Samples along the mixture of a recipe of which all else is resolved.
    static int choose_mixture_samples(const Recipe& recipe, double strictness,
                                      const BakeOptions& options) {
        constexpr std::size_t fine = 24;  // steps; a candidate's own are several of them
        const std::vector<double> shares = mixture_axis(*recipe.mixture, fine + 1).values;
        std::vector<Resolver> at_share;
        for (const double share : shares)
            at_share.emplace_back(at_mixture(recipe, share), strictness, options);
        std::vector<double> mu = floor_cosines();
        mu.insert(mu.end(), {0.0049, 0.03});
        std::vector<Angles> few_angles;
        std::vector<Cells> cells;
        for (Resolver& at : at_share) {
            at.solver_.nodes = at.recipe_.discretisation.nodes;
            at.solver_.modes = at.recipe_.discretisation.modes;
            at.choose_depth_range();
            few_angles.push_back(at.angles(mu));
            cells.push_back(
                at.solve(at.albedos_, at.ladder_to_deepest(), few_angles.back(), at.solver_));
            for (auto& of_albedo : cells.back())
                for (Cell& cell : of_albedo)  // a hundred megabytes otherwise
                    cell.solution.reflection_modes = cell.solution.transmission_modes = {};
        }
        const Resolver& any = at_share.front();
        const std::size_t albedos = any.albedos_.size();
        return any.choose("mixture_samples", {2, 3, 4, 5, 7, 9, 13}, [&](int candidate) {
            const auto intervals = static_cast<std::size_t>(candidate - 1);
            const std::size_t stride = fine / intervals;
            const AxisView axis = mixture_axis({0, 1}, candidate).view();
            return any.measure_cells(
                intervals * albedos, cells[0][0].size(),
                [&](std::size_t cell, std::size_t d, Errors& errors) {
                    const std::size_t a = cell % albedos;
                    const std::size_t test = cell / albedos * stride + stride / 2;
                    const Stencil stencil =
                        axis.stencil(static_cast<double>(test) / static_cast<double>(fine));
                    const auto sample = [&](int p) {
                        return std::min(static_cast<std::size_t>(stencil.first + p), intervals) *
                               stride;
                    };
                    const Resolver& here = at_share[test];
                    const Cell& target = cells[test][a][d];
                    // As lookups have it: deep layers transmit exponentially less.
                    const auto fall = [&](double exponent) {
                        return transmission_scale(target.solution.optical_depth, exponent, any.q_);
                    };
                    double k = 0;
                    for (int p = 0; p < stencil_size; ++p)
                        k += double{stencil.weight[p]} * at_share[sample(p)].exponents_[a];
                    double share[2][stencil_size];  // reflection, transmission
                    for (int p = 0; p < stencil_size; ++p) {
                        const double sampled = fall(at_share[sample(p)].exponents_[a]);
                        share[0][p] = double{stencil.weight[p]};
                        share[1][p] = sampled > 0 ? share[0][p] * fall(k) / sampled : 0;
                    }
                    const Angles& angles = few_angles[test];
                    here.compare(
                        target, static_cast<int>(angles.mu.size()), angles, errors,
                        [&](Side side, int i, int j, int n) {
                            double found = 0;
                            for (int p = 0; p < stencil_size; ++p)
                                found +=
                                    share[side == Side::transmission][p] *
                                    cells[sample(p)][a][d].side(side).multiple[angles.at(i, j, n)];
                            return found;
                        });
                });
        });
    }

  private:
    // ---- what is finished already --------------------------------------------------------------

    bool take_choices(const std::string& piece) {
        Discretisation& d = recipe_.discretisation;
        const auto finished = find_finished<double>(options_.log, piece, std::size(counts) + 1);
        if (!finished) return false;
        for (std::size_t n = 0; n < std::size(counts); ++n)
            d.*counts[n] = static_cast<int>((*finished)[n]);
        d.deepest_optical_depth = finished->back();
        return true;
    }

    void keep_choices(const std::string& piece) const {
        std::vector<double> all;
        for (const auto count : counts) all.push_back(recipe_.discretisation.*count);
        all.push_back(recipe_.discretisation.deepest_optical_depth);
        keep_finished(options_.log, piece, all);
    }

    // ---- what is compared ----------------------------------------------------------------------

    /// Adds error(side, i, j, k) of all pairs of the first `directions` cosines and all azimuths,
    /// on both sides that matter, relative to the total of `expected`.
    template <class Found>
    void compare(const Cell& expected, int directions, const Angles& angles, Errors& errors,
                 Found found) const {
        for (const Side side : {Side::reflection, Side::transmission}) {
            if (side == Side::reflection
                    ? !recipe_.reflection
                    : !recipe_.transmission || std::isinf(expected.solution.optical_depth))
                continue;
            const SideValues& values = expected.side(side);
            for (int i = 0; i < directions; ++i)
                for (int j = i; j < directions; ++j)
                    for (int k = 0; k < static_cast<int>(angles.azimuth.size()); ++k) {
                        const std::size_t at = angles.at(i, j, k);
                        errors.push_back(std::abs(found(side, i, j, k) - values.multiple[at]) /
                                         std::max(values.total[at], values.floor));
                    }
        }
    }

    /// 99.9 % of the errors that measure(albedo, depth, errors) adds for all albedos and depths.
    template <class Measure>
    double measure_cells(std::size_t albedos, std::size_t depths, Measure measure) const {
        std::vector<Errors> of_cell(albedos * depths);
        parallel_for(static_cast<int>(of_cell.size()), options_.threads, [&](int cell) {
            stop_if_asked(options_.log);
            const auto at = static_cast<std::size_t>(cell);
            measure(at / depths, at % depths, of_cell[at]);
        });
        Errors all;
        for (const Errors& errors : of_cell) all.insert(all.end(), errors.begin(), errors.end());
        return error_quantile(all, 0.999);
    }

    // What samples are divided by before they are interpolated (lookup.h).

    bool divides() const { return !recipe_.lower_boundary.is_present(); }

    double intercepted(double optical_depth, double mu) const {
        return divides() ? intercepted_share(optical_depth, mu) : 1;
    }

    double scale(Side side, double optical_depth, double exponent) const {
        if (!divides()) return 1;
        return side == Side::reflection ? reflection_scale(optical_depth, exponent, q_)
                                        : transmission_scale(optical_depth, exponent, q_);
    }

    int probe_count() const { return static_cast<int>(mu_.size()); }

    // ---- solving the probes --------------------------------------------------------------------

    Cells solve(const std::vector<double>& albedos, const DepthLadder& ladder, const Angles& angles,
                const SolverOptions& solver) const {
        // Eight albedos fill the lanes of a pack; few albedos are split so that no thread is idle.
        const std::size_t chunk = albedos.size() >= 16 ? 8 : 1;
        const auto chunks = static_cast<int>((albedos.size() + chunk - 1) / chunk);
        Cells cells(albedos.size());
        parallel_for(chunks, options_.threads, [&](int c) {
            stop_if_asked(options_.log);
            const std::size_t first = static_cast<std::size_t>(c) * chunk;
            const std::size_t last = std::min(albedos.size(), first + chunk);
            auto solved = solve_ladder(recipe_.phase_function,
                                       {albedos.begin() + static_cast<std::ptrdiff_t>(first),
                                        albedos.begin() + static_cast<std::ptrdiff_t>(last)},
                                       ladder, angles.mu, solver, recipe_.lower_boundary);
            for (std::size_t a = first; a < last; ++a)
                for (LayerSolution& solution : solved[a - first])
                    cells[a].push_back(evaluate(std::move(solution), angles));
        });
        return cells;
    }

    Cell evaluate(LayerSolution solution, const Angles& angles) const {
        Cell cell;
        if (recipe_.reflection) {
            const BoundaryOnce boundary{
                solution.boundary_correction(), angles.under, [&](double in, double out) {
                    return single_reflection_of_boundary(recipe_.lower_boundary, 1,
                                                         solution.optical_depth, in, out);
                }};
            cell.reflection = values_of(
                solution, solution.reflection_modes, angles, angles.reflected, single_reflection,
                cos_scattering_angle_reflected,
                [&](int i, int j) { return solution.reflection_correction(i, j); },
                recipe_.lower_boundary.is_present() ? &boundary : nullptr);
            cell.reflection.floor = reflection_floor(solution);
        }
        if (recipe_.transmission) {
            cell.transmission =
                values_of(solution, solution.transmission_modes, angles, angles.transmitted,
                          single_transmission, cos_scattering_angle_transmitted,
                          [&](int i, int j) { return solution.transmission_correction(i, j); });
            cell.transmission.floor = transmission_floor(solution);
        }
        cell.solution = std::move(solution);
        return cell;
    }

    Angles angles(const std::vector<double>& mu) const {
        return {recipe_.phase_function, recipe_.lower_boundary, mu, azimuths_};
    }

    void choose_depth_range() {
        const Range range = recipe_.optical_depth;
        if (std::isinf(range.min)) {
            ladder_ = {1, 0, true};
            return;
        }
        // Infinite tables are probed to where the law of diffusion has long taken over.
        const double reduced = 1 - recipe_.phase_function.asymmetry();
        const double highest =
            std::isinf(range.max) ? std::max(range.min, 200 / reduced) : range.max;
        const int octaves = static_cast<int>(std::floor(std::log2(highest / range.min) + 1e-9));
        ladder_ = {std::isinf(range.max) ? range.min : std::ldexp(range.max, -octaves), octaves + 1,
                   std::isinf(range.max)};
    }

    /// The octaves that samples will have.
    DepthLadder ladder_to_deepest() const {
        DepthLadder ladder = ladder_;
        if (recipe_.discretisation.deepest_optical_depth > 0)
            ladder.octaves = 1 + static_cast<int>(std::lround(std::log2(
                                     recipe_.discretisation.deepest_optical_depth / ladder.first)));
        return ladder;
    }

    // ---- the choices ---------------------------------------------------------------------------

    void say(const std::string& what, double error, const char* of) const {
        if (options_.note)
            options_.note(what + ": " + of + " " + short_number(error) + " (99.9 % of probes)");
    }

    /// First of the ascending candidates whose error is within the share, by bisection; the last if
    /// none is.
    template <class Measure>
    int choose(const std::string& what, const std::vector<int>& candidates, Measure measure) const {
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
        say(what + " " + std::to_string(candidates[high]), error,
            error <= share_ ? "interpolation misses"
                            : "the most that is tried; interpolation misses");
        return candidates[high];
    }

    void choose_nodes() {
        int& nodes = recipe_.discretisation.nodes;
        const Angles probe_angles = angles(mu_);
        if (nodes) {
            solver_.nodes = nodes;
            probes_ = solve(albedos_, ladder_, probe_angles, solver_);
            return;
        }
        const std::vector<int> candidates{4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 80};
        for (const int candidate : candidates) {
            solver_.nodes = candidate;
            Cells finer = solve(albedos_, ladder_, probe_angles, solver_);
            if (!probes_.empty()) {
                const double error = measure_cells(
                    albedos_.size(), probes_[0].size(),
                    [&](std::size_t a, std::size_t d, Errors& errors) {
                        compare(
                            finer[a][d], probe_count(), probe_angles, errors,
                            [&](Side side, int i, int j, int k) {
                                return probes_[a][d].side(side).multiple[probe_angles.at(i, j, k)];
                            });
                    });
                if (error <= 0.2 * share_) {
                    say("nodes " + std::to_string(nodes), error, "more nodes change");
                    break;
                }
                if (candidate == candidates.back())
                    say("nodes " + std::to_string(candidate), error,
                        "the most that is tried; half as many change");
            }
            nodes = candidate;
            probes_ = std::move(finer);
        }
        solver_.nodes = nodes;
    }

    /// Modes from which on all others together stay below a twentieth of the share.
    void choose_modes() {
        int& modes = recipe_.discretisation.modes;
        if (!modes) {
            int low = 1, high = static_cast<int>(probes_[0][0].solution.reflection_modes.size());
            double error = 0;
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
            say("modes " + std::to_string(modes), error, "all higher ones add");
        }
        solver_.modes = modes;
    }

    double modes_error(int kept) const {
        const Angles probe_angles = angles(mu_);
        return measure_cells(
            albedos_.size(), probes_[0].size(), [&](std::size_t a, std::size_t d, Errors& errors) {
                const Cell& cell = probes_[a][d];
                compare(cell, probe_count(), probe_angles, errors,
                        [&](Side side, int i, int j, int k) {
                            const auto& modes = side == Side::reflection
                                                    ? cell.solution.reflection_modes
                                                    : cell.solution.transmission_modes;
                            double tail = 0;
                            for (auto m = static_cast<std::size_t>(kept); m < modes.size(); ++m)
                                tail += 2 * std::abs(modes[m](i, j));
                            return cell.side(side).multiple[probe_angles.at(i, j, k)] + tail;
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
        const Axis axis = mu_axis(samples);
        const AxisView view = axis.view();
        std::vector<double> mu = mu_;
        mu.insert(mu.end(), axis.values.begin(), axis.values.end());
        const Angles all = angles(mu);
        const Cells cells = solve(albedos_, ladder_, all, solver_);
        std::vector<Stencil> stencils;
        for (double probe : mu_) stencils.push_back(view.stencil(probe));
        return measure_cells(
            albedos_.size(), cells[0].size(), [&](std::size_t a, std::size_t d, Errors& errors) {
                const Cell& cell = cells[a][d];
                std::vector<double> shares;
                for (double cosine : mu)
                    shares.push_back(intercepted(cell.solution.optical_depth, cosine));
                auto weight = [&](int probe, int p) {
                    const Stencil& stencil = stencils[static_cast<std::size_t>(probe)];
                    const auto sample = static_cast<std::size_t>(probe_count() + stencil.first + p);
                    return stencil.weight[p] * shares[static_cast<std::size_t>(probe)] /
                           shares[sample];
                };
                compare(cell, probe_count(), all, errors, [&](Side side, int i, int j, int k) {
                    const int in = probe_count() + stencils[static_cast<std::size_t>(i)].first;
                    const int out = probe_count() + stencils[static_cast<std::size_t>(j)].first;
                    double found = 0;
                    for (int p = 0; p < 4; ++p)
                        for (int q = 0; q < 4; ++q)
                            found += weight(i, p) * weight(j, q) *
                                     cell.side(side).multiple[all.at(in + p, out + q, k)];
                    return found;
                });
            });
    }

    void choose_azimuth_samples() {
        int& samples = recipe_.discretisation.azimuth_samples;
        if (samples) return;
        if (recipe_.phase_function.is_isotropic() &&
            (recipe_.lower_boundary.kind != LowerBoundary::Kind::layer ||
             recipe_.lower_boundary.phase_function.is_isotropic())) {
            samples = 1;
            return;
        }
        samples = choose("azimuth_samples",
                         {5, 7, 9, 11, 13, 15, 17, 19, 21, 25, 29, 33, 37, 41, 49, 57, 65, 81, 97},
                         [&](int candidate) { return azimuth_error(candidate); });
    }

    double azimuth_error(int samples) const {
        std::vector<double> tests;
        // No candidate has a sample at one of these.
        for (int n = 0; n < 16; ++n) tests.push_back(pi * (n + 0.37) / 16);
        const Axis axis = azimuth_axis(samples);
        const AxisView view = axis.view();
        const Angles at_tests(recipe_.phase_function, recipe_.lower_boundary, mu_, tests);
        const Angles at_samples(recipe_.phase_function, recipe_.lower_boundary, mu_, axis.values);
        std::vector<Stencil> stencils;
        for (double phi : tests) stencils.push_back(view.stencil(phi));
        return measure_cells(
            albedos_.size(), probes_[0].size(), [&](std::size_t a, std::size_t d, Errors& errors) {
                const Cell target = evaluate(probes_[a][d].solution, at_tests);
                const Cell sampled = evaluate(probes_[a][d].solution, at_samples);
                compare(
                    target, probe_count(), at_tests, errors, [&](Side side, int i, int j, int k) {
                        const Stencil& stencil = stencils[static_cast<std::size_t>(k)];
                        double found = 0;
                        for (int p = 0; p < 4; ++p)
                            found +=
                                stencil.weight[p] *
                                sampled.side(side).multiple[at_samples.at(i, j, stencil.first + p)];
                        return found;
                    });
            });
    }

    /// First depth of the ladder beyond which the law of diffusion bridges the way to infinity.
    void choose_deepest() {
        double& deepest = recipe_.discretisation.deepest_optical_depth;
        if (!ladder_.to_infinity || ladder_.octaves == 0 || deepest > 0) return;
        double error = 0;
        std::size_t last = 0;
        for (; last + 2 < static_cast<std::size_t>(ladder_.octaves); ++last) {
            error = infinity_error(last);
            if (error <= share_) break;
        }
        deepest = std::ldexp(ladder_.first, static_cast<int>(last));
        say("deepest finite optical_depth " + short_number(deepest), error,
            "the law of diffusion beyond misses");
    }

    double infinity_error(std::size_t last) const {
        const Angles probe_angles = angles(mu_);
        const std::size_t beyond =
            probes_[0].size() - 2 - last;  // finite depths deeper than `last`
        return measure_cells(
            albedos_.size(), beyond, [&](std::size_t a, std::size_t d, Errors& errors) {
                const Cell &target = probes_[a][last + 1 + d], &from = probes_[a][last],
                           &limit = probes_[a].back();
                const double k = exponents_[a];
                const double tau = target.solution.optical_depth,
                             tau_last = from.solution.optical_depth;
                const double left = reflection_deficit(tau_last, k, q_),
                             passed = transmission_scale(tau_last, k, q_);
                const double share = left > 0 ? reflection_deficit(tau, k, q_) / left : 0;
                const double fall = passed > 1e-35 ? transmission_scale(tau, k, q_) / passed : 0;
                compare(target, probe_count(), probe_angles, errors,
                        [&](Side side, int i, int j, int n) {
                            const std::size_t at = probe_angles.at(i, j, n);
                            const double near = from.side(side).multiple[at];
                            if (side == Side::transmission) return fall * near;
                            const double far = limit.side(side).multiple[at];
                            return far + share * (near - far);
                        });
            });
    }

    /// Depths at `fine` steps an octave; a candidate's own samples are every (fine / candidate)-th
    /// of them.
    void choose_optical_depth_samples() {
        int& samples = recipe_.discretisation.optical_depth_samples_per_octave;
        const double lowest_asked = recipe_.optical_depth.min;
        const double highest = std::isinf(recipe_.optical_depth.max)
                                   ? recipe_.discretisation.deepest_optical_depth
                                   : recipe_.optical_depth.max;
        if (samples || ladder_.octaves == 0) return;
        if (lowest_asked >= highest) {
            samples = 1;
            return;
        }
        constexpr int fine = 12;
        const int octaves =
            std::max(1, static_cast<int>(std::ceil(std::log2(highest / lowest_asked))));
        const double lowest = std::ldexp(highest, -octaves);
        const Angles probe_angles = angles(mu_);
        std::vector<Cells> of_step;
        for (int step = 0; step < fine; ++step)
            of_step.push_back(solve(albedos_,
                                    {lowest * std::exp2(static_cast<double>(step) / fine),
                                     octaves + (step == 0 ? 1 : 0), false},
                                    probe_angles, solver_));
        auto at = [&](std::size_t a, int depth) -> const Cell& {
            return of_step[static_cast<std::size_t>(depth % fine)][a]
                          [static_cast<std::size_t>(depth / fine)];
        };
        samples = choose("optical_depth_samples_per_octave", {1, 2, 3, 4, 6}, [&](int candidate) {
            const int stride = fine / candidate, intervals = candidate * octaves;
            const AxisView axis =
                make_axis(AxisScale::logarithmic, lowest, highest, intervals + 1).view();
            return measure_cells(
                albedos_.size(), static_cast<std::size_t>(intervals),
                [&](std::size_t a, std::size_t interval, Errors& errors) {
                    const Cell& target = at(a, static_cast<int>(interval) * stride + stride / 2);
                    const Stencil stencil = axis.stencil(target.solution.optical_depth);
                    compare_depths(
                        target, stencil, errors, probe_angles, exponents_[a],
                        [&](int p) -> const Cell& { return at(a, (stencil.first + p) * stride); });
                });
        });
    }

    /// Cubic along optical depth, samples divided by their scales (lookup.h).
    template <class Sample>
    void compare_depths(const Cell& target, const Stencil& stencil, Errors& errors,
                        const Angles& probe_angles, double exponent, Sample sample) const {
        const double tau = target.solution.optical_depth;
        std::vector<double> share(4 *
                                  mu_.size());  // along one direction, of each of the four samples
        for (int p = 0; p < 4; ++p)
            if (stencil.weight[p] != 0)
                for (std::size_t i = 0; i < mu_.size(); ++i)
                    share[static_cast<std::size_t>(p) * mu_.size() + i] =
                        intercepted(tau, mu_[i]) /
                        intercepted(sample(p).solution.optical_depth, mu_[i]);
        compare(target, probe_count(), probe_angles, errors, [&](Side side, int i, int j, int k) {
            double found = 0;
            for (int p = 0; p < 4; ++p) {
                if (stencil.weight[p] == 0) continue;
                const double* along = share.data() + static_cast<std::size_t>(p) * mu_.size();
                found += stencil.weight[p] * along[i] * along[j] * scale(side, tau, exponent) /
                         scale(side, sample(p).solution.optical_depth, exponent) *
                         sample(p).side(side).multiple[probe_angles.at(i, j, k)];
            }
            return found;
        });
    }

    /// Albedos at `fine` even steps of sqrt(1 - w); a candidate's own samples are every so many of
    /// them.
    void choose_albedo_samples() {
        int& samples = recipe_.discretisation.albedo_samples;
        if (samples) return;
        if (recipe_.albedo.min == recipe_.albedo.max) {
            samples = 1;
            return;
        }
        constexpr int fine = 120;
        const std::vector<double> albedos = albedo_axis(recipe_.albedo, fine + 1).values;
        std::vector<double> mu = floor_cosines();
        mu.insert(mu.end(), {0.0049, 0.03});
        const Angles few_angles = angles(mu);
        const Cells cells = solve(albedos, ladder_to_deepest(), few_angles, solver_);
        const std::vector<double> exponents = decay_exponents(recipe_, albedos);
        samples = choose(
            "albedo_samples", {4, 5, 6, 7, 9, 11, 13, 16, 21, 25, 31, 41, 61}, [&](int candidate) {
                const int intervals = candidate - 1, stride = fine / intervals;
                const AxisView axis = albedo_axis(recipe_.albedo, candidate).view();
                return measure_cells(
                    static_cast<std::size_t>(intervals), cells[0].size(),
                    [&](std::size_t interval, std::size_t d, Errors& errors) {
                        const auto test = interval * static_cast<std::size_t>(stride) +
                                          static_cast<std::size_t>(stride / 2);
                        const Cell& target = cells[test][d];
                        const Stencil stencil = axis.stencil(target.solution.albedo);
                        auto sample = [&](int p) {
                            return static_cast<std::size_t>(std::min(stencil.first + p, intervals) *
                                                            stride);
                        };
                        double k = 0;
                        for (int p = 0; p < 4; ++p) k += stencil.weight[p] * exponents[sample(p)];
                        const double tau = target.solution.optical_depth;
                        auto share = [&](Side side, int p) {
                            if (!divides()) return double{stencil.weight[p]};
                            const double own =
                                albedos[sample(p)] * scale(side, tau, exponents[sample(p)]);
                            return own > 1e-35 ? stencil.weight[p] * target.solution.albedo *
                                                     scale(side, tau, k) / own
                                               : 0.0;
                        };
                        compare(target, static_cast<int>(mu.size()), few_angles, errors,
                                [&](Side side, int i, int j, int n) {
                                    double found = 0;
                                    for (int p = 0; p < 4; ++p)
                                        found +=
                                            share(side, p) * cells[sample(p)][d]
                                                                 .side(side)
                                                                 .multiple[few_angles.at(i, j, n)];
                                    return found;
                                });
                    });
            });
    }

    Recipe recipe_;
    const BakeOptions& options_;
    const double share_;
    const double q_;  // extrapolation length
    SolverOptions solver_;
    std::vector<double> albedos_, exponents_, mu_;
    const std::vector<double> azimuths_{0.15, 0.7, 1.3, 1.9, 2.5, 3.1};
    DepthLadder ladder_;
    Cells probes_;
};

/// The finer of two ways to sample, axis by axis.
Discretisation finer(const Discretisation& a, const Discretisation& b) {
    Discretisation both = a;
    for (const auto count : counts) both.*count = std::max(a.*count, b.*count);
    both.deepest_optical_depth = std::max(a.deepest_optical_depth, b.deepest_optical_depth);
    return both;
}

/// What the mixtures at both ends and in the middle need serves all between them.
Recipe resolve_mixtures(const Recipe& recipe, double strictness, const BakeOptions& options) {
    const Range range = *recipe.mixture;
    const auto note = [&](double share) {
        if (options.note) options.note("mixture " + short_number(share) + ":");
    };
    Recipe resolved = recipe;
    for (const double share : {range.min, (range.min + range.max) / 2, range.max}) {
        note(share);
        BakeOptions at_share = options;
        at_share.log = part_of(options.log, "mixture " + short_number(share, 17));
        const Recipe alone = Resolver(at_mixture(recipe, share), strictness, at_share).resolve();
        resolved.discretisation = finer(resolved.discretisation, alone.discretisation);
    }
    int& samples = resolved.discretisation.mixture_samples;
    if (samples > 0) return resolved;
    const char* const piece = "mixture samples";
    if (const auto finished = find_finished<int>(options.log, piece, 1)) {
        samples = finished->front();
        return resolved;
    }
    if (options.note) options.note("all mixtures:");
    samples = Resolver::choose_mixture_samples(resolved, strictness, options);
    keep_finished(options.log, piece, std::vector<int>{samples});
    return resolved;
}

}  // namespace

Recipe resolve_to(const Recipe& recipe, double strictness, const BakeOptions& options) {
    return recipe.mixture ? resolve_mixtures(recipe, strictness, options)
                          : Resolver(recipe, strictness, options).resolve();
}

}  // namespace stratus
